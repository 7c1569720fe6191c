// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study/placement_study.h"

#include <fstream>
#include <set>

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class PlacementStudies : public ScratchTest {
 protected:
  std::string write(const std::string& text) {
    std::ofstream(folder_ / "rig.yaml") << "cameras: {}\n";
    std::ofstream(folder_ / "study.yaml") << "rig: rig.yaml\n" << text;
    return path("study.yaml");
  }
  std::string fault(const std::string& text) {
    try {
      points_of(read_placement_study(write(text)));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "taken";
  }
};

TEST_F(PlacementStudies, TryEveryValueWithEveryOther) {
  const auto points = points_of(read_placement_study(
      write("parameters:\n"
            "  b_tilt: {set: [\"cameras.floor.tilt_deg={}\"], range: [10, 20], step: 5}\n"
            "  a_lens: {choices: {wide: {set: [x=1, \"y={}\"]}, narrow: {set: [x=2]}}}\n")));
  ASSERT_EQ(points.size(), 6U);
  EXPECT_THAT(points[0].values, ElementsAre("narrow", "10"));
  EXPECT_THAT(points[0].settings.set, ElementsAre("x=2", "cameras.floor.tilt_deg=10"));
  EXPECT_THAT(points[2].values, ElementsAre("narrow", "20"));
  EXPECT_THAT(points[3].settings.set, ElementsAre("x=1", "y={}", "cameras.floor.tilt_deg=10"));
}

TEST_F(PlacementStudies, DrawTheSameRigsFromTheSameSeed) {
  const std::string parameters =
      "parameters:\n"
      "  tilt: {set: [\"a={}\"], range: [10, 20]}\n"
      "  place: {set: [\"b={}\"], values: [\"[0, 0, 0.5]\", \"[0.1, 0, 0.5]\"]}\n";
  const auto once = points_of(
      read_placement_study(write(parameters + "sweep: {kind: random, rigs: 50, seed: 3}\n")));
  const auto more = points_of(
      read_placement_study(write(parameters + "sweep: {kind: random, rigs: 60, seed: 3}\n")));
  ASSERT_EQ(once.size(), 50U);
  std::set<std::string> tilts;
  std::set<std::string> places;
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].values, more[i].values);
    places.insert(once[i].values[0]);
    tilts.insert(once[i].values[1]);
    EXPECT_GE(std::stod(once[i].values[1]), 10);
    EXPECT_LT(std::stod(once[i].values[1]), 20);
  }
  EXPECT_EQ(tilts.size(), 50U);
  EXPECT_EQ(places.size(), 2U);
  const auto other = points_of(
      read_placement_study(write(parameters + "sweep: {kind: random, rigs: 50, seed: 4}\n")));
  EXPECT_NE(other[0].values, once[0].values);
}

TEST_F(PlacementStudies, AreRefusedWithThePlaceOfWhatIsWrong) {
  EXPECT_THAT(fault("parameters: {}\n"),
              HasSubstr("study.yaml:2:13: parameters: must have one at least"));
  EXPECT_THAT(fault("parameters: {t: {set: [\"a={}\"], range: [5, 5], step: 1}}\n"),
              HasSubstr("parameters.t.range: is empty; must be [low, high] with low < high"));
  EXPECT_THAT(fault("parameters: {t: {set: [\"a={}\"], range: [5, 6]}}\n"),
              HasSubstr("parameters.t.range: must have a step above 0 on a grid"));
  EXPECT_THAT(fault("parameters: {t: {set: [\"a=1\"], values: [1]}}\n"),
              HasSubstr("parameters.t.set: must be settings of the rig with {} for the value"));
  EXPECT_THAT(fault("parameters: {t: {set: [\"a={}\"]}}\n"),
              HasSubstr("parameters.t.values: missing; values, a range or choices must be given"));
  EXPECT_THAT(fault("parameters: {t: {set: [\"a={}\"], values: [1]}}\nrequire: [floor high]\n"),
              HasSubstr("require"));
  EXPECT_THAT(fault("parameters: {t: {set: [\"a={}\"], valeus: [1]}}\n"),
              HasSubstr("valeus: unknown key; did you mean values?"));
  EXPECT_THAT(fault("parameters: {t: {set: [\"a={}\"], range: [0, 1], step: 1e-9}}\n"),
              HasSubstr("parameters.t.step: must make at most 200000 values of the range"));
  EXPECT_THAT(fault("parameters:\n  t: {set: [\"a={}\"], range: [0, 1], step: 0.001}\n"
                    "  u: {set: [\"b={}\"], range: [0, 1], step: 0.001}\n"),
              AllOf(HasSubstr("a grid of 1002001 rigs; at most 200000 are tried"),
                    HasSubstr("sweep: {kind: random, rigs: 10000, seed: 1}")));
}

}  // namespace
}  // namespace panoptes
