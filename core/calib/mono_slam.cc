// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/mono_slam.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/check.h"
#include "core/base/median.h"
#include "core/calib/camera_by_points.h"
#include "core/calib/patch.h"
#include "core/calib/patch_warp.h"
#include "core/camera/lens_parameters.h"
#include "core/geometry/cross_matrix.h"

namespace panoptes {
namespace {

// A cell in which nothing was found is looked at again after so many pictures.
constexpr int kCellRests = 8;
// Farther than this it is not looked for: whatever is found there is chance.
constexpr double kFarthest_px = 80;
// Of a point that is found less often than every second time of at least so many.
constexpr int kFewestSought = 10;
// A lost camera looks for itself every so many pictures, and knows then where it is to some pixels.
constexpr int kLooksAgain = 3;
constexpr double kFoundAgain_rad = 0.01;
constexpr double kKnownRatio = 0.2;  // by points known to this share of their distance
// Fewer than so many points hold no camera.
constexpr int kFewestFound = 4;
// How well places are found is learned from the innovations of some dozens of pictures (Mehra
// 1970), within what patches can do.
constexpr double kLearns = 0.1;
constexpr int kFewestLearnt = 8;
constexpr double kMostOff = 3;
constexpr double kLeastSigma_px = 0.03;
constexpr double kMostSigma_px = 2;
// Of what is found while it starts, over some pictures.
constexpr double kLeastAgreeing = 0.7;
constexpr double kForgets = 0.3;
constexpr std::size_t kLongestStart = 90;  // pictures

/// The noise of a picture, grey levels, by the median of second differences, which neither
/// edges nor slopes move, so that it holds where all is textured too: of every fourth row.
double noise_of(const cv::Mat& grey) {
  std::vector<int> differences;
  differences.reserve(static_cast<std::size_t>(grey.rows / 4 * grey.cols / 2));
  for (int y = 1; y + 1 < grey.rows; y += 4) {
    const std::uint8_t* above = grey.ptr<std::uint8_t>(y - 1);
    const std::uint8_t* here = grey.ptr<std::uint8_t>(y);
    const std::uint8_t* below = grey.ptr<std::uint8_t>(y + 1);
    for (int x = 1; x + 1 < grey.cols; x += 2) {
      // Immerkaer 1996
      differences.push_back(std::abs(above[x - 1] - 2 * above[x] + above[x + 1] - 2 * here[x - 1] +
                                     4 * here[x] - 2 * here[x + 1] + below[x - 1] - 2 * below[x] +
                                     below[x + 1]));
    }
  }
  constexpr double kMedianOfNormal = 0.6745;
  constexpr double kGain = 6;
  constexpr double kRounding = 0.29;
  return std::max(kRounding, median(std::move(differences)) / (kMedianOfNormal * kGain));
}

bool is_inside(const Intrinsics& lens, const Vec2& px, double border_px) {
  return px.x() >= border_px && px.y() >= border_px && px.x() <= lens.width_px - 1 - border_px &&
         px.y() <= lens.height_px - 1 - border_px;
}

/// Where there is room for what is kept of a point.
cv::Rect usable(const cv::Mat& grey) {
  constexpr int kBorder_px = Patch::kSourceHalf_px + 1;
  return {kBorder_px, kBorder_px, grey.cols - 2 * kBorder_px, grey.rows - 2 * kBorder_px};
}

/// About the map's axes.
Vec3 turn_between(const Pose3& T_map_before, const Pose3& T_map_now) {
  const Eigen::AngleAxisd turn(T_map_now.rotation * T_map_before.rotation.conjugate());
  return turn.angle() * turn.axis();
}

void believe(const FilterUpdate& update, MonoSlamStep& step) {
  step.squared_sigmas = update.squared_sigmas;
  step.dof = update.dof;
  std::size_t next = 0;
  for (PointSought& sought : step.sought) {
    sought.inlier = sought.found_px && update.inlier[next++];
  }
}

}  // namespace

MonoSlam::MonoSlam(const MonoSlamOptions& options, const Intrinsics& lens)
    : options_(options),
      lens_(lens),
      filter_(options.filter, lens),
      try_cell_from_(static_cast<std::size_t>(options.columns * options.rows), 0),
      match_sigma_px_(options.match_sigma_px) {
  start_is_known_ = options.motion_is_told;
  if (!options.motion_is_told) {
    start_.emplace(options.filter, lens, options.match_sigma_px);
  }
}

// How the place in the first picture moves with one in this picture. Empty where it looks too
// different.
std::optional<Mat2> MonoSlam::source_by_px(const Tracked& tracked, int number) const {
  const Pose3& T_map_camera = filter_.T_map_camera();
  const FilteredPoint& point = filter_.point(number);
  const Vec3 p_map = point.p_map();
  const bool is_far = !p_map.allFinite();
  PointFromBoth both;
  both.from_first = is_far ? ray_of_angles(point.state[3], point.state[4])
                           : Vec3(p_map - tracked.T_map_first.translation);
  both.from_now = is_far ? both.from_first : Vec3(p_map - T_map_camera.translation);
  both.R_now_first =
      (T_map_camera.rotation.conjugate() * tracked.T_map_first.rotation).toRotationMatrix();
  both.p_now = T_map_camera.rotation.conjugate() * both.from_now;
  return panoptes::source_by_px(both, filter_.lens(), tracked.direction_by_px);
}

// Empty for a point that cannot be looked for from here.
std::optional<PointSought> MonoSlam::seek(const cv::Mat& grey, int number) const {
  const std::optional<PointExpected> expected = filter_.expected(number);
  if (!expected || !is_inside(lens_, expected->px, Patch::kHalf_px + 1)) {
    return std::nullopt;
  }
  const Tracked& tracked = tracked_.at(number);
  const std::optional<Mat2> by_px = source_by_px(tracked, number);
  Mat2 S = expected->covariance_px2 + match_sigma_px_ * match_sigma_px_ * Mat2::Identity();
  double reach_px = options_.search_sigmas * std::sqrt(S.diagonal().maxCoeff());
  if (start_ && reach_px > kFarthest_px) {  // how it moves is not known yet: near first
    S *= kFarthest_px * kFarthest_px / (reach_px * reach_px);
    reach_px = kFarthest_px;
  }
  const std::optional<Patch> patch = by_px && reach_px <= kFarthest_px
                                         ? Patch::seen(tracked.source, tracked.offset_px, *by_px)
                                         : std::nullopt;
  if (!patch) {
    return std::nullopt;
  }
  PointSought sought{number, *expected, std::nullopt, false};
  const std::optional<Patch::Found> found =
      patch->find(grey, expected->px, S, options_.search_sigmas, options_.least_correlation);
  if (found) {
    sought.found_px = found->px;
  }
  return sought;
}

MonoSlamStep MonoSlam::step(const cv::Mat& grey, Time stamp,
                            const std::optional<MotionTold>& told) {
  PANOPTES_CHECK(
      grey.type() == CV_8U && grey.cols == lens_.width_px && grey.rows == lens_.height_px,
      "a picture is grey and of the lens's size");
  const Pose3 T_map_before = filter_.T_map_camera();
  const double dt_s = before_ ? to_seconds(stamp - *before_) : 0;
  if (before_ && told && !options_.motion_is_told) {
    filter_.predict_turned(dt_s, *told);
  } else if (before_) {
    filter_.predict(dt_s, told);
  }
  before_ = stamp;
  MonoSlamStep step;
  noise_grey_ = noise_of(grey);
  const bool has_map = !filter_.points().empty();
  std::vector<PointMatch> matches;
  for (const int number : filter_.points()) {
    const std::optional<PointSought> sought = seek(grey, number);
    if (sought && sought->found_px) {
      matches.push_back({number, *sought->found_px, match_sigma_px_});
    }
    if (sought) {
      step.sought.push_back(*sought);
    }
  }
  const FilterUpdate update = take_in(matches);
  believe(update, step);
  filter_.convert();
  if (start_ && has_map) {
    start_->add(dt_s, matches, {filter_.T_map_camera(), inliers(matches, update)});
    mind_the_start(step);
  }
  const bool is_held = step.dof / 2 >= kFewestFound;
  was_held_ = was_held_ || is_held;
  const bool was_blind = std::exchange(is_blind_, was_held_ && !is_held);
  if (is_blind_ && !was_blind) {
    from_before_ = filter_.points().empty() ? 0 : filter_.points().back() + 1;
  }
  step.lost =
      is_blind_ && (lost_pictures_ > 0 || !told || !options_.motion_is_told || !is_led(grey, step));
  lost_pictures_ = step.lost ? lost_pictures_ + 1 : 0;
  if (start_ && (agreeing_ < kLeastAgreeing || lost_pictures_ >= kLooksAgain)) {
    begin_anew(step);
  }
  turned_rad_ += turn_between(T_map_before, filter_.T_map_camera());
  int back_again = 0;
  for (const PointSought& sought : step.sought) {
    MappedPoint& point = points_.at(sought.point);
    if (!is_blind_ && !start_ && sought.point >= from_before_) {
      ++point.sought;
      point.found += sought.inlier ? 1 : 0;
    }
    if (sought.inlier && !step.lost) {
      Vec3& turned_then = tracked_.at(sought.point).turned_rad;
      back_again += (turned_rad_ - turned_then).norm() > std::numbers::pi ? 1 : 0;
      turned_then = turned_rad_;
    }
  }
  step.closes = back_again > 0;
  if (!start_ && step.dof / 2 >= kFewestLearnt) {
    const double ratio = std::min(kMostOff, step.squared_sigmas / step.dof);
    match_sigma_px_ = std::clamp(match_sigma_px_ * std::sqrt(1 + kLearns * (ratio - 1)),
                                 kLeastSigma_px, kMostSigma_px);
  }
  step.match_sigma_px = match_sigma_px_;
  if (!step.lost) {
    if (!start_) {
      forget_the_bad();
    }
    const bool is_first = filter_.points().empty();
    grow(grey, step);
    if (is_first && !options_.motion_is_told) {
      filter_.fix_metre();
    }
    if (start_) {
      start_->see(step.added);
    }
  } else if (lost_pictures_ % kLooksAgain == 0) {
    find_again(grey);
  }
  ++pictures_;
  step.T_map_camera = filter_.T_map_camera();
  return step;
}

void MonoSlam::begin_anew(MonoSlamStep& step) {
  filter_ = MonoFilter(options_.filter, lens_);
  points_.clear();
  tracked_.clear();
  turned_rad_.setZero();
  agreeing_ = 1;
  was_held_ = false;
  is_blind_ = false;
  from_before_ = 0;
  start_is_known_ = false;
  lost_pictures_ = 0;
  start_.emplace(options_.filter, lens_, options_.match_sigma_px);
  std::fill(try_cell_from_.begin(), try_cell_from_.end(), 0);
  step = {};
  step.begins_anew = true;
}

// Until depths are known.
void MonoSlam::mind_the_start(MonoSlamStep& step) {
  const auto agreeing = [&] {
    int found = 0;
    int agree = 0;
    for (const PointSought& sought : step.sought) {
      found += sought.found_px ? 1 : 0;
      agree += sought.inlier ? 1 : 0;
    }
    return found < kFewestLearnt
               ? agreeing_
               : agreeing_ + kForgets * (static_cast<double>(agree) / found - agreeing_);
  };
  bool is_over = start_->pictures() >= kLongestStart;
  if (start_->is_due() || is_over || agreeing() < kLeastAgreeing) {
    if (std::optional<MonoStart::Again> again = start_->again()) {
      filter_ = std::move(again->filter);
      for (const auto& [number, T] : again->T_map_first) {
        tracked_.at(number).T_map_first = T;
      }
      believe(again->latest, step);
      start_is_known_ = again->is_determined;
      is_over = is_over || again->is_determined;
      step.retold.assign(again->pictures.begin(), again->pictures.end() - 1);
    }
  }
  agreeing_ = agreeing();
  if (is_over) {
    start_.reset();
  }
}

// A few matches that agree by chance do not bring back a camera that nothing holds. Nor do they
// turn it once it is held again by what it has mapped since, which turns with it: each point from
// before could be anywhere that it is sought.
FilterUpdate MonoSlam::take_in(const std::vector<PointMatch>& matches) {
  FilterUpdate all;
  all.inlier.assign(matches.size(), false);
  for (const bool before : {false, true}) {
    std::vector<std::size_t> which;
    std::vector<PointMatch> some;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if ((matches[i].point < from_before_) == before) {
        which.push_back(i);
        some.push_back(matches[i]);
      }
    }
    const FilterUpdate update = filter_.update(some, is_blind_ || before ? kFewestFound : 1);
    for (std::size_t i = 0; i < which.size(); ++i) {
      all.inlier[which[i]] = update.inlier[i];
    }
    all.squared_sigmas += update.squared_sigmas;
    all.dof += update.dof;
    if (before && update.dof / 2 >= kFewestFound) {
      from_before_ = 0;
    }
  }
  return all;
}

// By the motion that is told: nothing that it sees says otherwise.
bool MonoSlam::is_led(const cv::Mat& grey, const MonoSlamStep& step) const {
  const auto from_before =
      std::count_if(step.sought.begin(), step.sought.end(),
                    [this](const PointSought& sought) { return sought.point < from_before_; });
  return (from_before < kFewestFound || !shows_something(grey)) && would_be_sought();
}

bool MonoSlam::shows_something(const cv::Mat& grey) const {
  const std::vector<SalientFeature> features =
      salient_features(options_.features, grey, usable(grey));
  return std::any_of(features.begin(), features.end(), [&](const SalientFeature& feature) {
    return tracked_at(grey, feature).has_value();
  });
}

// Points that come into the picture, as far away as those of the map are, by what is known of the
// camera's pose.
bool MonoSlam::would_be_sought() const {
  const Pose3& T_map_camera = filter_.T_map_camera();
  double inverse_m = 0;
  for (const int number : filter_.points()) {
    const Vec3 p_map = filter_.point(number).p_map();
    if (p_map.allFinite()) {
      inverse_m += 1 / (p_map - T_map_camera.translation).norm();
    }
  }
  if (inverse_m <= 0) {
    return false;
  }
  const Vec3 ahead(0, 0, static_cast<double>(filter_.points().size()) / inverse_m);
  Eigen::Matrix<double, 3, 6> by_camera;
  by_camera << -T_map_camera.rotation.conjugate().toRotationMatrix(), cross_matrix(ahead);
  const Eigen::Matrix<double, 2, 6> px_by_camera =
      project_with_jacobian(filter_.lens(), ahead).px_by_point * by_camera;
  const Mat2 S = px_by_camera * filter_.pose_covariance() * px_by_camera.transpose();
  return options_.search_sigmas * std::sqrt(S.diagonal().maxCoeff()) <= kFarthest_px;
}

// By the looks of its points, wherever it is; the next picture shows whether that holds.
void MonoSlam::find_again(const cv::Mat& grey) {
  std::vector<KnownPoint> known;
  double depth_m = 0;
  for (const auto& [number, point] : points_) {
    const Vec3 p_map = filter_.point(number).p_map();
    const double far_m = (p_map - tracked_.at(number).T_map_first.translation).norm();
    if (p_map.allFinite() &&
        std::sqrt(filter_.point_covariance(number).trace()) < kKnownRatio * far_m) {
      known.push_back({p_map, point.descriptor});
    }
  }
  const std::optional<Pose3> T_map_camera =
      camera_by_points(options_.features, filter_.lens(), grey, known);
  if (!T_map_camera) {
    return;
  }
  for (const KnownPoint& point : known) {
    depth_m += (point.p_map - T_map_camera->translation).norm() / static_cast<double>(known.size());
  }
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << Vec3::Constant(kFoundAgain_rad * depth_m), Vec3::Constant(kFoundAgain_rad);
  turned_rad_ += turn_between(filter_.T_map_camera(), *T_map_camera);
  filter_.place(*T_map_camera, sigma.cwiseAbs2().asDiagonal());
}

void MonoSlam::forget_the_bad() {
  std::vector<int> bad;
  for (const auto& [number, point] : points_) {
    const FilteredPoint& held = filter_.point(number);
    if ((point.sought >= kFewestSought && 2 * point.found < point.sought) ||
        (held.is_inverse_depth() && held.state[5] < -options_.filter.inverse_depth_sigma)) {
      bad.push_back(number);
    }
  }
  for (const int number : bad) {
    filter_.remove(number);
    points_.erase(number);
    tracked_.erase(number);
  }
}

void MonoSlam::grow(const cv::Mat& grey, MonoSlamStep& step) {
  std::vector<Vec2> held;
  std::vector<bool> is_full(try_cell_from_.size(), false);
  for (const int number : filter_.points()) {
    if (const std::optional<PointExpected> expected = filter_.expected(number)) {
      held.push_back(expected->px);
      const int column = static_cast<int>(expected->px.x() * options_.columns / lens_.width_px);
      const int row = static_cast<int>(expected->px.y() * options_.rows / lens_.height_px);
      if (column >= 0 && row >= 0 && column < options_.columns && row < options_.rows) {
        is_full[static_cast<std::size_t>(row * options_.columns + column)] = true;
      }
    }
  }
  // The cell that has waited longest; all of them where nothing is known yet.
  std::vector<std::size_t> cells;
  for (std::size_t i = 0; i < is_full.size(); ++i) {
    if (!is_full[i] && try_cell_from_[i] <= pictures_) {
      cells.push_back(i);
    }
  }
  std::stable_sort(cells.begin(), cells.end(), [this](std::size_t a, std::size_t b) {
    return try_cell_from_[a] < try_cell_from_[b];
  });
  const std::size_t most = held.empty() ? cells.size() : 1;
  for (std::size_t i = 0; i < std::min(most, cells.size()); ++i) {
    const std::size_t cell = cells[i];
    const int column = static_cast<int>(cell) % options_.columns;
    const int row = static_cast<int>(cell) / options_.columns;
    const int x0 = column * grey.cols / options_.columns;
    const int y0 = row * grey.rows / options_.rows;
    const cv::Rect area =
        usable(grey) & cv::Rect(x0, y0, (column + 1) * grey.cols / options_.columns - x0,
                                (row + 1) * grey.rows / options_.rows - y0);
    try_cell_from_[cell] = pictures_ + kCellRests;
    for (const SalientFeature& feature : salient_features(options_.features, grey, area)) {
      const bool is_apart = std::all_of(held.begin(), held.end(), [&feature](const Vec2& px) {
        return (px - feature.px).norm() >= Patch::kSide_px;
      });
      if (is_apart && add(grey, feature, step)) {
        held.push_back(feature.px);
        break;
      }
    }
  }
}

// Empty for one whose place or direction is not told well enough.
std::optional<MonoSlam::Tracked> MonoSlam::tracked_at(const cv::Mat& grey,
                                                      const SalientFeature& feature) const {
  const Vec2 pixel(std::round(feature.px.x()), std::round(feature.px.y()));
  const cv::Rect around(static_cast<int>(pixel.x()) - Patch::kSourceHalf_px,
                        static_cast<int>(pixel.y()) - Patch::kSourceHalf_px,
                        2 * Patch::kSourceHalf_px + 1, 2 * Patch::kSourceHalf_px + 1);
  Tracked tracked;
  tracked.source = grey(around).clone();
  tracked.offset_px = feature.px - pixel;
  const std::optional<Patch> patch =
      Patch::seen(tracked.source, tracked.offset_px, Mat2::Identity());
  const std::optional<Vec3> direction = filter_.lens().direction(feature.px);
  if (!patch || patch->place_sigma_px(noise_grey_) > options_.place_sigma_px || !direction) {
    return std::nullopt;
  }
  const auto by_px = direction_by_px(filter_.lens(), *direction);
  if (!by_px) {
    return std::nullopt;
  }
  tracked.T_map_first = filter_.T_map_camera();
  tracked.direction_by_px = *by_px;
  tracked.turned_rad = turned_rad_;
  return tracked;
}

bool MonoSlam::add(const cv::Mat& grey, const SalientFeature& feature, MonoSlamStep& step) {
  std::optional<Tracked> tracked = tracked_at(grey, feature);
  cv::Mat descriptor = tracked ? describe(options_.features, grey, feature) : cv::Mat();
  if (descriptor.empty()) {
    return false;
  }
  const int number = filter_.add(feature.px, match_sigma_px_);
  tracked_[number] = std::move(*tracked);
  points_[number] = {feature, std::move(descriptor), 0, 0};
  step.added.push_back({number, feature.px, match_sigma_px_});
  return true;
}

}  // namespace panoptes
