// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/graph/shared_graph.h"
#include "core/loops/loop_closer.h"
#include "core/motion/rig_check.h"
#include "core/motion/rig_estimate.h"
#include "core/nav/heading_edge.h"
#include "core/nav/jump_check.h"
#include "core/nav/keyframe_odometry.h"
#include "core/nav/knock_check.h"
#include "core/nav/stage.h"
#include "core/odometry/make_odometry.h"
#include "core/vision/camera_health.h"

namespace panoptes {

struct KeyframeOptions {
  double distance_m = 0.25;  ///< beta of thesis 6.3.2
  double turn_rad = deg_to_rad(15);
  double dissimilarity = 4;  ///< alpha: in median distances between consecutive keyframes
};
void bind(Fields& f, KeyframeOptions& o);

/// How wrong the wheels may be, one sigma, before the robot has moved; the rig file says it of
/// cameras.
struct WheelPrior {
  double scale_share = 0.002;
  double difference_share = 0.005;
  double base_share = 0.02;
};
void bind(Fields& f, WheelPrior& o);

struct LocaliserOptions {
  KeyframeOptions keyframe;
  BundleOdometryOptions bundle;
  WheelPrior wheel_prior;
  SignatureOptions signature;
  OdometryOptions odometry;
  WheelNoise wheels;
  bool visual_heading = true;   ///< pictures correct the wheels' heading between keyframes
  bool knocks_at_once = false;  ///< a knocked camera is looked for by what is followed across the
                                ///< knock, too: sooner, for a fifth more CPU time
  LoopOptions loops;
};
void bind(Fields& f, LocaliserOptions& o);

/// A place the robot remembers.
struct Keyframe {
  Time stamp;           ///< of the set of pictures: the wheels tell of this instant
  Pose2 T_wheels_body;  ///< by the odometry alone
  Pose2 T_odom_body;    ///< by the odometry and the pictures' headings; never moved again
};

/// Where the robot is, and what happened to its memory of places.
struct Located {
  Pose2 T_map_body;
  Pose2 T_odom_body;  ///< by wheels and the pictures' headings: does not jump when a loop closes
  Pose2 T_last_body;  ///< seen from the last keyframe
  int keyframe = 0;   ///< the last one
  std::optional<int> keyframe_made;
  std::vector<ClosureReport> closures;
  bool relaxed = false;
};

/// Keyframes, loop closures and relaxation (thesis 6.3.2, 6.3.3). Between keyframes the wheels tell
/// the way; at each keyframe bundles of wheels and pictures correct it, and what is believed of the
/// rig. Where a camera is lost keyframes go on with the others, or by the wheels alone, but no loop
/// is closed at them: what tells places apart takes all.
class Localiser {
 public:
  /// `odometry` tells of the motion in the observations, and outlives this.
  Localiser(const LocaliserOptions& options, const OdometrySource& odometry, const Rig& rig,
            Rng rng);

  /// `seen` holds what is believed alone; of the cameras that are not good in `cameras` no pictures
  /// are waited for. Tells `listener` of the stages "odometry" (the motion since the last keyframe)
  /// and "slam".
  Located step(const Observation& seen, const ContourSource& contours,
               const StageListener& listener = {}, const CameraReports& cameras = {});

  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  const SharedGraph& graph() const { return graph_; }
  /// What has been learned of the rig and the wheels, and how surely: as keyframes disagree on it,
  /// and no surer than pictures are.
  RigEstimate rig_estimate() const;
  /// See RigCheck and not_this_rig().
  const std::string& rig_fault() const {
    return rig_check_.fault().empty() ? not_this_rig_ : rig_check_.fault();
  }
  const std::vector<KnockReport>& knocks() const { return knocks_; }
  const LoopCameras& cameras() const { return believed_; }
  const LoopPlace& place(int keyframe) const { return closer_.place(keyframe); }

 private:
  /// The pictures that a keyframe is made of, one for each loop camera; null where it is lost.
  using Views = std::vector<const Picture*>;

  std::optional<Views> views_of(const Observation& seen, const CameraReports& reports) const;
  PlaceSignature signature_of(const Views& views) const;
  bool keyframe_due(const Pose2& T_last_body, const LoopPlace& now) const;
  void relax_bundle(Located& out);
  void add_keyframe(const Observation& seen, const LoopPlace& place, Located& out);
  PlaceFeatures features_of(const Views& views) const;
  PictureTimes times_of(const Views& views, Time taken, const Twist2& twist_body) const;
  Pose2 link_to_last(Time taken, const LoopPlace& place, const Pose2& T_last_body);
  Eigen::MatrixXd known_covariance(const Eigen::MatrixXd& information,
                                   double variance_factor) const;
  void take_in(std::optional<JointEdge> closed, const std::vector<SharedEdge>& open);
  void check_for_knock();
  JumpCheck::Shows shown_jumps() const;
  void judge_jump();
  void take_note(const Knock& knock);
  JointEdge adjusted_anew(const JointEdge& joint, const RigPriorState& rig, int without,
                          bool near) const;
  void linearise_again();
  void begin_anew(const Knock& knock);
  int keyframe_turned_by(double turn_rad) const;
  void look_back();
  void close_loops(const ContourSource& contours, Located& out);
  void catch_up(const ContourSource& contours, Located& out);

  LocaliserOptions options_;
  const OdometrySource& odometry_;
  LoopCameras believed_;
  std::vector<Facing> facings_;
  RigCheck rig_check_;
  std::string not_this_rig_;
  KnockCheck knock_check_;
  JumpCheck jump_check_;
  std::vector<KnockReport> knocks_;
  KeyframeOdometry keyframe_odometry_;
  LoopCloser closer_;
  std::vector<Keyframe> keyframes_;
  std::vector<BundleFrame> frames_;       // of each keyframe
  std::vector<RigState> adjusted_about_;  // of each of the graph's joints: the rig as it was known
  // What a keyframe leaves to do is spread over the frames after it:
  bool to_check_for_knock_ = false;
  bool to_look_for_jump_ = false;
  bool to_look_back_ = false;
  bool to_look_for_loops_ = false;
  bool loops_to_close_ = false;
  bool bundle_to_relax_ = false;
  bool to_linearise_ = false;
  int settled_ = 0;                     // of the graph's joints: they stay as they are
  std::vector<SharedEdge> look_backs_;  // between keyframes of one turn that see the same
  SharedGraph graph_;
  Eigen::MatrixXd state_information_;  // of its states, as far as bundles have shown them,
  double variance_factor_ = 1;         // and by how much more these disagree than they claim
  PlaceSignature last_signature_;
  std::vector<float> steps_grey_;  // signature distances between consecutive keyframes, sorted
};

}  // namespace panoptes
