// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/camera/observation.h"
#include "core/camera/rectify.h"
#include "core/camera/rig.h"
#include "core/geometry/body.h"
#include "core/nav/localiser.h"
#include "core/nav/mapper.h"
#include "core/nav/slam_step.h"
#include "core/nav/stage.h"
#include "core/odometry/odometry_source.h"
#include "core/vision/camera_health.h"

namespace panoptes {

struct SlamOptions {
  CameraHealthOptions camera_health;
  LocaliserOptions localiser;
  MapperOptions mapper;
};

/// Where the robot is, and what is around it (thesis 6.3.2 to 6.3.4): localises, closes loops and
/// maps, whoever drives. Equal observations give equal steps, bit for bit. Knows no clock, no file
/// and no truth. Pictures of cameras that are not good are left out. Pictures that a lens bends are
/// straightened: all that follows is of pinholes. An observation of which the odometry tells
/// nothing is passed over.
class Slam {
 public:
  Slam(const SlamOptions& options, const Body& body, const Rig& rig, const Rng& rng,
       StageListener listener = {});

  SlamStep step(const Observation& raw);

  /// Of every camera of the rig, up to now.
  const CameraReports& cameras() const { return cameras_.reports(); }

  /// A picture of the floor has been seen.
  bool looked_at_floor() const { return looked_at_floor_; }
  /// Why the robot must not move from where it was started; empty when it may.
  const std::string& start_fault() const { return start_fault_; }

  const std::vector<Keyframe>& keyframes() const { return localiser_.keyframes(); }
  const SharedGraph& graph() const { return localiser_.graph(); }

  const LoopCameras& loop_cameras() const { return localiser_.cameras(); }
  /// Why no map by this rig would be right; empty while nothing looks wrong in kind.
  std::string rig_fault() const;
  const std::vector<KnockReport>& knocks() const { return localiser_.knocks(); }
  RigEstimate rig_estimate() const { return localiser_.rig_estimate(); }
  /// What a keyframe looked like, and the floor around each as it was seen from there.
  const LoopPlace& place(int keyframe) const { return localiser_.place(keyframe); }
  std::vector<PlacedGrid> grids() const { return mapper_.placed(graph().T_map_node); }

  /// The map, made anew from every keyframe's grid where relaxation has put it.
  OccupancyMap map(double cell_m) const;

  /// The map as it is known now, on planning cells: cheap.
  OccupancyMap planning_map();
  std::optional<std::vector<Vec2>> standing() const;  ///< see Mapper
  bool something_came() const;                        ///< see Mapper
  /// Free floor of the planning map that was made last.
  double mapped_free_m2() const { return mapped_free_m2_; }

  /// The rig as straightened pictures have it, and what its foremost floor camera shows of the
  /// floor.
  const Rig& rig() const { return rectifier_.rig(); }
  const FloorProjection& floor_projection() const { return mapper_.projection(); }

 private:
  SlamStep step_accepted(const Observation& accepted);
  SlamStep step_straight(const Observation& seen);

  StageListener listener_;
  CameraHealth cameras_;
  Rectifier rectifier_;
  std::unique_ptr<OdometrySource> odometry_;
  Localiser localiser_;
  Mapper mapper_;
  Pose2 T_map_body_;
  Pose2 T_odom_body_;
  double mapped_free_m2_ = 0;
  bool looked_at_floor_ = false;
  std::string start_fault_;
};

}  // namespace panoptes
