// SPDX-License-Identifier: BSD-3-Clause
// Rigs scored and compared, as a user calls for it, and held against what they are drawn to see.
#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "sim/world/body_faces.h"
#include "tests/support/rendered_sight.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kRigs = kScenes + "rigs/";
const std::string kThree = kRigs + "front-back-floor.yaml";
const std::string kCorners = kRigs + "four-corners.yaml";

class Place : public SystemTest {
 protected:
  Said place(const std::vector<std::string>& more) {
    std::vector<std::string> words{"place"};
    words.insert(words.end(), more.begin(), more.end());
    return panoptes(words);
  }
  void expect_refused(const std::vector<std::string>& words, const std::string& why) {
    const Said said = place(words);
    EXPECT_EQ(said.status, 2) << said.err;
    EXPECT_THAT(said.err, HasSubstr(why));
    EXPECT_EQ(said.out, "");
  }
};

TEST_F(Place, ScoresOneRig) {
  const Said said = place({kThree, "--out", "one"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.out, AllOf(HasSubstr("floor mapped (m2)"), HasSubstr("more is better"),
                              HasSubstr("without back: ")));
  const auto m = metrics("one");
  EXPECT_EQ(m["outcome"], "completed");
  ASSERT_EQ(m["rigs"].size(), 1U);
  const auto& scores = m["rigs"][0]["scores"];
  EXPECT_NEAR(scores["blind"]["ahead_m"].get<double>(), 0.2, 1e-3);
  EXPECT_GT(scores["calibratability"]["rotation_deg"].get<double>(), 0);
  EXPECT_EQ(m["rigs"][0]["cameras"]["back"]["without"]["opposite"], 1.0);
  EXPECT_FALSE(cv::imread((folder_ / "work/one/floor_front-back-floor.png").string()).empty());
}

TEST_F(Place, ComparesTwo) {
  const Said said = place({kThree, kCorners, "--quick", "--out", "two"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.out, AllOf(HasSubstr("difference"), HasSubstr("better"), HasSubstr("worse"),
                              HasSubstr("the same")));
  const auto m = metrics("two");
  ASSERT_EQ(m["rigs"].size(), 2U);
  EXPECT_EQ(m["rigs"][1]["rig"], "four-corners");
  EXPECT_GT(m["rigs"][1]["scores"]["panorama"]["seen_share"].get<double>(),
            m["rigs"][0]["scores"]["panorama"]["seen_share"].get<double>());
  EXPECT_FALSE(m["rigs"][0]["scores"].contains("calibratability"));
}

TEST_F(Place, TakesSettingsOfRigRobotAndScores) {
  ASSERT_EQ(place({kThree, "--quick", "--set", "rig.cameras.floor.tilt_deg=45", "--set",
                   "robot.max_speed_mps=1.2", "--set", "scores.bus=gige", "--out", "set"})
                .status,
            0);
  const auto m = metrics("set");
  EXPECT_GT(m["rigs"][0]["scores"]["stopping"]["distance_m"].get<double>(), 1.2);
  EXPECT_EQ(m["rigs"][0]["bus"]["unit"], "Mbit/s");
  EXPECT_LT(m["rigs"][0]["scores"]["floor"]["mapped_m2"].get<double>(), 9);
}

TEST_F(Place, RefusesWhatIsNoRig) {
  expect_refused({"nowhere.yaml"}, "nowhere.yaml");
  expect_refused({kOffice}, "is a mission, not a rig; give the file of a rig, see scenes/rigs");
  expect_refused({kRigs}, "is a folder; give a rig file");
  expect_refused({kThree, "--set", "until.duration_s=3"},
                 "must begin with rig., robot. or scores.");
  expect_refused({kThree, "--set", "scores.reach=3"},
                 "--set scores.reach: unknown key; did you mean reach_m?");
  expect_refused({kThree, kCorners, kThree}, "see panoptes place --help");
  const std::string old =
      write("old.yaml",
            "cameras:\n  front: {roles: [loop_front], size_px: [320, 240], hfov_deg: 80, "
            "at_m: [0, 0, 0.79]}\n");
  expect_refused({old}, "hfov_deg: unknown key");
  const std::string none =
      write("none.yaml",
            "cameras:\n  front: {roles: [loop_front], size_px: [320, 240], at_m: [0, 0, "
            "0.79]}\n");
  expect_refused({none}, "fov_deg: missing; it must be given (or lens, or intrinsics_px)");
}

TEST_F(Place, RefusesARigThatCannotBe) {
  const std::string bad =
      write("bad.yaml",
            "cameras:\n"
            "  inside: {size_px: [320, 240], fov_deg: 80, at_m: [0, 0, 0.1]}\n"
            "  sky: {roles: [floor], size_px: [320, 240], fov_deg: 40, at_m: [0, 0, 0.7], "
            "tilt_deg: -60, floor: {}}\n");
  expect_refused({kThree, bad}, "bad.yaml: cameras.inside: is mounted inside the robot");
  expect_refused({kThree, bad}, "bad.yaml: cameras.sky: has the role floor and sees no floor");
}

TEST_F(Place, TriesAllRigsOfAStudy) {
  const std::string study = kScenes + "placements/floor-camera.yaml";
  const Said said = place({study, "--jobs", "2", "--quiet", "--out", "study"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.out, AllOf(HasSubstr("132 rigs tried"), HasSubstr("pareto"),
                              HasSubstr("stopping.margin_m >= 0: ")));
  const auto m = metrics("study");
  EXPECT_EQ(m["tried"], 132);
  EXPECT_TRUE(m["best"][0]["pareto"]);
  EXPECT_EQ(place({"study/rig_best.yaml", "--quick"}).status, 0);
  EXPECT_EQ(panoptes({"check", study, "study/rig_best.yaml"}).status, 0);
  expect_refused({study, kThree}, "is a placement study, which stands alone");
  const std::string hopeless = write(
      "hopeless.yaml", "rig: " + kThree +
                           "\nparameters: {t: {set: [\"cameras.floor.tilt_deg={}\"], values: [20, "
                           "30]}}\nrequire: [\"blind.ahead_m < 0\"]\n");
  EXPECT_EQ(place({hopeless, "--quiet"}).status, 1);
}

/// Rigs on a robot, by their scores and by what `panoptes render` draws. 50 of them:
/// tests/benchmarks/place_study
class PlaceAsDrawn : public Place {
 protected:
  void expect_as_drawn(const Body& body, std::initializer_list<int> rigs);
};

void PlaceAsDrawn::expect_as_drawn(const Body& body, std::initializer_list<int> rigs) {
  constexpr double kWithin = 0.05;
  for (const int i : rigs) {
    Rng rng = Rng(1).fork("rig " + std::to_string(i));
    const Rig rig = test::random_rig(rng, body);
    const std::filesystem::path folder = folder_ / "work" / ("rig-" + std::to_string(i));
    test::write_bare_floor(folder, rig, body);
    const Said said =
        panoptes({"render", (folder / "mission.yaml").string(), "--pose", "0,0,0", "--labels",
                  "--depth", "--quiet", "--out", (folder / "render").string()});
    ASSERT_EQ(said.status, 0) << said.err;
    int compared = 0;
    for (const auto& one : test::compare_sight(folder / "render", rig, body)) {
      EXPECT_TRUE(std::abs(one.error()) <= kWithin ||
                  std::abs(one.scored - one.rendered) <= one.pixel)
          << "rig " << i << " " << one.what << ": scored " << one.scored << ", rendered "
          << one.rendered;
      ++compared;
    }
    EXPECT_GE(compared, 2);
  }
}

TEST_F(PlaceAsDrawn, PastACylinder) { expect_as_drawn(Body(), {0, 1, 2}); }

/// An oblong base with a thick mast behind, both hollow.
constexpr const char* kTower =
    "<robot name='tower'>"
    "<link name='base'><visual><origin xyz='0.05 0 0.15'/><geometry><box size='0.5 0.3 0.3'/>"
    "</geometry></visual></link>"
    "<link name='mast'><visual><origin xyz='0 0 0.25'/><geometry>"
    "<cylinder radius='0.06' length='0.5'/></geometry></visual></link>"
    "<joint name='on' type='fixed'><parent link='base'/><child link='mast'/>"
    "<origin xyz='-0.12 0.05 0.3'/></joint></robot>";

TEST_F(PlaceAsDrawn, PastARobotOfItsOwnShape) {
  Body body;
  body.shape.emplace();
  body.shape->mesh = (folder_ / "work" / write("tower.urdf", kTower)).string();
  sim::read_body_faces(body);
  // Not rig 4: one of its cameras would be in the wall of the mast, whose back is not drawn.
  expect_as_drawn(body, {3, 5, 6});
}

TEST_F(Place, LooksPastTheShapeOfARobot) {
  write("tower.urdf", kTower);
  const std::string robot = write("robot.yaml", "shape: {mesh: tower.urdf}\n");
  ASSERT_EQ(place({kThree, "--quick", "--robot", robot, "--out", "shape"}).status, 0);
  ASSERT_EQ(place({kThree, "--quick", "--out", "cylinder"}).status, 0);
  const auto seen = [&](const char* run) {
    return metrics(run)["rigs"][0]["scores"]["panorama"]["seen_share"].get<double>();
  };
  EXPECT_LT(seen("shape"), 0.9 * seen("cylinder")) << "the mast stands in the back camera's view";
  const std::string inside =
      write("inside.yaml",
            "cameras:\n  deep: {size_px: [320, 240], fov_deg: 80, at_m: [0.1, 0, 0.15]}\n");
  expect_refused({inside, "--robot", robot}, "cameras.deep: is mounted inside the robot's shape");
  expect_refused({kThree, "--robot", write("lost.yaml", "shape: {mesh: lost.stl}\n")},
                 "lost.yaml:1:15: shape.mesh: no such file");
}

}  // namespace
}  // namespace panoptes
