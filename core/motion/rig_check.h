// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/camera/loop_cameras.h"
#include "core/geometry/pose2.h"
#include "core/geometry/pose3.h"
#include "core/motion/rig_correction.h"
#include "core/vision/local_features.h"

namespace panoptes {

/// Whether the rig file is wrong in kind: a camera that looks elsewhere than it says, two that are
/// swapped, one that is mirrored or upside down, sees another angle, or has another clock. What a
/// calibration leaves is no such fault: states of the rig take it up.
///
/// Turning on the spot moves what every camera shows about the vertical by as much as the wheels
/// turn, at the instants of its stamps. Driving moves it away from where the body drives to. Each
/// needs no depth, no map and no good calibration.
class RigCheck {
 public:
  RigCheck(const FeatureOptions& features, LoopCameras believed);

  /// At every instant that the odometry tells of.
  void add_odometry(Time stamp, double theta_rad);

  /// The pictures of the next keyframe, `T_last_here` by the wheels.
  void add_keyframe(Time taken, const PictureTimes& times, const PlaceFeatures& features,
                    const Pose2& T_last_here);

  /// What looks wrong, in words; empty while nothing does.
  const std::string& fault() const { return fault_; }

 private:
  /// What two pictures of one camera show of a turn on the spot.
  struct Turn {
    Time from;
    Time to;
    double seen_rad = 0;                                          ///< by most,
    double far_rad = 0;                                           ///< and by what stands far
    std::vector<std::pair<Eigen::Vector2f, Eigen::Vector2f>> px;  ///< of the same things
  };
  /// A way of looking that the camera may truly have.
  struct Look {
    Pose3 T_body_camera;
    double agreed_px = 0;  ///< of the flow, along where this look expects it
    double flow_px = 0;

    double agreed() const { return flow_px > 0 ? agreed_px / flow_px : 0; }
  };
  /// By which share something is off with which turns fit best, and how much better they then fit.
  struct Fit {
    double off = 0;
    double misfit_ratio = 1;
  };
  struct Seen {
    std::vector<Turn> turns;
    Fit lens;  ///< by the last turns, wherever things stand
    Fit wheels;
    std::vector<Look> looks;               ///< the rig file's first
    std::vector<double> inverse_depths_m;  ///< the median of each drive
  };

  double turned_rad(Time from, Time to) const;
  void add_turn(int camera, Time from, Time to, const LocalFeatures& before,
                const LocalFeatures& here, const std::vector<FeatureMatch>& matches);
  void add_drive(int camera, const Pose2& T_last_here, const LocalFeatures& before,
                 const LocalFeatures& here, const std::vector<FeatureMatch>& matches);
  bool has_driven(int camera) const;
  double turn_ratio(int camera, double Turn::*seen_rad, Duration before = {}) const;
  double turns_misfit_px2(int camera, double focal_ratio, double wheels_ratio) const;
  template <typename Misfit>
  static Fit best_fit(const Misfit& misfit_of_ratio);
  const Look* other_look(int camera) const;
  int camera_told_to(const Look& look) const;
  std::string wrong_look() const;
  std::string wrong_clock() const;
  std::string wrong_lens() const;

  FeatureOptions features_;
  LoopCameras believed_;
  std::vector<Seen> seen_;
  std::vector<std::pair<Time, double>> odometry_;
  PlaceFeatures last_;
  std::vector<Time> last_taken_;
  int keyframes_ = 0;
  std::string fault_;
};

}  // namespace panoptes
