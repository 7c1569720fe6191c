// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_reprojection.h"

#include <cmath>

#include "core/calib/reprojection_cost.h"
#include "core/calib/rig_costs.h"

namespace panoptes {

std::optional<Vec2> drawn_px(const RigTracks& tracks, const RigBundleState& state,
                             const WheelReadings& wheels, const RigSeen& seen) {
  const RigView& view = tracks.views[seen.view];
  const std::optional<Odometry> then = wheels(tracks.instants[view.instant]);
  const std::optional<Odometry> taken =
      wheels(view.stamp - from_seconds(state.clock_offset_s[view.camera]));
  if (!then || !taken) {
    return std::nullopt;
  }
  const Pose3 T_instant_taken =
      on_floor(truly_moved(then->T_odom_body.inverse() * taken->T_odom_body, state.wheel_errors));
  const Pose3 T_start_camera =
      state.T_start_body[view.instant] * T_instant_taken * state.T_body_camera[view.camera];
  const Vec3 p_camera = T_start_camera.inverse() * state.points_start[seen.point];
  const Intrinsics& lens = state.lenses[view.camera];
  return can_draw(lens, p_camera) ? std::optional<Vec2>(lens.project(p_camera)) : std::nullopt;
}

ReprojectionRms reprojection_rms(const RigTracks& tracks, const RigBundleState& state,
                                 const WheelReadings& wheels, std::size_t camera) {
  ReprojectionRms rms;
  for (const RigSeen& seen : tracks.seen) {
    if (seen.believed && tracks.views[seen.view].camera == camera) {
      if (const std::optional<Vec2> px = drawn_px(tracks, state, wheels, seen)) {
        (seen.own ? rms.own_px : rms.other_px) += (*px - seen.px).squaredNorm();
        ++(seen.own ? rms.own : rms.other);
      }
    }
  }
  rms.own_px = rms.own > 0 ? std::sqrt(rms.own_px / rms.own) : 0;
  rms.other_px = rms.other > 0 ? std::sqrt(rms.other_px / rms.other) : 0;
  return rms;
}

}  // namespace panoptes
