// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/calib/alignment_graph.h"
#include "core/calib/keyframe_bundle.h"
#include "core/calib/map_alignment.h"
#include "core/calib/rig_bundle.h"
#include "core/calib/rig_calibration.h"

namespace panoptes {

/// Which alignments of pairs of maps are followed.
enum class MapsJoined {
  kChain,  ///< the thesis's, see `chained`
  kGraph   ///< see `checked_by_cycles`
};

struct RigByMapsOptions {
  double every_s = 40 / 15.0;  ///< a keyframe: each 40th of 15 pictures a second, the thesis's
  FeatureMethod features = FeatureMethod::kSift;
  MapsJoined joined = MapsJoined::kChain;
  SimilarityOptions similarity;
  KeyframeBundleOptions bundle;  ///< its choice of keyframes is not used
};

/// A camera as the first one sees it all along, by the alignment of their maps: what is rigid does
/// not wander.
struct SeenAlong {
  Pose3 T_first_camera;     ///< in units of the first camera's map
  double turn_off_rad = 0;  ///< rms, by which it wanders
  double shift_off = 0;     ///< likewise, as a share of how far the first camera goes
  int instants = 0;
};

/// A rig as the maps of its cameras have it, with no wheels: it has no metre, and no place on the
/// robot.
struct RigByMaps {
  std::vector<std::string> cameras;
  std::vector<AdjustedMap> maps;       ///< by the keyframes that are common to all
  std::vector<std::size_t> described;  ///< points of each map that are known well enough
  std::vector<MapAlignment> alignments;
  AlignedMaps aligned;
  std::vector<std::optional<SeenAlong>> seen_along;  ///< by camera; empty where it is not aligned
  std::vector<Duration> apart;  ///< of its pictures from the first one's, the median
  /// The body is the first camera, lengths are of its map; clocks and wheels are not in it.
  RigTracks tracks;
  std::vector<int> map_of_point;  ///< the first of the cameras whose maps have it
  std::vector<int> shared;        ///< points of a camera's map that other maps have, too
  RigBundleState before;
  RigBundleState state;
  int observations = 0;        ///< that are believed
  int observations_other = 0;  ///< of these, of points that an earlier camera's map has as well
  int left_out = 0;
  double rms_before_px = 0;  ///< sqrt(mean(dx^2 + dy^2)) of the believed
  double rms_after_px = 0;
  bool converged = false;

  /// One other camera at least is aligned with the first.
  bool is_told() const;
};

/// Calibrates a rig by the maps of its cameras alone (thesis 4.3.3 to 4.3.6): each map is adjusted
/// by keyframes that all cameras took at once, points that look alike in two maps tell how these
/// lie (RANSAC), maps are joined, and the first camera's poses, the others as it sees them, and all
/// points are adjusted together by all that the keyframes show. Lenses and clocks are as believed.
/// `progress` is told the share that is done.
RigByMaps calibrate_by_maps(const RigByMapsOptions& options,
                            const std::vector<MappedCamera>& cameras, const FramePicture& picture,
                            const Rng& rng, const std::function<void(double)>& progress);

/// The rig file's cameras as they were found, on the first of them as the rig file has it, and as
/// far apart as the rig file has those that are farthest apart: the maps tell neither. Sigmas stay:
/// nothing tells them.
Rig rig_by_maps(const Rig& believed, const RigByMaps& found);

}  // namespace panoptes
