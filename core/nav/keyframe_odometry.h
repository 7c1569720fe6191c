// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "core/config/fields.h"
#include "core/graph/shared_graph.h"
#include "core/motion/local_bundle.h"
#include "core/motion/relative_motion.h"
#include "core/vision/local_features.h"

namespace panoptes {

struct BundleOdometryOptions {
  int keyframes = 5;  ///< moved over by one bundle: enough for depths, few enough to solve at once,
  int longest = 20;   ///< but for a turn on the spot, which ends with the drive after it; no bundle
                      ///< is of less than `keyframes`
  int before = 3;     ///< keyframes of the last bundle that lend the newest motion their depths
  BundleOptions bundle;
};
void bind(Fields& f, BundleOdometryOptions& o);

/// The motion between keyframes by wheels and pictures together: features are followed from
/// keyframe to keyframe, and bundles of a few of these are adjusted. Every picture is in one bundle
/// alone, but for the keyframes at which they meet, so that what bundles say is independent.
class KeyframeOdometry {
 public:
  KeyframeOdometry(const BundleOdometryOptions& options, const FeatureOptions& features,
                   LoopCameras cameras);

  struct Motion {
    Pose2 T_last_here;
    std::vector<SharedEdge> open;     ///< of the bundle that is not full yet
    std::optional<JointEdge> closed;  ///< the bundle that this keyframe made full
  };

  /// The next keyframe; its number is how many came before. `rig` is what is known of the rig.
  /// `place` has features of each loop camera. Of the first one the motion is none.
  Motion add(const BundleFrame& frame, const PlaceFeatures& features, const RigPriorState& rig);

  /// The newest `keyframes` by themselves, where so many have come since it last told of them: in
  /// them a change of the rig shows before a long bundle ends. What they say is said by bundles,
  /// too, of which some may have ended amid them. To be asked for after each keyframe: until then
  /// all keyframes since the last part are remembered.
  std::optional<JointEdge> part(const RigPriorState& rig);

  /// A vertical third of one camera's picture: what somebody fills who walks by.
  struct PictureThird {
    int camera = 0;
    int third = 0;  ///< from the left
  };

  static constexpr int kRemembered = 32;  ///< keyframes that jump() can look back on

  /// By how much each camera's mounting changed right before keyframe `at`, by the newest keyframes
  /// from `before` before it on. Of the tracks of a camera that begin at one keyframe the `most`
  /// longest are asked; none that shows what is in `without` where it goes past `at`.
  MountingJump jump(const RigPriorState& rig, int at, int before, int most,
                    const std::optional<PictureThird>& without) const;

  int newest() const { return newest_; }

  /// Ends the open bundle at the newest keyframe, at least one after its first.
  JointEdge close(const RigPriorState& rig);

  /// A bundle of keyframes once more, each with what is seen from it: what add() would make of
  /// them now, were they the newest. `near`: they moved little since, as they do while the rig
  /// is learned; else they start from the wheels.
  JointEdge bundle_again(const JointEdge& before, const std::vector<BundleFrame>& frames,
                         const std::vector<PlaceFeatures>& features, const RigPriorState& rig,
                         bool near) const;

 private:
  void follow(const BundleFrame& frame, const PlaceFeatures& features, const RigState& state);
  bool is_full() const;
  void begin_bundle();
  std::vector<Track> tracks_since(int first) const;
  std::vector<BundleFrame> frames_since(int first) const;
  std::vector<Pose2> path_since(int first) const;
  BundleSolution adjust(int first, const RigPriorState& rig) const;
  BundleSolution adjust_from(const std::vector<Pose2>& start_T_first_frame, bool near, int first,
                             const RigPriorState& rig) const;

  BundleOdometryOptions options_;
  FeatureOptions features_;
  LoopCameras cameras_;
  int newest_ = -1;
  int bundle_first_ = 0;           // keyframe at which the open bundle begins,
  int part_first_ = 0;             // the part that is next told of,
  int kept_first_ = 0;             // and what is remembered
  std::optional<JointEdge> part_;  // where it is the bundle that was closed just now
  std::deque<BundleFrame> frames_;
  std::deque<Pose2> T_before_here_;  // as estimated
  std::vector<SharedEdge> open_;     // of the open bundle, as last adjusted
  std::vector<Track> tracks_;        // frames numbered by keyframes
  PlaceFeatures last_features_;
  std::vector<std::vector<int>> last_tracks_;  // of each camera's features, -1 without one
  double noise_px_;
};

}  // namespace panoptes
