// SPDX-License-Identifier: BSD-3-Clause
#include "hw/replay/tracked_truth.h"

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/io/dataset_table.h"
#include "core/io/euroc_truth.h"
#include "core/io/file.h"
#include "tests/support/scratch.h"

namespace panoptes::hw {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr Duration kEpoch(1'700'000'000'000'000'000);

// 0.5 m/s straight ahead in the plane, seen from `scene`.
Pose2 T_scene_body(double t_s) { return Pose2{2, 3, 0.5} * exp_twist({0.5, 0}, t_s); }

class TrackedTruth : public ScratchTest {
 protected:
  // A picture every 100 ms for 4 s; the robot stands until `moves_s` and drives on then.
  Dataset observed(double moves_s = 0) const {
    Dataset dataset;
    dataset.ours = false;
    dataset.epoch = kEpoch;
    for (int i = 0; i <= 40; ++i) {
      RecordedObservation seen;
      seen.stamp = seen.now = Time(milliseconds(100 * i));
      seen.odometry.T_odom_body = exp_twist({0.5, 0}, std::max(0.0, 0.1 * i - moves_s));
      dataset.observations.push_back(seen);
    }
    return dataset;
  }

  // Tracked every `every_ms` from an instant to another, but for a pause.
  void track(int from_ms, int to_ms, int every_ms, double moves_s = 0, int pause_ms = 1 << 30) {
    std::string rows = "#timestamp, p_x, p_y, p_z, q_w, q_x, q_y, q_z\n";
    for (int ms = from_ms; ms <= to_ms; ms += every_ms) {
      if (ms > pause_ms && ms < pause_ms + 900) {
        continue;
      }
      const double t_s = 1e-3 * ms - moves_s;
      const Pose2 T = T_scene_body(moves_s > 0 ? std::max(0.0, t_s) : t_s);
      rows += dataset_row(Time(kEpoch + milliseconds(ms)), T.x_m, T.y_m, 0.2,
                          std::cos(T.theta_rad / 2), 0.0, 0.0, std::sin(T.theta_rad / 2));
    }
    const std::filesystem::path file = folder_ / kEstimateFile;
    std::filesystem::create_directories(file.parent_path());
    write_file(file, rows);
  }
};

void expect_true(const Truth& truth, const Dataset& dataset, double moves_s = 0) {
  constexpr double kRounded_m = 1e-9;
  ASSERT_EQ(truth.poses.size(), dataset.observations.size());
  for (std::size_t i = 0; i < truth.poses.size(); ++i) {
    const TruePose& pose = truth.poses[i];
    EXPECT_EQ(pose.stamp, dataset.observations[i].stamp);
    const Pose2 is = T_scene_body(std::max(0.0, to_seconds(pose.stamp) - moves_s));
    EXPECT_NEAR((pose.T_scene_body.position() - is.position()).norm(), 0, kRounded_m) << i;
    EXPECT_NEAR(pose.T_scene_body.theta_rad, is.theta_rad, kRounded_m);
  }
}

TEST_F(TrackedTruth, IsOfTheObservationsInstants) {
  track(-13, 4100, 20);
  Dataset dataset = observed();
  const auto truth = truth_of(folder_, dataset);
  ASSERT_TRUE(truth);
  EXPECT_THAT(dataset.warnings, IsEmpty());
  const Truth all = truth->after(dataset.observations.size());
  expect_true(all, dataset);
  EXPECT_FALSE(truth->touches_known());
  EXPECT_THAT(all.floor.cells, IsEmpty());
  EXPECT_NEAR(all.path_m, 2, 1e-9);
  EXPECT_EQ(truth->after(3).poses.size(), 3U);
}

TEST_F(TrackedTruth, TheWheelsLeadToItsEnds) {
  track(150, 3890, 20);
  Dataset dataset = observed();
  const auto truth = truth_of(folder_, dataset);
  ASSERT_TRUE(truth);
  expect_true(truth->after(dataset.observations.size()), dataset);
  // a robot that stands may be tracked long after its first picture
  track(1500, 4000, 20, 1.5);
  Dataset standing = observed(1.5);
  const auto late = truth_of(folder_, standing);
  ASSERT_TRUE(late);
  expect_true(late->after(standing.observations.size()), standing, 1.5);
}

TEST_F(TrackedTruth, OfADriveThatItTellsTooLittleOfNothingIsSaid) {
  track(1000, 4000, 20);
  Dataset dataset = observed();
  EXPECT_FALSE(truth_of(folder_, dataset));
  EXPECT_THAT(dataset.warnings,
              ElementsAre(HasSubstr("data.csv: tells of 1.00 to 4.00 s, the pictures go from 0.00 "
                                    "to 4.00 s and the robot moves meanwhile; nothing is compared "
                                    "with it")));
  track(5000, 9000, 20);
  Dataset other = observed();
  EXPECT_FALSE(truth_of(folder_, other));
}

TEST_F(TrackedTruth, GapsAreTold) {
  track(0, 4000, 20, 0, 2000);
  Dataset dataset = observed();
  EXPECT_TRUE(truth_of(folder_, dataset));
  EXPECT_THAT(dataset.warnings,
              ElementsAre(HasSubstr("has no pose for more than 0.5 s around 8 of 41 frame sets")));
}

TEST_F(TrackedTruth, MayBeMissing) {
  Dataset dataset = observed();
  EXPECT_FALSE(truth_of(folder_, dataset));
  EXPECT_THAT(dataset.warnings, IsEmpty());
}

}  // namespace
}  // namespace panoptes::hw
