// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/local_bundle.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/base/check.h"
#include "core/geometry/cross_matrix.h"

namespace panoptes {
namespace {

using Mat23 = Eigen::Matrix<double, 2, 3>;
using CameraJacobian = Eigen::Matrix<double, 2, kCameraStates>;
using MountingJacobian = Eigen::Matrix<double, 2, kMountingStates>;

constexpr double kBehind =
    0.05;  // of the depth at the first keyframe: too near the picture's plane
// What is known of an inverse depth before anything is seen: next to nothing. The distribution of
// inverse depths in rooms would tell the scale, since things agree better on it the farther they
// are, and thousands of them outvote the wheels.
constexpr double kDepthMean_per_m = 0.4;
constexpr double kDepthSigma_per_m = 5;
constexpr double kDepthPrior = 1 / (kDepthSigma_per_m * kDepthSigma_per_m);
// A depth is shown by the path where the path alone, without the cameras' distance from the axis
// that the body turns about, tells it to a quarter of what is usual in a room.
constexpr double kShownSigma_per_m = 0.1;
constexpr double kNearest_per_m = 10;
constexpr double kFarthest_per_m = -0.2;  // beyond infinity: what noise may make of a far thing

constexpr double kStrict = 3;  // sigmas at which a track's weight is a quarter
constexpr double kCareful = 5;
constexpr double kForgiving = 8;
constexpr int kNoJump = -1;
constexpr double kSettled = 0.01;  // gain of chi2: a tenth of a sigma of one unknown

const Mat2 kQuarter = (Mat2() << 0, -1, 1, 0).finished();

// The body where a camera took its picture, in the bundle's first frame.
struct PictureBody {
  Mat3 R = Mat3::Identity();
  Vec3 t = Vec3::Zero();
  Vec3 swing = Vec3::Zero();  // how t moves with the keyframe's heading
  Vec3 velocity = Vec3::Zero();
  double turn_radps = 0;
};

PictureBody picture_body(const Pose2& T_first_frame, const BundleFrame& frame, double after_s) {
  const Pose2 T_frame_picture = exp_twist(frame.taken.twist_body, after_s);
  const Pose2 T = T_first_frame * T_frame_picture;
  PictureBody body;
  body.R.topLeftCorner<2, 2>() = T.rotation();
  body.t = {T.x_m, T.y_m, 0};
  body.swing.head<2>() = kQuarter * (T.position() - T_first_frame.position());
  body.velocity.head<2>() = T.rotation() * Vec2(frame.taken.twist_body.v_mps, 0);
  body.turn_radps = frame.taken.twist_body.w_radps;
  return body;
}

// One thing: where its first picture shows it, with z = 1 in that camera, and its inverse depth.
using Point = Vec3;

struct CameraModel {
  Mat3 R_body_camera;
  Vec3 origin_body;
  Vec2 focal_px;
  Vec2 centre_px;
  bool jumped = false;
};

// A residual and what it changes with.
struct Residual {
  Vec2 r;
  Vec3 from_camera;  // the point, in the camera's axes and units of its first depth,
  Vec2 m;            // and where it shows it with z = 1
  Mat23 project;     // how r changes with from_camera
  Mat23 by_point;
  Vec2 by_depth_on_axis;  // by_point's last column, were the camera on the axis of turning
  Mat23 by_anchor;        // x, y, theta of the keyframe that saw it first
  Mat23 by_frame;
  CameraJacobian by_camera;
  MountingJacobian by_jump;  // of the camera's mounting
};

// How a camera at one keyframe sees what it saw first at another, where it may have sat otherwise.
struct Sight {
  Mat3 M = Mat3::Identity();             // the later body's axes from the first one's
  Mat3 turn = Mat3::Identity();          // the later camera's axes from the first one's
  Vec3 baseline_body = Vec3::Zero();     // the first body from the later one
  Vec3 baseline_on_axis = Vec3::Zero();  // the same in the camera's axes
  Vec3 baseline = Vec3::Zero();          // the first camera from the later one, in its axes
};

Sight sight_of(const CameraModel& before, const CameraModel& camera, const PictureBody& anchor,
               const PictureBody& body) {
  Sight sight;
  const Mat3 R_camera_body = camera.R_body_camera.transpose();
  sight.M = body.R.transpose() * anchor.R;
  sight.turn = R_camera_body * sight.M * before.R_body_camera;
  sight.baseline_body = body.R.transpose() * (anchor.t - body.t);
  sight.baseline_on_axis = R_camera_body * sight.baseline_body;
  sight.baseline =
      R_camera_body * (sight.M * before.origin_body + sight.baseline_body - camera.origin_body);
  return sight;
}

// False where the camera cannot see it.
bool observe(const CameraModel& camera, const Sight& sight, const Point& point, const Vec2& px,
             Residual& out) {
  const Vec3 q =
      sight.turn.leftCols<2>() * point.head<2>() + sight.turn.col(2) + point.z() * sight.baseline;
  if (!(q.z() >= kBehind)) {
    return false;
  }
  const double z = 1 / q.z();
  const Vec2 m(q.x() * z, q.y() * z);
  out.from_camera = q;
  out.m = m;
  out.r = camera.centre_px + camera.focal_px.cwiseProduct(m) - px;
  out.project << camera.focal_px.x() * z, 0, -camera.focal_px.x() * m.x() * z, 0,
      camera.focal_px.y() * z, -camera.focal_px.y() * m.y() * z;
  out.by_point.leftCols<2>() = out.project * sight.turn.leftCols<2>();
  out.by_point.col(2) = out.project * sight.baseline;
  return true;
}

// What the residual of `observe` changes with besides the point.
void differentiate(const CameraModel& before, const CameraModel& camera, const PictureBody& anchor,
                   const PictureBody& body, const Sight& sight, bool same_frame, const Point& point,
                   Residual& out) {
  const double rho = point.z();
  const Mat3& M = sight.M;
  const Vec3 direction = before.R_body_camera * Vec3(point.x(), point.y(), 1);
  const Vec3 at_anchor = rho * before.origin_body + direction;
  const Vec3 from_camera = camera.R_body_camera * out.from_camera;
  const Vec3 at_body = from_camera + rho * camera.origin_body;
  const Mat23 by_body = out.project * camera.R_body_camera.transpose();
  out.by_depth_on_axis = out.project * sight.baseline_on_axis;
  Mat3 anchor_body = Mat3::Zero();
  Mat3 frame_body = Mat3::Zero();
  if (!same_frame) {
    const Mat3 Rt = body.R.transpose();
    const Vec3 turned = anchor.R * at_anchor;
    anchor_body.leftCols<2>() = rho * Rt.leftCols<2>();
    anchor_body.col(2) = Rt * (Vec3(-turned.y(), turned.x(), 0) + rho * anchor.swing);
    frame_body.leftCols<2>() = -anchor_body.leftCols<2>();
    frame_body.col(2) = Vec3(at_body.y(), -at_body.x(), 0) - rho * (Rt * body.swing);
  }
  out.by_anchor = by_body * anchor_body;
  out.by_frame = by_body * frame_body;
  out.by_camera.setZero();
  out.by_jump.setZero();
  if (!same_frame) {
    out.by_camera.middleCols<3>(kRotation) =
        by_body * (cross_matrix(from_camera) - M * cross_matrix(direction));
    out.by_camera.middleCols<2>(kPosition) = by_body * rho * (M - Mat3::Identity()).leftCols<2>();
    // a mounting that changes between the two moves the later picture alone
    if (before.jumped != camera.jumped) {
      out.by_jump.leftCols<3>() = by_body * cross_matrix(from_camera);
      out.by_jump.rightCols<3>() = -rho * by_body;
    } else if (camera.jumped) {
      out.by_jump.leftCols<3>() = out.by_camera.middleCols<3>(kRotation);
      out.by_jump.rightCols<3>() = by_body * rho * (M - Mat3::Identity());
    }
    // a stamp that is late puts both pictures too late on the path
    const Vec3 by_clock =
        -(anchor_body.leftCols<2>() * anchor.velocity.head<2>() +
          frame_body.leftCols<2>() * body.velocity.head<2>()) -
        body.R.transpose() *
            (Vec3(-(anchor.R * at_anchor).y(), (anchor.R * at_anchor).x(), 0) * anchor.turn_radps) -
        Vec3(at_body.y(), -at_body.x(), 0) * body.turn_radps;
    out.by_camera.col(kClock) = by_body * by_clock;
  }
  out.by_camera.col(kFocal) = camera.focal_px.cwiseProduct(out.m);
  out.by_camera.middleCols<2>(kCentre) = Mat2::Identity();
}

// Where each unknown lies: three of each keyframe but the first, the rig's states, and by how much
// each camera's mounting jumps, where one is asked for.
struct Columns {
  int poses = 0;  // of all keyframes together
  int states = 0;
  int wheels = 0;
  int jumps = 0;

  int pose(int frame) const { return 3 * (frame - 1); }
  int camera(int camera) const { return poses + camera_state(camera); }
  int wheel() const { return poses + wheels; }
  int jump(int camera) const { return poses + states + camera * kMountingStates; }
  bool is_jump(int column) const { return column >= poses + states; }
  int size() const { return poses + states + jumps; }
};

// A Gaussian in all unknowns.
struct NormalEquations {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;

  explicit NormalEquations(int size)
      : information(Eigen::MatrixXd::Zero(size, size)), gradient(Eigen::VectorXd::Zero(size)) {}
};

// How the point of one track follows the rest: the poses of the keyframes from its first to its
// last, then its camera's states.
struct TrackSystem {
  Eigen::Matrix<double, 3, Eigen::Dynamic> point_by_rest;  // empty: says nothing
  Vec3 point_step = Vec3::Zero();
};

double chi_square_limit(double freedoms, double sigma) {
  // Wilson and Hilferty 1931
  const double v = 2.0 / (9.0 * freedoms);
  const double root = 1 - v + sigma * std::sqrt(v);
  return freedoms * root * root * root;
}

// Of the depth by itself, its bearing unknown as well.
double depth_information(const Mat3& H_point) {
  const Vec2 bearing_by_depth =
      H_point.topLeftCorner<2, 2>().inverse() * H_point.topRightCorner<2, 1>();
  return H_point(2, 2) - H_point.col(2).head<2>().dot(bearing_by_depth);
}

class Bundle {
 public:
  Bundle(const BundleOptions& options, const LoopCameras& believed, const RigPriorState& prior,
         const std::vector<BundleFrame>& frames, const std::vector<Track>& tracks,
         const std::vector<Pose2>& start, int jump_at)
      : options_(options),
        believed_(believed),
        prior_(prior),
        state_(prior.state),
        frames_(frames),
        tracks_(tracks),
        start_(start),
        jump_at_(jump_at) {
    columns_.poses = 3 * (static_cast<int>(frames.size()) - 1);
    columns_.states = rig_states(believed.size());
    columns_.wheels = wheel_state(believed.size());
    columns_.jumps = jumps() ? kMountingStates * static_cast<int>(believed.size()) : 0;
    jump_ = Eigen::VectorXd::Zero(kMountingStates * static_cast<Eigen::Index>(believed.size()));
    systems_.resize(tracks.size());
    variance_px2_ = options_.noise_px * options_.noise_px;
  }

  // To where all unknowns explain the inliers best.
  void adjust() {
    converge(kAll);
    if (!jumps() && contradicted()) {
      converge(most_agreed());
    }
    for (int round = 0; round < (jumps() ? 1 : 2); ++round) {
      sum_up(free());
      const double gain = step();
      place_bodies();
      settle_points();
      forget_what_went_behind();
      if (gain <= kSettled) {
        break;
      }
    }
    learn_noise();
    keeps_scores_ = jumps();
    sum_up(true);
  }

  BundleSolution solution() const {
    BundleSolution s;
    s.T_first_frame = poses_;
    s.state = state_;
    s.information = sum_.information;
    s.gradient = sum_.gradient;
    s.noise_px = std::sqrt(variance_px2_);
    for (const double trust : trusts_) {
      s.inlier.push_back(trust > 0);
    }
    return s;
  }

  MountingJump jump() const {
    MountingJump out;
    const int rest = columns_.poses + columns_.states;
    Eigen::MatrixXd known = sum_.information - of_tracks_;  // by wheels and prior
    known.block(columns_.poses, columns_.poses, columns_.states, columns_.states) +=
        prior_.information;
    const Eigen::MatrixXd all = known + of_tracks_;
    // what is left of the jumps' columns when poses and states have been integrated out
    Eigen::MatrixXd left = Eigen::MatrixXd::Identity(columns_.size(), columns_.jumps);
    left.topRows(rest) =
        -all.topLeftCorner(rest, rest).ldlt().solve(all.topRightCorner(rest, columns_.jumps));
    left.bottomRows(columns_.jumps).setIdentity();
    out.information = left.transpose() * all.rightCols(columns_.jumps);
    Eigen::VectorXd gradient = sum_.gradient;
    gradient.segment(columns_.poses, columns_.states) +=
        prior_.information * (state_ - prior_.state);
    out.pull = out.information * jump_ - left.transpose() * gradient;
    out.scatter = left.transpose() * known * left;
    for (const Eigen::VectorXd& score : scores_) {
      const Eigen::VectorXd of_jumps = left.transpose() * score;
      out.scatter += of_jumps * of_jumps.transpose();
    }
    out.crossing.assign(believed_.size(), 0);
    out.fitting.assign(believed_.size(), 0);
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      const std::vector<Track::Seen>& seen = tracks_[t].seen;
      if (seen.front().frame < jump_at_ && seen.back().frame >= jump_at_) {
        ++out.crossing[tracks_[t].camera];
        out.fitting[tracks_[t].camera] += trusts_[t] > 0 ? 1 : 0;
      }
    }
    return out;
  }

 private:
  bool jumps() const { return jump_at_ != kNoJump; }

  /// The states are estimated along.
  bool free() const { return prior_.information.size() > 0; }

  static constexpr int kAll = -1;

  // From the start to inliers, by the pictures of one camera, or of all.
  void converge(int by_camera) {
    poses_ = start_;
    state_ = prior_.state;
    jump_.setZero();
    place_cameras();
    points_.clear();
    for (const Track& track : tracks_) {
      const CameraModel& camera = cameras_[track.camera];
      const Vec2 m = (track.seen.front().px - camera.centre_px).cwiseQuotient(camera.focal_px);
      points_.emplace_back(m.x(), m.y(), kDepthMean_per_m);
    }
    depth_prior_.assign(tracks_.size(), kDepthPrior);
    trusts_.assign(tracks_.size(), 1);
    const int gentle = options_.starts_near || jumps() ? 1 : 2;
    for (int iteration = 0; iteration < options_.iterations; ++iteration) {
      place_bodies();
      settle_points();
      // from forgiving to strict
      const double most = iteration < gentle       ? kForgiving
                          : iteration < 2 * gentle ? kCareful
                                                   : kStrict;
      const double kernel = kernel_sigmas(most, by_camera);
      weigh(kernel, by_camera);
      sum_up(free());
      if (step() <= kSettled && kernel == kStrict) {
        break;
      }
    }
    place_bodies();
    settle_points();
    choose_inliers();
  }

  // How large a share of what each camera shows of each motion fits; none where it shows too little
  // to have a word.
  std::vector<double> shares() const {
    constexpr int kFewest = 12;
    const std::size_t cameras = believed_.size();
    std::vector<int> shown(frames_.size() * cameras, 0);
    std::vector<int> fits(shown.size(), 0);
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      const std::vector<Track::Seen>& seen = tracks_[t].seen;
      for (int frame = seen.front().frame + 1; frame <= seen.back().frame; ++frame) {
        const std::size_t at = static_cast<std::size_t>(frame) * cameras + tracks_[t].camera;
        ++shown[at];
        fits[at] += trusts_[t] > 0 ? 1 : 0;
      }
    }
    std::vector<double> shares;
    for (std::size_t at = 0; at < shown.size(); ++at) {
      if (shown[at] >= kFewest) {
        shares.push_back(static_cast<double>(fits[at]) / shown[at]);
      }
    }
    return shares;
  }

  // Most of what some camera shows does not fit. Where somebody walks close by, most of what one
  // camera sees may be of him, and more than what the others see of the room.
  bool contradicted() const {
    constexpr double kLeast = 0.5;
    const std::vector<double> all = shares();
    return believed_.size() > 1 &&
           std::any_of(all.begin(), all.end(), [](double share) { return share < kLeast; });
  }

  // The camera whose motion fits the others' pictures best, each counted alike, however much it
  // shows. All together fit as well where they meet half way: that has to be clearly better.
  int most_agreed() {
    constexpr double kClearly = 1.1;
    const auto agreement = [this] {
      const std::vector<double> all = shares();
      return std::accumulate(all.begin(), all.end(), 0.0);
    };
    int best = kAll;
    double most = agreement() / kClearly;
    for (int camera = 0; camera < static_cast<int>(believed_.size()); ++camera) {
      converge(camera);
      if (const double agreed = agreement(); agreed > most) {
        most = agreed;
        best = camera;
      }
    }
    return best;
  }

  bool asked(std::size_t t, int by_camera) const {
    return by_camera == kAll || tracks_[t].camera == by_camera;
  }

  std::vector<CameraModel> models(const RigState& state, bool jumped) const {
    std::vector<CameraModel> models;
    for (const LoopCamera& camera : corrected(believed_, state)) {
      models.push_back({camera.T_body_camera.rotation.toRotationMatrix(),
                        camera.T_body_camera.translation,
                        {camera.intrinsics.fx_px, camera.intrinsics.fy_px},
                        {camera.intrinsics.cx_px, camera.intrinsics.cy_px},
                        jumped});
    }
    return models;
  }

  void place_cameras() {
    cameras_ = models(state_, false);
    if (jumps()) {
      RigState after = state_;
      for (int camera = 0; camera < static_cast<int>(believed_.size()); ++camera) {
        after.segment<kMountingStates>(camera_state(camera)) +=
            jump_.segment<kMountingStates>(camera * kMountingStates);
      }
      jumped_cameras_ = models(after, true);
    }
  }

  void place_bodies() {
    bodies_.assign(frames_.size() * believed_.size(), {});
    for (std::size_t frame = 0; frame < frames_.size(); ++frame) {
      for (std::size_t camera = 0; camera < believed_.size(); ++camera) {
        const double after_s = frames_[frame].taken.late_s[camera] -
                               state_[camera_state(static_cast<int>(camera)) + kClock];
        bodies_[frame * believed_.size() + camera] =
            picture_body(poses_[frame], frames_[frame], after_s);
      }
    }
    const int frames = static_cast<int>(frames_.size());
    sights_.clear();
    for (int camera = 0; camera < static_cast<int>(believed_.size()); ++camera) {
      for (int first = 0; first < frames; ++first) {
        for (int frame = 0; frame < frames; ++frame) {
          sights_.push_back(frame >= first ? sight_of(model(first, camera), model(frame, camera),
                                                      body(first, camera), body(frame, camera))
                                           : Sight{});
        }
      }
    }
  }

  const Sight& sight(int camera, int first, int frame) const {
    const std::size_t frames = frames_.size();
    return sights_[(static_cast<std::size_t>(camera) * frames + first) * frames + frame];
  }

  const CameraModel& model(int frame, int camera) const {
    return jumps() && frame >= jump_at_ ? jumped_cameras_[camera] : cameras_[camera];
  }

  const PictureBody& body(int frame, int camera) const {
    return bodies_[static_cast<std::size_t>(frame) * believed_.size() + camera];
  }

  bool residual(const Track& track, const Track::Seen& seen, const Point& point,
                Residual& out) const {
    return observe(model(seen.frame, track.camera),
                   sight(track.camera, track.seen.front().frame, seen.frame), point, seen.px, out);
  }

  // Sum of squares in sigmas with the room's prior; infinite where it cannot be seen.
  double squares(std::size_t t) const {
    const double from_mean = points_[t].z() - kDepthMean_per_m;
    double sum = depth_prior_[t] * from_mean * from_mean;
    Residual residual_here;
    for (const Track::Seen& seen : tracks_[t].seen) {
      if (!residual(tracks_[t], seen, points_[t], residual_here)) {
        return std::numeric_limits<double>::infinity();
      }
      sum += residual_here.r.squaredNorm() / variance_px2_;
    }
    return sum;
  }

  // The points where the poses as they are have them.
  void settle_points() {
    squares_.assign(tracks_.size(), 0);
    freedoms_.assign(tracks_.size(), 0);
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      for (int round = 0; round < 2; ++round) {
        Mat3 H = Mat3::Zero();
        Vec3 g = Vec3::Zero();
        Residual here;
        bool seen_by_all = true;
        for (const Track::Seen& seen : tracks_[t].seen) {
          if (!residual(tracks_[t], seen, points_[t], here)) {
            seen_by_all = false;
            break;
          }
          H += here.by_point.transpose() * here.by_point;
          g += here.by_point.transpose() * here.r;
        }
        H /= variance_px2_;
        g /= variance_px2_;
        if (!seen_by_all) {
          points_[t].z() /= 2;  // farther away
          continue;
        }
        // what the pictures show needs no prior: of many near things even a wide one would stretch
        // the room, and with it the wheels
        const double shown = std::max(0.0, depth_information(H));
        const double share = kDepthPrior / (kDepthPrior + shown);
        depth_prior_[t] = kDepthPrior * share * share;
        // each picture has two coordinates, of which a bearing takes two, and a depth another as
        // far as it is shown at all
        freedoms_[t] = 2 * static_cast<double>(tracks_[t].seen.size()) - 2 - (1 - share);
        H(2, 2) += depth_prior_[t];
        g[2] += depth_prior_[t] * (points_[t].z() - kDepthMean_per_m);
        move(points_[t], -H.ldlt().solve(g));
      }
      freedoms_[t] = std::max(freedoms_[t], 1.0);
      squares_[t] = squares(t);
    }
  }

  // As forgiving as the poses are wrong, by how well half of the tracks fit.
  double kernel_sigmas(double most, int by_camera) const {
    std::vector<double> shares;
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      if (asked(t, by_camera)) {
        shares.push_back(squares_[t] / freedoms_[t]);
      }
    }
    if (shares.empty()) {
      return kStrict;
    }
    const auto middle = shares.begin() + static_cast<std::ptrdiff_t>(shares.size() / 2);
    std::nth_element(shares.begin(), middle, shares.end());
    return std::clamp(kStrict * std::sqrt(*middle), kStrict, most);
  }

  void weigh(double kernel, int by_camera) {
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      const double share = squares_[t] / (kernel * kernel * freedoms_[t]);
      const bool counts = asked(t, by_camera) && std::isfinite(share);
      trusts_[t] = counts ? 1 / ((1 + share) * (1 + share)) : 0;
    }
  }

  void choose_inliers() {
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      trusts_[t] = squares_[t] <= chi_square_limit(freedoms_[t], options_.inlier_sigma) ? 1 : 0;
    }
  }

  // A thing next to a picture's plane may fall behind it with the last of the steps.
  void forget_what_went_behind() {
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      trusts_[t] = std::isfinite(squares_[t]) ? trusts_[t] : 0;
    }
  }

  // What is left over says how noisy features are, together with what was said of it before.
  // Corners lie on whole pixels: where things move along rows, most are left with nothing across
  // them, and would claim what no corner can.
  void learn_noise() {
    constexpr double kPriorFreedoms = 30;
    constexpr double kRounding_px2 = 1.0 / 12;
    double sum = kPriorFreedoms;
    double freedoms = kPriorFreedoms;
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      if (trusts_[t] > 0) {
        sum += squares_[t];
        freedoms += freedoms_[t];
      }
    }
    variance_px2_ = std::max(variance_px2_ * sum / freedoms, kRounding_px2);
  }

  static void move(Point& point, const Vec3& by) {
    point += by;
    point.z() = std::clamp(point.z(), kFarthest_per_m, kNearest_per_m);
  }

  // What track `t` says, its point integrated out.
  void add_track(std::size_t t, bool with_states) {
    const Track& track = tracks_[t];
    const int first = track.seen.front().frame;
    const int poses = 3 * (track.seen.back().frame - first + 1);
    const int jump = poses + kCameraStates;
    const int size = with_states ? jump + (jumps() ? kMountingStates : 0) : poses;
    scratch_.assign(static_cast<std::size_t>(size) * (size + 4), 0);
    Eigen::Map<Eigen::MatrixXd> H(scratch_.data(), size, size);
    Eigen::Map<Eigen::VectorXd> g(H.data() + H.size(), size);
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3>> B(g.data() + size, size, 3);
    Mat3 H_point = Mat3::Zero();
    Vec3 g_point = Vec3::Zero();
    Mat3 H_on_axis = Mat3::Zero();
    Residual here;
    const double weight = trusts_[t] / variance_px2_;
    for (const Track::Seen& seen : track.seen) {
      if (!residual(track, seen, points_[t], here)) {
        return;
      }
      const bool moves = seen.frame != first;
      differentiate(model(first, track.camera), model(seen.frame, track.camera),
                    body(first, track.camera), body(seen.frame, track.camera),
                    sight(track.camera, first, seen.frame), !moves, points_[t], here);
      const Mat23 by_point = weight * here.by_point;
      H_point += by_point.transpose() * here.by_point;
      g_point += by_point.transpose() * here.r;
      Mat23 on_axis = here.by_point;
      on_axis.col(2) = here.by_depth_on_axis;
      H_on_axis += on_axis.transpose() * on_axis / variance_px2_;
      const int at = 3 * (seen.frame - first);
      if (moves) {
        const Mat23 later = weight * here.by_frame;
        const Mat23 anchor = weight * here.by_anchor;
        H.block<3, 3>(at, at) += later.transpose() * here.by_frame;
        H.block<3, 3>(0, 0) += anchor.transpose() * here.by_anchor;
        H.block<3, 3>(at, 0) += later.transpose() * here.by_anchor;
        g.segment<3>(at) += later.transpose() * here.r;
        g.segment<3>(0) += anchor.transpose() * here.r;
        B.middleRows<3>(at) += later.transpose() * here.by_point;
        B.middleRows<3>(0) += anchor.transpose() * here.by_point;
      }
      // what it says of more unknowns, from a row on, and of them together with the poses
      const auto add = [&]<int kCount>(int row, const Eigen::Matrix<double, 2, kCount>& by) {
        const Eigen::Matrix<double, 2, kCount> weighted = weight * by;
        H.block<kCount, kCount>(row, row) += weighted.transpose() * by;
        g.segment<kCount>(row) += weighted.transpose() * here.r;
        B.middleRows<kCount>(row) += weighted.transpose() * here.by_point;
        if (moves) {
          H.block<kCount, 3>(row, at) += weighted.transpose() * here.by_frame;
          H.block<kCount, 3>(row, 0) += weighted.transpose() * here.by_anchor;
        }
      };
      if (with_states) {
        add(poses, here.by_camera);
      }
      if (with_states && jumps()) {
        add(jump, here.by_jump);
        const MountingJacobian jumped = weight * here.by_jump;
        H.block<kMountingStates, kCameraStates>(jump, poses) += jumped.transpose() * here.by_camera;
      }
    }
    H_point(2, 2) += trusts_[t] * depth_prior_[t];
    g_point[2] += trusts_[t] * depth_prior_[t] * (points_[t].z() - kDepthMean_per_m);
    const Mat3 inverse = H_point.inverse();
    if (!inverse.allFinite()) {
      return;
    }
    TrackSystem& system = systems_[t];
    system.point_by_rest = (-inverse).lazyProduct(B.transpose());
    system.point_step = -inverse * g_point;
    g += B * system.point_step;
    // the first keyframe of all is held; only the lower triangle is summed up
    const int held = first == 0 ? 3 : 0;
    for (int column = held; column < size; ++column) {
      H.col(column).tail(size - column) +=
          B.bottomRows(size - column).lazyProduct(system.point_by_rest.col(column));
    }
    const bool depth_shown =
        depth_information(H_on_axis) * kShownSigma_per_m * kShownSigma_per_m > 1;
    NormalEquations& sum = depth_shown ? sum_ : unshown_;
    const int moved = poses - held;
    const int pose_at = columns_.pose(first) + held;
    sum.gradient.segment(pose_at, moved) += g.segment(held, moved);
    sum.information.block(pose_at, pose_at, moved, moved) += H.block(held, held, moved, moved);
    const auto sum_unknowns = [&](int to, int from, int count) {
      sum.gradient.segment(to, count) += g.segment(from, count);
      sum.information.block(to, pose_at, count, moved) += H.block(from, held, count, moved);
      sum.information.block(to, to, count, count) += H.block(from, from, count, count);
    };
    if (with_states) {
      const int states_at = columns_.camera(track.camera);
      sum_unknowns(states_at, poses, kCameraStates);
      if (jumps()) {
        const int jump_at = columns_.jump(track.camera);
        sum_unknowns(jump_at, jump, kMountingStates);
        sum.information.block<kMountingStates, kCameraStates>(jump_at, states_at) +=
            H.block<kMountingStates, kCameraStates>(jump, poses);
      }
    }
    if (keeps_scores_) {
      Eigen::VectorXd score = Eigen::VectorXd::Zero(columns_.size());
      score.segment(pose_at, moved) = g.segment(held, moved);
      score.segment<kCameraStates>(columns_.camera(track.camera)) = g.segment<kCameraStates>(poses);
      score.segment<kMountingStates>(columns_.jump(track.camera)) =
          g.segment<kMountingStates>(jump);
      (depth_shown ? scores_ : unshown_scores_).push_back(std::move(score));
    }
  }

  void add_odometry(int frame) {
    const Pose2& from = poses_[frame - 1];
    const Pose2 relative = from.inverse() * poses_[frame];
    const BundleFrame& here = frames_[frame];
    const Eigen::Matrix<double, kWheelStates, 1> wheels =
        state_.segment<kWheelStates>(columns_.wheels);
    // What the wheels would have told of this motion, and not what they told put right: that would
    // be scaled with its noise, which is less the smaller the wheels are.
    const WheelJacobian by_wheels =
        here.by_wheels ? here.by_wheels(relative) : WheelJacobian::Zero().eval();
    const Vec3 off = by_wheels * wheels;
    const Vec3 r(relative.x_m - off.x() - here.T_before_here.x_m,
                 relative.y_m - off.y() - here.T_before_here.y_m,
                 wrap_angle(relative.theta_rad - off.z() - here.T_before_here.theta_rad));
    Mat3 by_from = Mat3::Zero();
    Mat3 by_here = Mat3::Identity();
    const Mat2 Rt = from.rotation().transpose();
    by_here.topLeftCorner<2, 2>() = Rt;
    by_from.topLeftCorner<2, 2>() = -Rt;
    by_from.col(2) = Vec3(relative.y_m, -relative.x_m, -1);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, columns_.size());
    if (frame > 1) {
      J.middleCols<3>(columns_.pose(frame - 1)) = by_from;
    }
    J.middleCols<3>(columns_.pose(frame)) = by_here;
    J.middleCols<kWheelStates>(columns_.wheel()) = -by_wheels;
    const Mat3 W = here.covariance.inverse();
    sum_.information += J.transpose() * W * J;
    sum_.gradient += J.transpose() * (W * r);
  }

  // Where the path does not show a depth, a baseline and the depth explain noise together, the
  // better the longer the baseline: thousands of such depths would claim one that is not there
  // (Neyman and Scott 1948). What such tracks say of the headings, all else given, is kept, and
  // what they say of baselines and of the rig is not; nor does a jump's turn need a baseline.
  void keep_headings(NormalEquations& of) {
    std::vector<int> headings;
    std::vector<int> rest;
    for (int k = 0; k < columns_.size(); ++k) {
      const bool turns = columns_.is_jump(k) ? (k - columns_.jump(0)) % kMountingStates < kPosition
                                             : k < columns_.poses && k % 3 == 2;
      (turns ? headings : rest).push_back(k);
    }
    Eigen::MatrixXd among = of.information(headings, headings);
    among.diagonal().array() += 1e-9 * (1 + among.trace());
    const Eigen::MatrixXd across = of.information(headings, rest);
    const Eigen::MatrixXd K = among.ldlt().solve(across);
    of.information(rest, rest) = across.transpose() * K;
    of.gradient(rest) = K.transpose() * of.gradient(headings);
    for (Eigen::VectorXd& score : unshown_scores_) {
      score(rest) = (K.transpose() * score(headings)).eval();
    }
  }

  void sum_up(bool with_states) {
    sum_ = NormalEquations(columns_.size());
    unshown_ = NormalEquations(columns_.size());
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      systems_[t].point_by_rest.resize(3, 0);
      if (trusts_[t] > 0) {
        add_track(t, with_states);
      }
    }
    for (NormalEquations* one : {&sum_, &unshown_}) {
      one->information.triangularView<Eigen::StrictlyUpper>() = one->information.transpose();
    }
    keep_headings(unshown_);
    std::move(unshown_scores_.begin(), unshown_scores_.end(), std::back_inserter(scores_));
    sum_.information += unshown_.information;
    sum_.gradient += unshown_.gradient;
    of_tracks_ = sum_.information;
    for (int frame = 1; frame < static_cast<int>(frames_.size()); ++frame) {
      add_odometry(frame);
    }
  }

  // Poses and points move, and the states where they are free. Returns what the squared error in
  // sigmas was to gain by it.
  double step() {
    const int states = free() ? columns_.states : 0;
    const int moved = free() ? columns_.size() : columns_.poses;
    Eigen::MatrixXd H = sum_.information.topLeftCorner(moved, moved);
    Eigen::VectorXd g = sum_.gradient.head(moved);
    if (free()) {
      H.block(columns_.poses, columns_.poses, states, states) += prior_.information;
      g.segment(columns_.poses, states) += prior_.information * (state_ - prior_.state);
      for (int k = 0; k < columns_.jumps; ++k) {
        const double sigma = mounting_jump_sigmas()[k % kMountingStates];
        H(columns_.jump(0) + k, columns_.jump(0) + k) += 1 / (sigma * sigma);
        g[columns_.jump(0) + k] += jump_[k] / (sigma * sigma);
      }
    }
    Eigen::VectorXd all = Eigen::VectorXd::Zero(columns_.size());
    all.head(moved) = -H.ldlt().solve(g);
    if (!all.allFinite()) {
      return 0;
    }
    for (int frame = 1; frame < static_cast<int>(frames_.size()); ++frame) {
      const auto d = all.segment<3>(columns_.pose(frame));
      Pose2& pose = poses_[frame];
      pose = {pose.x_m + d.x(), pose.y_m + d.y(), wrap_angle(pose.theta_rad + d.z())};
    }
    state_ += all.segment(columns_.poses, columns_.states);
    jump_.head(columns_.jumps) += all.tail(columns_.jumps);
    place_cameras();
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      const auto& by_rest = systems_[t].point_by_rest;
      if (by_rest.cols() == 0) {
        continue;
      }
      const Track& track = tracks_[t];
      const int first = track.seen.front().frame;
      const int poses = 3 * (track.seen.back().frame - first + 1);
      const int held = first == 0 ? 3 : 0;
      Vec3 d = systems_[t].point_step;
      d += by_rest.middleCols(held, poses - held) *
           all.segment(columns_.pose(first) + held, poses - held);
      if (by_rest.cols() > poses) {
        d += by_rest.middleCols<kCameraStates>(poses) *
             all.segment<kCameraStates>(columns_.camera(track.camera));
      }
      if (by_rest.cols() > poses + kCameraStates) {
        d += by_rest.rightCols<kMountingStates>() *
             all.segment<kMountingStates>(columns_.jump(track.camera));
      }
      move(points_[t], d);
    }
    return -g.dot(all.head(moved));
  }

  BundleOptions options_;
  const LoopCameras& believed_;
  const RigPriorState& prior_;
  RigState state_;
  const std::vector<BundleFrame>& frames_;
  const std::vector<Track>& tracks_;
  Columns columns_;
  const std::vector<Pose2>& start_;
  int jump_at_;
  Eigen::VectorXd jump_;
  std::vector<CameraModel> cameras_;
  std::vector<CameraModel> jumped_cameras_;
  std::vector<Pose2> poses_;
  std::vector<Point> points_;
  double variance_px2_ = 1;
  std::vector<PictureBody> bodies_;
  std::vector<Sight> sights_;  // by camera, the first keyframe, the later one
  std::vector<double> squares_;
  std::vector<double> freedoms_;
  std::vector<double> depth_prior_;  // information
  std::vector<double> trusts_;
  std::vector<TrackSystem> systems_;
  std::vector<double> scratch_;
  NormalEquations sum_{0};
  NormalEquations unshown_{0};  // of the tracks whose depth the path does not show
  Eigen::MatrixXd of_tracks_;   // information in `sum_`, and the gradients that make up its own:
  bool keeps_scores_ = false;
  std::vector<Eigen::VectorXd> scores_;
  std::vector<Eigen::VectorXd> unshown_scores_;
};

void check(const std::vector<BundleFrame>& frames, const std::vector<Track>& tracks,
           const std::vector<Pose2>& start_T_first_frame) {
  PANOPTES_CHECK(frames.size() >= 2 && start_T_first_frame.size() == frames.size(),
                 "a pose for each of two keyframes or more");
  for (const Track& track : tracks) {
    PANOPTES_CHECK(track.seen.size() >= 2, "a track is seen twice");
  }
}

}  // namespace

MountingChange mounting_jump_sigmas() {
  constexpr double kTurned_rad = deg_to_rad(2);
  constexpr double kShifted_m = 0.02;
  MountingChange sigmas;
  sigmas << kTurned_rad, kTurned_rad, kTurned_rad, kShifted_m, kShifted_m, kShifted_m;
  return sigmas;
}

BundleSolution adjust_bundle(const BundleOptions& options, const LoopCameras& believed,
                             const RigPriorState& prior, const std::vector<BundleFrame>& frames,
                             const std::vector<Track>& tracks,
                             const std::vector<Pose2>& start_T_first_frame) {
  check(frames, tracks, start_T_first_frame);
  Bundle bundle(options, believed, prior, frames, tracks, start_T_first_frame, kNoJump);
  bundle.adjust();
  return bundle.solution();
}

MountingJump mounting_jump(const BundleOptions& options, const LoopCameras& believed,
                           const RigPriorState& prior, const std::vector<BundleFrame>& frames,
                           const std::vector<Track>& tracks,
                           const std::vector<Pose2>& start_T_first_frame, int jump_at) {
  check(frames, tracks, start_T_first_frame);
  PANOPTES_CHECK(
      jump_at > 0 && jump_at < static_cast<int>(frames.size()) && prior.information.size() > 0,
      "a jump between two of the keyframes, of a rig that is not held");
  Bundle bundle(options, believed, prior, frames, tracks, start_T_first_frame, jump_at);
  bundle.adjust();
  return bundle.jump();
}

}  // namespace panoptes
