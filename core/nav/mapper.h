// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/observation.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/graph/pose_graph.h"
#include "core/map/contours.h"
#include "core/map/floor_camera_check.h"
#include "core/map/floor_flow.h"
#include "core/map/floor_mapper.h"
#include "core/map/fusion.h"
#include "core/map/keyframe_grid.h"
#include "core/map/newcomers.h"
#include "core/nav/localiser.h"

namespace panoptes {

struct MapperOptions {
  FloorMapperOptions floor;
  double cell_m = 0.01;        ///< of keyframes' grids and the finished map
  double local_cell_m = 0.02;  ///< of the local map
  double local_half_width_m = 3.5;
  int local_keyframes = 5;      ///< thesis 6.4: enough to navigate safely
  double plan_cell_m = 0.05;    ///< of the global map while driving
  double refuse_s = 0.2;        ///< a moved map is fused again within about this
  double start_margin_m = 0.1;  ///< beyond the blind zone that is assumed free at the start
  double contour_path_m = 2;    ///< of the robot's path whose grids make up a keyframe's contours
  double contour_cell_m = 0.02;
  int contour_keyframes = 12;  ///< at most, to either side
};
void bind(Fields& f, MapperOptions& o);

struct Mapped {
  FloorReading reading;     ///< of the foremost floor camera's picture; empty without one
  OccupancyMap local_odom;  ///< the last keyframes and the open one, about the robot
};

/// The floor cameras of a rig, the one that looks straightest ahead first. Throws ConfigError when
/// there is none.
std::vector<std::string> floor_cameras(const Rig& rig);

/// Free space (thesis 6.3.4): every picture of the floor goes into the open keyframe's grid; the
/// last few grids make the local map, all of them the map, in which all that the
/// body has driven over is free. Relaxation moves grids, never their content.
class Mapper {
 public:
  Mapper(const MapperOptions& options, const Body& body, const Rig& rig);

  /// `T_map_keyframes`: of every keyframe so far, after relaxation.
  Mapped step(const Observation& seen, const Located& located,
              const std::vector<Keyframe>& keyframes, const std::vector<Pose2>& T_map_keyframes);

  /// The map as far as it is known now, on planning cells.
  OccupancyMap map(const std::vector<Pose2>& T_map_keyframes);

  /// All of it made anew.
  OccupancyMap finished_map(double cell_m, const std::vector<Pose2>& T_map_keyframes) const;

  /// What has been found to stand by its motion, floor colour or not: places in the map. Empty when
  /// no camera looks for it.
  std::optional<std::vector<Vec2>> standing(const std::vector<Pose2>& T_map_keyframes) const;

  /// Whether anything has come since the start where floor was known: a world that does not move
  /// gives nothing to wait for.
  bool something_came() const;

  /// Where free floor ends around a keyframe, in its frame (thesis 6.3.3).
  std::vector<Vec2> contour(int keyframe, const std::vector<Pose2>& T_map_keyframes) const;

  /// The blind zone and a little more, from the middle of the body: assumed free at the start.
  double start_radius_m() const;
  const FloorProjection& projection() const { return *floor_cameras_.front().floor.projection(); }

  /// That a floor camera was knocked, in words; empty while none was.
  const std::string& rig_fault() const { return rig_fault_; }

  /// Every keyframe's grid where it is now.
  std::vector<PlacedGrid> placed(const std::vector<Pose2>& T_map_keyframes) const;

 private:
  void check_camera(std::size_t camera, const cv::Mat& bgr, const FloorReading& reading,
                    const Pose2& T_odom_body, const Twist2& twist_body);
  GridCrop open_crop() const;
  void remember_known(const OccupancyMap& local_odom, const Pose2& T_odom_start, Time stamp);
  void forget_obstacles();
  std::size_t first_of_late() const;
  void take_back(const std::vector<Vec2>& proved_floor_open,
                 const std::vector<Pose2>& T_map_keyframes);
  void replace(std::size_t keyframe, std::shared_ptr<const GridCrop> grid);
  void close_keyframe(const std::vector<Keyframe>& keyframes,
                      const std::vector<Pose2>& T_map_keyframes);
  void drive_over(const Pose2& T_keyframe_body, const Pose2& T_wheels_body, bool touches);

  MapperOptions options_;
  Body body_;
  struct FloorCamera {
    std::string camera;
    std::string second;  // a camera that sees the same from another height; empty: none
    FloorMapper floor;
    FloorFlow flow;
    FloorCameraCheck check;
    Newcomers newcomers;
  };
  std::vector<FloorCamera> floor_cameras_;  // the one that looks straightest ahead first
  KeyframeGrid open_;
  int open_keyframe_ = 0;
  LocalMap local_;
  struct Known {
    Time at;
    OccupancyMap local_odom;  // without newcomers
  };
  std::deque<Known> known_;  // local maps of late, the oldest first
  GlobalMap global_;
  std::vector<std::shared_ptr<const GridCrop>> closed_;
  bool bumped_ = false;
  Time bumped_at_;
  Time last_step_;
  std::optional<Pose2> T_wheels_last_;
  std::string rig_fault_;
};

}  // namespace panoptes
