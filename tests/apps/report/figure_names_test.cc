// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/figure_names.h"

#include <gmock/gmock.h>

namespace panoptes {
namespace {

std::string fault(const std::string& line) {
  return requirement_fault(parse_requirement(line), {"floor", "front"});
}

TEST(FigureNames, TakeWhatRunsMayHave) {
  for (const char* line :
       {"outcome == completed", "end_reason != duration", "collisions == 0", "map.coverage >= 0.85",
        "loops.pose_error.opposite.median_m < 0.01", "timing_ms.slam.p99 < 20",
        "devices.base.resyncs == 0", "cameras.front.frozen == 0",
        "platform_truth.cameras.floor.centre_error_px.1 < 2",
        "platform_truth.wheels.base_error_percent < 1", "rig.front.yaw_correction_deg_error < 0.1",
        "rig.floor.clock_offset_s_sigma < 0.01", "rig.front.error_inside_95 == 1",
        "wheels.base_sigma < 0.01", "places.grey.emd.front_back.recall > 0.2"}) {
    EXPECT_EQ(fault(line), "") << line;
  }
}

TEST(FigureNames, RefuseWhatNoRunHas) {
  EXPECT_EQ(fault("map.coverag >= 0.85"),
            "requirement 'map.coverag >= 0.85': no run has a figure 'map.coverag'; did you mean "
            "map.coverage?");
  EXPECT_EQ(fault("colisions == 0"),
            "requirement 'colisions == 0': no run has a figure 'colisions'; did you mean "
            "collisions?");
  for (const char* line :
       {"map == 1", "map.coverage.x == 1", "timing_ms.slam.p98 < 20", "devices.base == 0",
        "nothing_like_it < 1", "timing_ms.slm.p99 < 5", "cameras.front.frosen == 0",
        "collisions == 0x", "map.coverage == nan"}) {
    EXPECT_NE(fault(line), "") << line;
  }
}

TEST(FigureNames, RefuseCamerasThatTheRigHasNot) {
  EXPECT_EQ(
      fault("cameras.flor.frozen == 0"),
      "requirement 'cameras.flor.frozen == 0': no run has a figure 'cameras.flor.frozen'; did "
      "you mean cameras.floor.frozen?");
  EXPECT_NE(fault("rig.flor.position_error_m < 1"), "");
}

TEST(FigureNames, RefuseOutcomesThatNoRunHas) {
  EXPECT_EQ(fault("outcome == complete"),
            "requirement 'outcome == complete': must be one of completed, collision, stuck, "
            "device_lost, goal_unreachable, failed, interrupted; did you mean completed?");
  EXPECT_NE(fault("end_reason == 3"), "");
}

}  // namespace
}  // namespace panoptes
