// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "core/calib/mono_filter.h"
#include "core/calib/start_bundle.h"
#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// What is believed of one picture since the start.
struct StartBelieved {
  Pose3 T_map_camera;
  std::vector<PointMatch> inliers;
};

/// The pictures since a camera started to map, as a filter was told of them. As long as next to no
/// depth is known, a filter commits itself to what later pictures contradict: a camera that starts
/// sideways may be taken to turn. Here they are adjusted together and filtered again.
class MonoStart {
 public:
  MonoStart(const MonoFilterOptions& options, const Intrinsics& lens, double match_sigma_px);

  /// Points are first seen in the latest picture: to begin with in the first.
  void see(const std::vector<PointMatch>& first_seen);

  /// The next picture. While the camera rests, pictures are forgotten again.
  void add(double dt_s, const std::vector<PointMatch>& matches, const StartBelieved& believed);

  std::size_t pictures() const { return pictures_.size(); }

  /// The first points have moved clearly farther than when the start was last adjusted.
  bool is_due() const;

  struct Again {
    MonoFilter filter;
    FilterUpdate latest;                  ///< of the latest picture's matches
    std::vector<StartBelieved> pictures;  ///< since the first, the latest among them
    std::map<int, Pose3> T_map_first;     ///< where points were first seen from
    bool is_determined = false;           ///< depths are known: the start is over
  };
  /// The same pictures through another filter, which begins with depths that all of them have told
  /// (start_depths). Empty where it would agree with less.
  std::optional<Again> again();

 private:
  struct Picture {
    double dt_s = 0;
    std::vector<PointMatch> matches;
    std::vector<PointMatch> first_seen;
    StartBelieved believed;
  };
  std::vector<StartView> views() const;

  MonoFilterOptions options_;
  Intrinsics lens_;
  double match_sigma_px_;
  std::vector<Picture> pictures_;
  std::map<int, Vec2> first_px_;  // of the first picture's points
  double moved_px_ = 0;           // by these, the median, in the latest picture
  double due_px_;
};

}  // namespace panoptes
