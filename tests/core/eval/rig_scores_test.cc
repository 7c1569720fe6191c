// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/rig_scores.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/config/geometry_fields.h"

namespace panoptes {
namespace {

using testing::HasSubstr;

Rig rig_file(const std::string& name) {
  return read_settings<Rig>(PANOPTES_SOURCE_DIR "/scenes/rigs/" + name + ".yaml");
}

std::optional<double> score(const RigScores& scores, const std::string& key) {
  for (const NamedScore& named : named_scores(scores)) {
    if (named.key == key) {
      return named.value;
    }
  }
  ADD_FAILURE() << "no score " << key;
  return std::nullopt;
}

TEST(RigScores, AreTheSameBitsEveryTime) {
  const Rig rig = rig_file("four-corners");
  const auto once = named_scores(score_rig({}, rig, Body()));
  const auto again = named_scores(score_rig({}, rig, Body()));
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].value, again[i].value) << once[i].key;
  }
}

TEST(RigScores, HaveTheSameNamesForEveryRig) {
  std::set<std::string> keys;
  const auto all = named_scores(score_rig({}, rig_file("front-back-floor"), Body()));
  for (const NamedScore& named : all) {
    EXPECT_TRUE(keys.insert(named.key).second) << named.key;
    EXPECT_FALSE(named.what.empty()) << named.key;
  }
  const auto others = named_scores(score_rig({}, rig_file("two-opposed"), Body()));
  ASSERT_EQ(others.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(others[i].key, all[i].key);
  }
}

TEST(RigScores, OfTheThesisRigAreItsOwn) {
  const RigScores scores = score_rig({}, rig_file("front-back-floor"), Body());
  // what its file says
  EXPECT_NEAR(score(scores, "blind.ahead_m").value_or(0), 0.20, 1e-3);
  EXPECT_NEAR(score(scores, "sampling_m.worst_at_200cm").value_or(0), 0.038, 0.001);
  EXPECT_NEAR(score(scores, "sampling_m.worst_at_300cm").value_or(0), 0.072, 0.001);
  EXPECT_NEAR(score(scores, "sight.far_m").value_or(0), 3.0, 1e-3);
  // 0.6 m/s: 0.3 m to brake, and 0.05 s and two periods of 1/15 s until it does
  EXPECT_NEAR(scores.stopping_m, 0.3 + 0.6 * (0.05 + 2 / 15.0), 1e-9);
  EXPECT_NEAR(scores.margin_m.value_or(0), scores.stopping_m - 0.2, 1e-3);
  EXPECT_EQ(score(scores, "stopping.safe_speed_mps"), 0.6);
  EXPECT_EQ(scores.opposite_share, scores.panorama_share);
  EXPECT_NEAR(score(scores, "bus.table_3_1_mbit_per_s").value_or(0), 3 * 27.648, 1e-9);
}

TEST(RigScores, SayWhatALostCameraCosts) {
  const RigScores scores = score_rig({}, rig_file("front-back-floor"), Body());
  ASSERT_EQ(scores.losses.size(), 3U);
  const CameraLoss& back = scores.losses[0];
  EXPECT_EQ(back.camera, "back");
  EXPECT_EQ(back.opposite, 1.0);
  EXPECT_EQ(back.floor_mapped, 0.0);
  EXPECT_GT(back.heading_sigma.value_or(0), 1.0);
  const CameraLoss& floor = scores.losses[1];
  EXPECT_EQ(floor.floor_mapped, 1.0);
  EXPECT_FALSE(floor.blind_ahead_m.has_value());
  // Four corners: each shows a quarter of what there is, and its opposite one a quarter besides.
  const RigScores corners = score_rig({}, rig_file("four-corners"), Body());
  EXPECT_NEAR(score(corners, "loss.panorama").value_or(0), 0.25, 0.03);
  EXPECT_NEAR(score(corners, "loss.opposite").value_or(0), 0.5, 0.06);
}

TEST(RigScores, OfWhatARigHasNoCameraForAreAbsent) {
  Rig rig = rig_file("front-back-floor");
  rig.cameras.erase("floor");
  const RigScores loops_alone = score_rig({}, rig, Body());
  for (const char* key : {"floor.mapped_m2", "floor.mapped_share_to_100cm", "obstacle_m.at_100cm",
                          "loss.floor_mapped"}) {
    EXPECT_FALSE(score(loops_alone, key).has_value()) << key;
  }
  EXPECT_TRUE(score(loops_alone, "blind.ahead_m").has_value());  // of what is seen
  rig = rig_file("front-back-floor");
  rig.cameras.erase("front");
  rig.cameras.erase("back");
  const RigScores floor_alone = score_rig({}, rig, Body());
  for (const char* key : {"panorama.seen_share", "panorama.opposite_share", "loss.panorama"}) {
    EXPECT_FALSE(score(floor_alone, key).has_value()) << key;
  }
}

TEST(RigScores, TurnWithTheRig) {
  Rig rig = rig_file("front-back-floor");
  const RigScores before = score_rig({}, rig, Body());
  const Pose3 quarter = on_floor({0, 0, deg_to_rad(90)});
  for (auto& [name, camera] : rig.cameras) {
    camera.T_body_camera = quarter * camera.T_body_camera;
  }
  const RigScores after = score_rig({}, rig, Body());
  for (const char* key :
       {"floor.seen_m2", "floor.mapped_m2", "floor.seen_share_to_100cm",
        "sampling_m.median_at_100cm", "blind.unseen_headings_share", "panorama.seen_share",
        "panorama.opposite_share", "overlap.twice_share", "blind_spot.share_at_24cm"}) {
    const double was = score(before, key).value_or(0);
    EXPECT_NEAR(score(after, key).value_or(0), was, 0.02 * was) << key;
  }
  EXPECT_FALSE(score(after, "blind.ahead_m").has_value());  // it looks to the left now
}

TEST(RigScoreOptions, AreCheckedBeforeAnythingIsScored) {
  try {
    read_settings_text<RigScoreOptions>("distances_m: [2, 1]\nbus: usb\n", "scores.yaml");
    FAIL() << "it was taken";
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(), HasSubstr("scores.yaml:1:14: distances_m: must be one or more, in "
                                        "ascending order"));
    EXPECT_THAT(error.what(), HasSubstr("scores.yaml:2:6: bus: "));
  }
}

}  // namespace
}  // namespace panoptes
