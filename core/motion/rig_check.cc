// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/rig_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr double kOnTheSpot_m = 0.05;  // a turn that moves the body by less
constexpr double kDriven_m = 0.08;     // a drive moves it by more,
constexpr double kStraight_rad = 0.4;  // and turns it by less
constexpr int kFewestMatches = 12;
constexpr int kFewestTurns = 12;
constexpr int kFewestDrives = 3;
constexpr int kKeyframes = 400;  // after so many the rig file has been checked
constexpr double kSteep_rad = deg_to_rad(75);
constexpr double kTurned_rad = deg_to_rad(4);  // turns that are told apart from noise
constexpr double kLensTolerance = 0.1;         // of what a turn shows
constexpr double kFarShare = 0.25;  // of a picture of a turn is about as far as drives show
constexpr double kFarther = 3;      // than along drives
constexpr double kNearer = 1.5;
constexpr double kFewestFlow_px = 1000;

double quantile(std::vector<double>& values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * values.size());
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double median(std::vector<double>& values) { return quantile(values, 0.5); }

Mat3 about_vertical(double turn_rad) {
  return Eigen::AngleAxisd(turn_rad, Vec3::UnitZ()).toRotationMatrix();
}

// How far ahead of the axis of turning a camera sits, in the direction in which it looks.
double ahead_m(const LoopCamera& camera) {
  const Vec3 axis = camera.T_body_camera.rotation * Vec3::UnitZ();
  return axis.head<2>().dot(camera.T_body_camera.translation.head<2>());
}

// Of a point from a line between two others.
double squared_distance(const Vec2& point, const Vec2& from, const Vec2& to) {
  const Vec2 along = to - from;
  const double length2 = along.squaredNorm();
  const double share = length2 > 0 ? std::clamp((point - from).dot(along) / length2, 0.0, 1.0) : 0;
  return (point - from - share * along).squaredNorm();
}

// Whether both say the same: plainly larger, or plainly smaller.
bool agree(double off, double other_off) {
  return std::min(off, other_off) > kLensTolerance || std::max(off, other_off) < -kLensTolerance;
}

}  // namespace

RigCheck::RigCheck(const FeatureOptions& features, LoopCameras believed)
    : features_(features), believed_(std::move(believed)), seen_(believed_.size()) {
  for (std::size_t camera = 0; camera < believed_.size(); ++camera) {
    const Pose3& told = believed_[camera].T_body_camera;
    std::vector<Look>& looks = seen_[camera].looks;
    looks.push_back({told});
    for (std::size_t other = 0; other < believed_.size(); ++other) {
      if (other != camera) {
        looks.push_back({believed_[other].T_body_camera});
      }
    }
    // mirrored at the body's plane x z, the picture's x axis with it; and looking the other way
    const Mat3 mirror = Vec3(1, -1, 1).asDiagonal();
    const Mat3 flip = Vec3(-1, 1, 1).asDiagonal();
    const Mat3 R = told.rotation.toRotationMatrix();
    looks.push_back(
        {Pose3{Eigen::Quaterniond(Mat3(mirror * R * flip)), mirror * told.translation}});
    looks.push_back(
        {Pose3{Eigen::Quaterniond(Mat3(about_vertical(std::numbers::pi) * R)), told.translation}});
  }
}

void RigCheck::add_odometry(Time stamp, double theta_rad) {
  if (keyframes_ < kKeyframes && (odometry_.empty() || odometry_.back().first < stamp)) {
    odometry_.emplace_back(stamp, theta_rad);
  }
}

// By the wheels; no number where they told nothing. A stamp that a clock sets a little before or
// after all that they told has the motion go on.
double RigCheck::turned_rad(Time from, Time to) const {
  constexpr Duration kGoesOn = std::chrono::milliseconds(50);
  const auto theta = [&](Time at) {
    if (odometry_.size() < 2 || at < odometry_.front().first - kGoesOn ||
        at > odometry_.back().first + kGoesOn) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    const auto after = std::lower_bound(
        odometry_.begin() + 1, odometry_.end() - 1, at,
        [](const std::pair<Time, double>& told, Time time) { return told.first < time; });
    const auto before = after - 1;
    const double share = to_seconds(at - before->first) / to_seconds(after->first - before->first);
    return before->second + share * wrap_angle(after->second - before->second);
  };
  return wrap_angle(theta(to) - theta(from));
}

void RigCheck::add_keyframe(Time taken, const PictureTimes& times, const PlaceFeatures& features,
                            const Pose2& T_last_here) {
  PANOPTES_CHECK(features.size() == believed_.size(), "a picture's features a camera");
  if (keyframes_ >= kKeyframes) {
    return;
  }
  std::vector<Time> taken_here;
  for (std::size_t camera = 0; camera < believed_.size(); ++camera) {
    taken_here.push_back(taken + from_seconds(times.late_s[camera]));
  }
  for (int camera = 0; keyframes_ > 0 && camera < static_cast<int>(believed_.size()); ++camera) {
    const LocalFeatures& before = last_[camera];
    const LocalFeatures& here = features[camera];
    const std::vector<FeatureMatch> matches = match_features(features_, before, here);
    if (static_cast<int>(matches.size()) < kFewestMatches) {
      continue;
    }
    const double distance_m = T_last_here.position().norm();
    if (distance_m <= kOnTheSpot_m) {
      add_turn(camera, last_taken_[camera], taken_here[camera], before, here, matches);
    } else if (distance_m >= kDriven_m && std::abs(T_last_here.theta_rad) <= kStraight_rad) {
      const double turned = turned_rad(last_taken_[camera], taken_here[camera]);
      if (std::isfinite(turned)) {
        add_drive(camera, Pose2{T_last_here.x_m, T_last_here.y_m, turned}, before, here, matches);
      }
    }
  }
  ++keyframes_;
  last_ = features;
  last_taken_ = std::move(taken_here);
  for (std::string (RigCheck::*wrong)() const :
       {&RigCheck::wrong_look, &RigCheck::wrong_clock, &RigCheck::wrong_lens}) {
    if (fault_.empty()) {
      fault_ = (this->*wrong)();
    }
  }
  if (keyframes_ >= kKeyframes) {
    odometry_.clear();
    last_.clear();
  }
}

void RigCheck::add_turn(int camera, Time from, Time to, const LocalFeatures& before,
                        const LocalFeatures& here, const std::vector<FeatureMatch>& matches) {
  const LoopCamera& believed = believed_[camera];
  const auto direction = [&](const Eigen::Vector2f& px) {
    return (believed.T_body_camera.rotation * believed.intrinsics.ray(px.cast<double>()))
        .normalized();
  };
  Turn turn{from, to, 0, 0, {}};
  std::vector<double> turns_rad;
  for (const FeatureMatch& match : matches) {
    const Vec3 a = direction(before.px[match.a]);
    const Vec3 b = direction(here.px[match.b]);
    if (std::max(std::abs(a.z()), std::abs(b.z())) < std::sin(kSteep_rad)) {
      turns_rad.push_back(wrap_angle(std::atan2(a.y(), a.x()) - std::atan2(b.y(), b.x())));
      turn.px.emplace_back(before.px[match.a], here.px[match.b]);
    }
  }
  if (static_cast<int>(turns_rad.size()) < kFewestMatches) {
    return;
  }
  turn.seen_rad = median(turns_rad);
  turn.far_rad = turn.seen_rad;
  if (const double by_m = ahead_m(believed); std::abs(by_m) > kOnTheSpot_m) {
    turn.far_rad =
        quantile(turns_rad, (by_m > 0) == (turn.seen_rad > 0) ? kFarShare : 1 - kFarShare);
  }
  Seen& seen = seen_[camera];
  seen.turns.push_back(std::move(turn));
  if (seen.turns.size() % kFewestTurns == 0) {
    seen.lens = best_fit([&](double ratio) { return turns_misfit_px2(camera, ratio, 1); });
    seen.wheels = best_fit([&](double ratio) { return turns_misfit_px2(camera, 1, ratio); });
  }
}

void RigCheck::add_drive(int camera, const Pose2& T_last_here, const LocalFeatures& before,
                         const LocalFeatures& here, const std::vector<FeatureMatch>& matches) {
  constexpr double kFar = 0.05;    // of a depth, driven: what is expected points along the flow
  constexpr double kLeast_px = 1;  // less tells no direction,
  constexpr double kMost_px = 15;  // and more counts no more
  const Intrinsics& lens = believed_[camera].intrinsics;
  const Mat3 R_here_last = about_vertical(-T_last_here.theta_rad);
  Seen& seen = seen_[camera];
  std::vector<double> inverse_depths_m;
  for (Look& look : seen.looks) {
    const Mat3 R = look.T_body_camera.rotation.toRotationMatrix();
    const Vec3& origin = look.T_body_camera.translation;
    Vec3 moved = origin - R_here_last * origin;  // the camera, in the body's axes now
    moved.head<2>() += T_last_here.rotation().transpose() * T_last_here.position();
    const double moved_m = moved.norm();
    moved /= moved_m;
    for (const FeatureMatch& match : matches) {
      const Vec3 turned = R_here_last * (R * lens.ray(before.px[match.a].cast<double>()));
      const Vec3 still = R.transpose() * turned;
      const Vec3 nearer = R.transpose() * (turned - kFar * moved);
      if (still.z() < kFar || nearer.z() < kFar) {
        continue;
      }
      const Vec2 from = lens.project(still);
      const Vec2 expected = lens.project(nearer) - from;
      const Vec2 flow = here.px[match.b].cast<double>() - from;
      const double length_px = flow.norm();
      if (length_px >= kLeast_px && expected.norm() > 0) {
        const double weight_px = std::min(length_px, kMost_px);
        look.agreed_px += weight_px * flow.dot(expected) / (length_px * expected.norm());
        look.flow_px += weight_px;
      }
      if (&look == &seen.looks.front() && expected.norm() > kLeast_px) {
        inverse_depths_m.push_back(flow.dot(expected) / expected.squaredNorm() * kFar / moved_m);
      }
    }
  }
  if (!inverse_depths_m.empty()) {
    seen.inverse_depths_m.push_back(median(inverse_depths_m));
  }
}

bool RigCheck::has_driven(int camera) const {
  const Seen& seen = seen_[camera];
  return static_cast<int>(seen.inverse_depths_m.size()) >= kFewestDrives &&
         seen.looks.front().flow_px >= kFewestFlow_px;
}

// What a camera shows of turns on the spot, or of what stands far in them, as a share of what the
// wheels turned so long before its stamps; no number before it is known.
double RigCheck::turn_ratio(int camera, double Turn::*seen_rad, Duration before) const {
  std::vector<double> ratios;
  for (const Turn& turn : seen_[camera].turns) {
    const double by_wheels = turned_rad(turn.from - before, turn.to - before);
    if (std::abs(by_wheels) >= kTurned_rad) {
      ratios.push_back(turn.*seen_rad / by_wheels);
    }
  }
  if (static_cast<int>(ratios.size()) < kFewestTurns) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return median(ratios);
}

// Of those shares that a lens or wheels may be wrong by.
template <typename Misfit>
RigCheck::Fit RigCheck::best_fit(const Misfit& misfit_of_ratio) {
  constexpr double kStep = 0.05;
  constexpr int kMostSteps = 6;
  const double as_told = misfit_of_ratio(1.0);
  Fit best;
  for (int n = -kMostSteps; n <= kMostSteps; ++n) {
    const double ratio = n == 0 ? 1 : misfit_of_ratio(1 + n * kStep) / as_told;
    if (ratio < best.misfit_ratio) {
      best = {n * kStep, ratio};
    }
  }
  return best;
}

// What the last turns on the spot show against what they should by such a lens and such wheels,
// wherever each thing stands: the mean of squared distances, each at most as much as one that
// matches nothing.
double RigCheck::turns_misfit_px2(int camera, double focal_ratio, double wheels_ratio) const {
  constexpr double kNearest_m = 0.1;  // a wall that a camera at the body's edge passes
  constexpr double kMost_px2 = 25;
  constexpr double kAhead = 0.05;  // of a direction, along the lens' axis
  Intrinsics lens = believed_[camera].intrinsics;
  lens.fx_px *= focal_ratio;
  lens.fy_px *= focal_ratio;
  const Mat3 R = believed_[camera].T_body_camera.rotation.toRotationMatrix();
  const Vec3& origin = believed_[camera].T_body_camera.translation;
  double sum_px2 = 0;
  int count = 0;
  const std::vector<Turn>& turns = seen_[camera].turns;
  const auto last = turns.size() - std::min<std::size_t>(turns.size(), 2 * kFewestTurns);
  for (const Turn& turn : std::span(turns).subspan(last)) {
    const double turned_by_rad = wheels_ratio * turned_rad(turn.from, turn.to);
    if (!std::isfinite(turned_by_rad)) {
      continue;
    }
    const Mat3 R_here_last = about_vertical(-turned_by_rad);
    const Mat3 R_camera = R.transpose() * R_here_last * R;
    const Vec3 moved = R.transpose() * (origin - R_here_last * origin);
    for (const auto& [before_px, here_px] : turn.px) {
      const Vec3 still = R_camera * lens.ray(before_px.cast<double>()).normalized();
      // of inverse depths, those at which a thing is ahead of the camera
      const double ahead = still.z() - kAhead;
      const double farthest_per_m = moved.z() < 0 ? std::max(0.0, ahead / moved.z()) : 0;
      const double nearest_per_m =
          moved.z() > 0 ? std::min(1 / kNearest_m, ahead / moved.z()) : 1 / kNearest_m;
      double off_px2 = kMost_px2;
      if (farthest_per_m <= nearest_per_m && (ahead >= 0 || moved.z() < 0)) {
        const Vec2 far_px = lens.project(still - farthest_per_m * moved);
        const Vec2 near_px = lens.project(still - nearest_per_m * moved);
        off_px2 = std::min(off_px2, squared_distance(here_px.cast<double>(), far_px, near_px));
      }
      sum_px2 += off_px2;
      ++count;
    }
  }
  return count > 0 ? sum_px2 / count : kMost_px2;
}

// The one that explains what driving shows, where the rig file's plainly does not; null elsewhere.
const RigCheck::Look* RigCheck::other_look(int camera) const {
  constexpr double kWrong = 0.2;  // agrees with no more of the flow than this,
  constexpr double kRight = 0.5;  // and the true one with as much more
  const std::vector<Look>& looks = seen_[camera].looks;
  if (!has_driven(camera) || looks.front().agreed() > kWrong) {
    return nullptr;
  }
  const auto best = std::max_element(looks.begin(), looks.end(), [](const Look& a, const Look& b) {
    return a.agreed() < b.agreed();
  });
  return best->agreed() >= looks.front().agreed() + kRight ? &*best : nullptr;
}

// The one that the rig file says looks that way; -1 where none does.
int RigCheck::camera_told_to(const Look& look) const {
  constexpr double kSame_rad = deg_to_rad(20);
  for (int camera = 0; camera < static_cast<int>(believed_.size()); ++camera) {
    const Eigen::Quaterniond& told = believed_[camera].T_body_camera.rotation;
    if (told.angularDistance(look.T_body_camera.rotation) < kSame_rad) {
      return camera;
    }
  }
  return -1;
}

std::string RigCheck::wrong_look() const {
  for (int camera = 0; camera < static_cast<int>(believed_.size()); ++camera) {
    const std::string& name = believed_[camera].name;
    if (turn_ratio(camera, &Turn::seen_rad) < -0.5) {
      return fmt::format(
          "{} looks mirrored or upside down: what it shows turns the wrong way; see its roll_deg "
          "in the rig file, and whether its driver mirrors pictures",
          name);
    }
    const Look* look = other_look(camera);
    if (look == nullptr) {
      continue;
    }
    const int other = camera_told_to(*look);
    if (other >= 0 && other_look(other) != nullptr) {
      return fmt::format(
          "{} and {} look swapped: each shows what the other should; exchange them in the rig "
          "file, or their cables",
          name, believed_[other].name);
    }
    const auto drives = static_cast<int>(seen_[camera].inverse_depths_m.size());
    if (other < 0 || drives >= 3 * kFewestDrives) {
      const Vec3 axis = look->T_body_camera.rotation * Vec3::UnitZ();
      return fmt::format(
          "{} does not look where the rig file says: by what driving shows its yaw is about {:.0f} "
          "degrees",
          name, rad_to_deg(std::atan2(axis.y(), axis.x())));
    }
  }
  return "";
}

std::string RigCheck::wrong_clock() const {
  constexpr double kMost_s = 1;
  constexpr double kStep_s = 0.05;
  constexpr double kLeast_s = 0.15;
  constexpr double kUnlike_rad = 0.1;  // a turn that differs by more counts no more
  constexpr double kGain_rad = 0.3;    // three such turns
  for (int camera = 0; camera < static_cast<int>(believed_.size()); ++camera) {
    const std::vector<Turn>& turns = seen_[camera].turns;
    if (static_cast<int>(turns.size()) < kFewestTurns) {
      continue;
    }
    // stamps that are wrong tell no ratio either: each clock has its own
    const auto cost = [&](double late_s) {
      double sum = 0;
      const auto by = from_seconds(late_s);
      const double ratio = turn_ratio(camera, &Turn::seen_rad, by);
      for (const Turn& turn : turns) {
        const double off = turn.seen_rad - ratio * turned_rad(turn.from - by, turn.to - by);
        sum += std::isfinite(off) ? std::min(std::abs(off), kUnlike_rad) : 0.5 * kUnlike_rad;
      }
      return sum;
    };
    const double as_told = cost(0);
    if (as_told < kGain_rad) {
      continue;
    }
    double best_s = 0;
    double least = as_told;
    for (double late_s = -kMost_s; late_s <= kMost_s + kStep_s / 2; late_s += kStep_s) {
      const double there = cost(late_s);
      if (there < least) {
        least = there;
        best_s = late_s;
      }
    }
    if (std::abs(best_s) >= kLeast_s && as_told - least >= kGain_rad && least <= 0.4 * as_told) {
      return fmt::format(
          "the stamps of {} look {:.2f} s {} against the odometry's: see "
          "clock_offset_s in the rig file",
          believed_[camera].name, std::abs(best_s), best_s > 0 ? "late" : "early");
    }
  }
  return "";
}

std::string RigCheck::wrong_lens() const {
  constexpr double kPlainly = 0.75;
  const int cameras = static_cast<int>(believed_.size());
  const auto named = [&](int camera, double off) {
    return fmt::format(
        "the field of view of {} looks wrong: it shows turns {:.0f} % {} than the {}; see fov_deg "
        "in the rig file",
        believed_[camera].name, 100 * std::abs(off), off > 0 ? "larger" : "smaller",
        cameras > 1 ? "wheels and the others" : "wheels");
  };
  for (int camera = 0; camera < cameras; ++camera) {
    const Fit& lens = seen_[camera].lens;
    if (has_driven(camera) && std::abs(lens.off) > kLensTolerance && lens.misfit_ratio < kPlainly) {
      return named(camera, lens.off);
    }
  }
  std::vector<double> off;
  for (int camera = 0; camera < cameras; ++camera) {
    const double ratio = turn_ratio(camera, &Turn::far_rad);
    if (!std::isfinite(ratio) || !has_driven(camera)) {
      return "";
    }
    // what stands near shows more of a turn to a camera ahead of the axis
    std::vector<double> inverse_depths_m = seen_[camera].inverse_depths_m;
    const double by_depth = ahead_m(believed_[camera]) * std::max(0.0, median(inverse_depths_m));
    const auto [lower, upper] = std::minmax({by_depth / kFarther, by_depth * kNearer});
    off.push_back(ratio / std::clamp(ratio, 1 + lower, 1 + upper) - 1);
  }
  // Where the body turns things may stand nearer than where it drives. But what stands near moves
  // as no other lens shows it: that has to agree.
  int wrong = -1;
  const auto [least, most] = std::minmax_element(off.begin(), off.end());
  bool all_agree = cameras > 1 && agree(*least, *most);
  for (int camera = 0; camera < cameras; ++camera) {
    all_agree = all_agree && agree(off[camera], seen_[camera].wheels.off);
    if (agree(off[camera], seen_[camera].lens.off) &&
        (wrong < 0 || std::abs(off[camera]) > std::abs(off[wrong]))) {
      wrong = camera;
    }
  }
  if (all_agree) {
    return fmt::format(
        "all cameras show turns {:.0f} % {} than the wheels: the wheel base or all fields of view "
        "look wrong",
        100 * std::abs(0.5 * (*least + *most)), *least > 0 ? "larger" : "smaller");
  }
  return wrong < 0 ? "" : named(wrong, off[wrong]);
}

}  // namespace panoptes
