// SPDX-License-Identifier: BSD-3-Clause
#include "apps/recognition/recognition_study.h"

#include <numbers>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>

#include "apps/mission/mission.h"
#include "apps/recognition/recognition_table.h"
#include "core/base/error.h"
#include "core/base/rng.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

const std::string kScenes = PANOPTES_SOURCE_DIR "/scenes/";
const std::string kOffice = kScenes + "missions/loops-office.yaml";
const std::string kCorners = "rig=" + kScenes + "rigs/front-back-floor-corners.yaml";
const std::string kTrueCorners = "platform.nominal_" + kCorners;  // the robot has them as well

std::vector<std::string> faults(const std::vector<std::string>& overrides) {
  try {
    load_mission<ExploreMission>(kOffice, overrides);
  } catch (const ConfigError& error) {
    return error.lines();
  }
  return {};
}

// Strips of colours of their own: what a camera sees of a wall at a place, looking its way.
cv::Mat wall(double x_m, int side) {
  cv::Mat picture(24, 32, CV_8UC3);
  for (int u = 0; u < picture.cols; ++u) {
    Rng strip(static_cast<std::uint64_t>(1000 * side + std::lround(4 * x_m) + u));
    picture.col(u).setTo(cv::Scalar(strip.index(256), strip.index(256), strip.index(256)));
  }
  return picture;
}

/// To and fro along a corridor whose ends look different: what the front shows on the way there the
/// back shows on the way back.
struct Drive {
  std::vector<Pose2> truth;
  std::vector<Observation> seen;

  Drive() {
    for (const int lap : {0, 1, 2}) {
      for (int i = 0; i <= 30; ++i) {
        const bool back = lap == 1;
        const double x_m = 0.25 * (back ? 30 - i : i);
        truth.push_back({x_m, 0, back ? std::numbers::pi : 0});
        Observation at;
        at.pictures["front"].bgr = wall(x_m, back ? 1 : 0);
        at.pictures["back"].bgr = wall(x_m, back ? 0 : 1);
        seen.push_back(at);
      }
    }
  }
};

TEST(RecognitionStudy, AsksForEveryCombinationOfOneDrive) {
  const auto mission = load_mission<ExploreMission>(
      kOffice, {"places.histogram=[grey, two_dimensional]", "places.distance=[emd, l2]",
                "places.pictures=[front, front_back, four_corners]", kCorners, kTrueCorners});
  ASSERT_TRUE(mission.places);
  std::vector<std::string> asked;
  RecognitionStudy study(*mission.places, mission.rig, [&](const std::string& camera) {
    asked.push_back(camera);
    return Picture{Time{}, wall(asked.size() % 5, 3)};
  });
  const Drive drive;
  for (const Observation& seen : drive.seen) {
    SlamStep keyframe;
    keyframe.keyframe_made = 0;
    study.add(seen, keyframe, {});
  }
  EXPECT_THAT(asked, SizeIs(4 * drive.seen.size()));
  const auto rows = study.rows(drive.truth, path_lengths_m(drive.truth));
  ASSERT_THAT(rows, SizeIs(12));
  for (const RecognitionRow& row : rows) {
    EXPECT_EQ(row.found.revisits_same, 1);
    EXPECT_EQ(row.found.revisits_opposite, 2);
    const bool same = row.pictures != "four_corners";  // whose pictures were of nowhere
    EXPECT_EQ(row.found.recalled_same, same ? 1 : 0) << row.histogram << row.distance;
    EXPECT_EQ(row.found.recalled_opposite > 0, row.pictures == "front_back")
        << row.histogram << row.distance << row.pictures;
  }
}

TEST(RecognitionStudy, RefusesWhatItCannotDo) {
  EXPECT_THAT(faults({"places.histogram=[gray]"}),
              ElementsAre("--set places.histogram: must be some of grey, colour, gradient, "
                          "two_dimensional, got gray; did you mean grey?"));
  EXPECT_THAT(faults({"places.distance=[]"}),
              ElementsAre(HasSubstr("places.distance: must have at least one of emd")));
  EXPECT_THAT(faults({"places.distance=[l2, l2]"}),
              ElementsAre(HasSubstr("places.distance: has l2 twice; leave one out")));
  EXPECT_THAT(faults({"places.pictures=[four_corners]"}),
              ElementsAre(HasSubstr("places.pictures: four_corners needs four cameras with the "
                                    "role corner, and the rig has 0; take another one")));
  EXPECT_THAT(faults({"places.pictures=[four_corners]", kCorners, kTrueCorners,
                      "rig.cameras.corner_back_left.rate_hz=15",
                      "platform.nominal_rig.cameras.corner_back_left.rate_hz=15"}),
              ElementsAre(HasSubstr("four_corners asks the camera corner_back_left for a picture "
                                    "at each keyframe alone; give it rate_hz: 0")));
  EXPECT_THAT(faults({"places.pictures=[four_corners]", kCorners, kTrueCorners}), SizeIs(0));
}

class PlaceFiles : public ScratchTest {};

TEST_F(PlaceFiles, AreReadAsTheyWereWritten) {
  const std::vector<RecognitionRow> rows{{"grey", "emd", "front_back", {40, 10, 4, 0, 3, 0}},
                                         {"colour", "l2", "front", {0, 0, 0, 0, 0, 0}}};
  write_recognition_rows(folder_ / "places.csv", rows);
  const auto again = read_recognition_rows(folder_ / "places.csv");
  ASSERT_THAT(again, SizeIs(2));
  EXPECT_EQ(again[0].recall(), 0.25);
  EXPECT_EQ(again[0].recall_same(), 0.75);
  EXPECT_FALSE(again[0].recall_opposite());
  EXPECT_TRUE(again[0].is_thesis());
  EXPECT_FALSE(again[1].recall());
  EXPECT_FALSE(again[1].is_thesis());
}

TEST(RecognitionTable, HasTheBestFirstAndSumsRunsOfAWorld) {
  const RecognitionRow thesis{"grey", "emd", "front_back", {40, 10, 4, 2, 3, 1}};
  const RecognitionRow better{"colour", "l2", "front", {40, 20, 4, 2, 4, 0}};
  RecognitionWorld office{"office", {}};
  add_rows(office, {thesis, better});
  add_rows(office, {thesis, better});
  EXPECT_EQ(office.rows[0].found.keyframes, 80);
  const auto lines = recognition_table({office, {"home", {thesis}}});
  ASSERT_THAT(lines, SizeIs(4));
  EXPECT_THAT(lines[2], HasSubstr("colour"));
  EXPECT_THAT(lines[2], HasSubstr("50 (100 /   0)"));
  EXPECT_THAT(lines[3], HasSubstr("25 ( 75 /  50)"));
  EXPECT_THAT(lines[3], HasSubstr("the thesis's own"));
  EXPECT_GT(draw_recognition_table({office}).cols, 300);
}

}  // namespace
}  // namespace panoptes
