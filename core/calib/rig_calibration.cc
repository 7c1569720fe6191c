// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_calibration.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/base/median.h"
#include "core/calib/joint_of_rig.h"
#include "core/calib/patch.h"
#include "core/calib/patch_warp.h"
#include "core/calib/path_as_wheels.h"
#include "core/calib/rig_views.h"
#include "core/calib/turn_by_directions.h"
#include "core/camera/lens_parameters.h"
#include "core/geometry/cross_matrix.h"

namespace panoptes {
namespace {

constexpr double kNearest_m = 0.2;
constexpr std::size_t kEvery = 3;  // frames: the wheels tell of longer ways better
constexpr double kSearchSigmas = 3;
// What kSameInstant is as long as clocks are hardly known.
constexpr Duration kRoughly = std::chrono::milliseconds(40);
// To see heights, one view of so many will do.
constexpr std::size_t kFirstSearched = 3;
// By fewer of others' points a camera that has no map of its own is not to be found.
constexpr std::size_t kFewestToFind = 20;
// Of fewer pictures no map was ever made, whatever they showed.
constexpr std::size_t kFewestPictures = 20;

/// Why a camera's own map is of no use; empty where it is.
std::string map_fault(const MappedCamera& camera) {
  const AdjustedMap& adjusted = camera.adjusted;
  if (adjusted.T_map_camera.empty() && camera.map.frames.size() < kFewestPictures) {
    return fmt::format(
        "{} pictures are too few to map by: record the whole drive, with several "
        "pictures a second",
        camera.map.frames.size());
  }
  const std::string why =
      "what it sees is too plain, it is covered, its pictures come too rarely to follow what they "
      "show, or its lens is another one than the rig file says";
  if (adjusted.T_map_camera.empty()) {
    return fmt::format("its own map holds {} points, and no keyframes that keep together: {}",
                       camera.map.points.size(), why);
  }
  if (adjusted.left_out > adjusted.observations) {
    return fmt::format(
        "the keyframes of its own map contradict one another, {} of {} observations "
        "are left out: {}",
        adjusted.left_out, adjusted.left_out + adjusted.observations, why);
  }
  return "";
}

/// How a point looked where it was first seen.
struct PointSource {
  std::size_t camera = 0;
  Pose3 T_start_camera;
  Vec2 px = Vec2::Zero();
  Vec2 offset_px = Vec2::Zero();
  cv::Mat grey;  ///< empty where it was seen too near to the picture's edge
};

/// Where a camera was at a frame: by the nearest of its keyframes, which are adjusted.
Pose3 adjusted_at(const MappedCamera& camera, std::size_t frame) {
  const std::vector<int>& keyframes = camera.adjusted.keyframes;
  const auto after = std::lower_bound(keyframes.begin(), keyframes.end(), static_cast<int>(frame));
  auto nearest = after == keyframes.end() ? std::prev(after) : after;
  if (nearest != keyframes.begin() && static_cast<int>(frame) - *std::prev(nearest) <
                                          std::abs(*nearest - static_cast<int>(frame))) {
    --nearest;
  }
  const auto k = static_cast<std::size_t>(nearest - keyframes.begin());
  const Pose3& as_mapped = camera.map.frames[static_cast<std::size_t>(*nearest)].T_map_camera;
  return camera.adjusted.T_map_camera[k] *
         (as_mapped.inverse() * camera.map.frames[frame].T_map_camera);
}

/// Of every so manieth frame.
std::vector<StampedCamera> path_of(const MappedCamera& camera, std::size_t every) {
  std::vector<StampedCamera> path;
  for (std::size_t frame = 0; frame < camera.map.frames.size(); frame += every) {
    if (!camera.map.frames[frame].lost) {
      path.push_back({camera.map.frames[frame].stamp, adjusted_at(camera, frame)});
    }
  }
  return path;
}

/// How far a path leads from its first place, in its map's metres.
double farthest(const std::vector<StampedCamera>& path) {
  double far = 0;
  for (const StampedCamera& at : path) {
    far =
        std::max(far, (at.T_map_camera.translation - path.front().T_map_camera.translation).norm());
  }
  return far;
}

/// That what a camera sees is too far for its way to show, in words; empty where it is not.
std::string too_distant(const MappedCamera& camera) {
  // In rooms it is 24 to 84 px; between walls 330 m off 1 to 2, which is noise.
  constexpr double kLeastParallax_px = 5;
  std::vector<double> parallax_px;
  for (const MonoMap::Point& point : camera.map.points) {
    const auto from = [&](const MonoMap::Seen& seen) {
      const MonoMap::Frame& frame = camera.map.frames[static_cast<std::size_t>(seen.frame)];
      return Vec3(point.p_map - frame.T_map_camera.translation).normalized();
    };
    Vec3 mean = Vec3::Zero();
    for (const MonoMap::Seen& seen : point.seen) {
      mean += from(seen);
    }
    double most_rad = 0;
    for (const MonoMap::Seen& seen : point.seen) {
      most_rad =
          std::max(most_rad, std::atan2(from(seen).cross(mean).norm(), from(seen).dot(mean)));
    }
    parallax_px.push_back(most_rad * camera.believed.intrinsics.fx_px);
  }
  const double usual_px = parallax_px.empty() ? 0 : median(parallax_px);
  return usual_px > kLeastParallax_px
             ? ""
             : fmt::format(
                   ", and where the camera goes moves what it sees by {:.1f} px (at least {:.0f}): "
                   "all is too distant for anything but turns; drive the motion nearer to what "
                   "there is to see, or farther",
                   usual_px, kLeastParallax_px);
}

/// A camera's path stands for wheels where none were read. A metre is such that cameras are as far
/// from one another as they are believed to be, on the mean.
WheelReadings wheels_by_path(const std::vector<MappedCamera>& cameras) {
  const auto by = std::find_if(cameras.begin(), cameras.end(),
                               [](const MappedCamera& c) { return map_fault(c).empty(); });
  if (by == cameras.end()) {
    throw HandEyeError(cameras.front().name + ": " + map_fault(cameras.front()));
  }
  const std::vector<StampedCamera> path = path_of(*by, 1);
  const Vec2 place_body = by->believed.T_body_camera.translation.head<2>();
  // First as if it had gone as far as robots do for this: what is believed of mountings then
  // counts for as little as it should.
  constexpr double kUsual_m = 0.6;
  double metre_m = kUsual_m / farthest(path);
  for (int round = 0; round < 2; ++round) {
    const WheelReadings wheels = path_as_wheels(path, by->believed, metre_m);
    double found = 0;
    double as_believed = 0;
    for (const MappedCamera& camera : cameras) {
      if (camera.name == by->name || !map_fault(camera).empty()) {
        continue;
      }
      try {
        const Vec2 apart = planar_hand_eye(path_of(camera, kEvery), wheels, camera.believed)
                               .T_body_camera.translation.head<2>() -
                           place_body;
        found += apart.squaredNorm();
        as_believed += apart.dot(camera.believed.T_body_camera.translation.head<2>() - place_body);
      } catch (const HandEyeError&) {  // told of when all wheels are known
      }
    }
    constexpr double kLeast_m = 0.001;
    if (as_believed > kLeast_m * kLeast_m) {
      metre_m *= as_believed / found;
    }
  }
  return path_as_wheels(path, by->believed, metre_m);
}

class Calibration {
 public:
  Calibration(const RigCalibrationOptions& options, const std::vector<MappedCamera>& cameras,
              const WheelReadings& wheels, const FramePicture& picture)
      : options_(options), cameras_(cameras), wheels_(wheels), picture_(picture) {
    for (const MappedCamera& camera : cameras) {
      believed_.push_back(camera.believed);
      out_.cameras.push_back(camera.name);
    }
    if (options.known_together) {
      out_.known_together = options.known_together;
      options_.bundle.before = covariance_before(out_.cameras, believed_, options.known_together);
    }
  }

  RigCalibration run(const std::function<void(double)>& progress) {
    begin_each();
    // Clocks first: pictures of one instant are known by them.
    choose_views(kRoughly);
    begin();
    adjust([&] { progress(0); });
    progress(0.05);
    choose_views(kSameInstant);
    begin();
    out_.before = state_;
    adjust([&] { progress(0.05); });
    progress(0.15);
    cut_sources([&](double done) { progress(0.15 + 0.2 * done); });
    search(Search::kFirst, [&](double done) { progress(0.35 + 0.2 * done); });
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      if (is_by_others(c)) {
        is_lost_[c] = !turn_by_others(c);
      }
    }
    adjust([&] { progress(0.55); });
    progress(0.65);
    search(Search::kAdjusted, [&](double done) { progress(0.65 + 0.25 * done); });
    adjust([&] { progress(0.9); });
    out_.shared = shared_points(out_.tracks, out_.map_of_point, cameras_.size());
    out_.wheels_known = options_.bundle.wheels;
    out_.wheels = wheels_;
    progress(1);
    return std::move(out_);
  }

 private:
  using Progress = std::function<void(double)>;
  enum class Search { kFirst, kAdjusted };

  /// What each camera knows by itself. Throws where none of them knows anything.
  void begin_each() {
    std::optional<HandEyeError> first;
    for (const MappedCamera& camera : cameras_) {
      out_.hand_eye.emplace_back();
      out_.by_others.emplace_back();
      is_lost_.push_back(false);
      clock_offset_s_.push_back(camera.believed.clock_offset_s);
      if (const std::string why = map_fault(camera); !why.empty()) {
        out_.by_others.back() = why;
        continue;
      }
      try {
        out_.hand_eye.back() = planar_hand_eye(path_of(camera, kEvery), wheels_, camera.believed);
        clock_offset_s_.back() = out_.hand_eye.back()->clock_offset_s;
      } catch (const PathsDisagree& error) {
        out_.by_others.back() = error.what() + too_distant(camera);
      } catch (const HandEyeError& error) {
        out_.by_others.back() = error.what();
      }
      if (is_by_others(out_.hand_eye.size() - 1)) {
        first = first.value_or(HandEyeError(camera.name + ": " + out_.by_others.back()));
      }
    }
    if (std::none_of(out_.hand_eye.begin(), out_.hand_eye.end(),
                     [](const auto& known) { return known.has_value(); })) {
      throw first.value_or(HandEyeError(cameras_.front().name + ": " + out_.by_others.front()));
    }
  }

  bool is_by_others(std::size_t c) const { return !out_.hand_eye[c]; }

  void adjust(const std::function<void()>& each_step) {
    RigBundleOptions how = options_.bundle;
    how.each_step = each_step;
    out_.bundle = adjust_rig(how, believed_, wheels_, out_.tracks, state_);
    state_ = out_.bundle.state;
    clock_offset_s_ = state_.clock_offset_s;
  }

  std::vector<TakenPicture> all_pictures() const {
    std::vector<TakenPicture> taken;
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      const auto& frames = cameras_[c].map.frames;
      const Duration offset = from_seconds(clock_offset_s_[c]);
      for (std::size_t frame = 0; frame < frames.size(); ++frame) {
        const bool is_held = !frames[frame].lost || is_by_others(c);
        if (is_held && wheels_(frames[frame].stamp - offset)) {
          taken.push_back({frames[frame].stamp - offset, c, frame});
        }
      }
    }
    std::stable_sort(taken.begin(), taken.end(),
                     [](const auto& a, const auto& b) { return a.instant < b.instant; });
    return taken;
  }

  void choose_views(Duration same) {
    const ChosenViews chosen =
        panoptes::choose_views(all_pictures(), cameras_.size(), wheels_, same);
    out_.tracks.instants = chosen.instants;
    out_.tracks.views.clear();
    frame_of_view_.clear();
    for (const auto& [camera, instant, frame] : chosen.views) {
      out_.tracks.views.push_back({camera, instant, cameras_[camera].map.frames[frame].stamp});
      frame_of_view_.push_back(frame);
    }
  }

  /// What each camera knows by itself, laid on what those before it know.
  void begin() {
    state_ = {};
    out_.tracks.seen.clear();
    out_.map_of_point.clear();
    first_seen_.clear();
    state_.T_start_body.resize(out_.tracks.instants.size());
    is_placed_.assign(out_.tracks.instants.size(), false);
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      const MappedCamera& camera = cameras_[c];
      state_.clock_offset_s.push_back(clock_offset_s_[c]);
      if (is_by_others(c)) {
        state_.T_body_camera.push_back(camera.believed.T_body_camera);
        state_.lenses.push_back(camera.believed.intrinsics);
        continue;
      }
      const PlanarHandEye& by_itself = *out_.hand_eye[c];
      state_.T_body_camera.push_back(by_itself.T_body_camera);
      state_.lenses.push_back(camera.adjusted.lens);
      const Pose3 T_start_map = own_start_in_start(c) * by_itself.T_start_map;
      place_instants(c, T_start_map);
      add_points(c, T_start_map);
    }
    place_others();
    // Start is the body at the first instant.
    const Pose3 T_first_start = state_.T_start_body.front().inverse();
    for (Pose3& T : state_.T_start_body) {
      T = T_first_start * T;
    }
    for (Vec3& p : state_.points_start) {
      p = T_first_start * p;
    }
  }

  void place_instants(std::size_t c, const Pose3& T_start_map) {
    for (std::size_t v = 0; v < out_.tracks.views.size(); ++v) {
      const RigView& view = out_.tracks.views[v];
      if (view.camera == c && !is_placed_[view.instant]) {
        const PlanarHandEye& by_itself = *out_.hand_eye[c];
        const Pose3 T_start_camera =
            in_start(by_itself, T_start_map, adjusted_at(cameras_[c], frame_of_view_[v]));
        state_.T_start_body[view.instant] = T_start_camera * by_itself.T_body_camera.inverse();
        is_placed_[view.instant] = true;
      }
    }
  }

  /// Instants of which no camera knows by itself, by those that are placed.
  void place_others() {
    std::vector<Pose3> T_start_body = state_.T_start_body;
    for (std::size_t i = 0; i < T_start_body.size(); ++i) {
      if (!is_placed_[i]) {
        T_start_body[i] = body_at(out_.tracks.instants[i]);
      }
    }
    state_.T_start_body = std::move(T_start_body);
    is_placed_.assign(is_placed_.size(), true);
  }

  /// A camera's own start is the body at its first picture: where that is, by the picture that is
  /// nearest in time to an instant that is placed. Of the first camera it is the start.
  Pose3 own_start_in_start(std::size_t c) const {
    const PlanarHandEye& by_itself = *out_.hand_eye[c];
    std::optional<Time> best;
    Duration nearest = Duration::max();
    Pose3 T_own_body;
    for (const StampedCamera& at : path_of(cameras_[c], kEvery)) {
      const Time instant = at.stamp - from_seconds(clock_offset_s_[c]);
      const std::optional<std::size_t> k = placed_near(instant);
      if (k && wheels_(instant) && std::chrono::abs(out_.tracks.instants[*k] - instant) < nearest) {
        best = instant;
        nearest = std::chrono::abs(out_.tracks.instants[*k] - instant);
        T_own_body = in_start(by_itself, by_itself.T_start_map, at.T_map_camera) *
                     by_itself.T_body_camera.inverse();
      }
    }
    return best ? body_at(*best) * T_own_body.inverse() : Pose3();
  }

  static Pose3 in_start(const PlanarHandEye& by, const Pose3& T_start_map,
                        const Pose3& T_map_camera) {
    return T_start_map * Pose3{T_map_camera.rotation, by.map_metre_m * T_map_camera.translation};
  }

  std::optional<std::size_t> placed_near(Time instant) const {
    const auto& instants = out_.tracks.instants;
    std::optional<std::size_t> nearest;
    for (std::size_t i = 0; i < instants.size(); ++i) {
      if (is_placed_[i] && (!nearest || std::chrono::abs(instants[i] - instant) <
                                            std::chrono::abs(instants[*nearest] - instant))) {
        nearest = i;
      }
    }
    return nearest;
  }

  /// By the nearest instant and what the wheels say since.
  Pose3 body_at(Time instant) const {
    const std::size_t k = *placed_near(instant);
    const std::optional<Odometry> then = wheels_(out_.tracks.instants[k]);
    const std::optional<Odometry> now = wheels_(instant);
    return then && now
               ? state_.T_start_body[k] * on_floor(then->T_odom_body.inverse() * now->T_odom_body)
               : state_.T_start_body[k];
  }

  void add_points(std::size_t c, const Pose3& T_start_map) {
    const MappedCamera& camera = cameras_[c];
    const PlanarHandEye& by_itself = *out_.hand_eye[c];
    std::vector<std::optional<std::size_t>> view_of_frame(camera.map.frames.size());
    for (std::size_t v = 0; v < out_.tracks.views.size(); ++v) {
      if (out_.tracks.views[v].camera == c) {
        view_of_frame[frame_of_view_[v]] = v;
      }
    }
    std::size_t next = 0;
    for (const MonoMap::Point& point : camera.map.points) {
      while (next < camera.adjusted.points.size() &&
             camera.adjusted.points[next].number < point.number) {
        ++next;
      }
      if (next == camera.adjusted.points.size() ||
          camera.adjusted.points[next].number != point.number) {
        continue;
      }
      std::vector<RigSeen> seen;
      for (const MonoMap::Seen& each : point.seen) {
        if (const auto view = view_of_frame[static_cast<std::size_t>(each.frame)]) {
          seen.push_back({*view, state_.points_start.size(), each.px, true, true});
        }
      }
      if (seen.size() < 2) {
        continue;
      }
      out_.tracks.seen.insert(out_.tracks.seen.end(), seen.begin(), seen.end());
      state_.points_start.push_back(
          T_start_map * Vec3(by_itself.map_metre_m * camera.adjusted.points[next].p_map));
      out_.map_of_point.push_back(static_cast<int>(c));
      first_seen_.push_back(point.seen.front());
    }
  }

  void cut_sources(const Progress& progress) {
    std::vector<std::size_t> order(first_seen_.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      order[i] = i;
    }
    const auto of = [this](std::size_t i) {
      return std::pair(out_.map_of_point[i], first_seen_[i].frame);
    };
    std::stable_sort(order.begin(), order.end(),
                     [&of](std::size_t a, std::size_t b) { return of(a) < of(b); });
    sources_.resize(order.size());
    cv::Mat grey;
    for (std::size_t n = 0; n < order.size(); ++n) {
      const std::size_t i = order[n];
      const auto c = static_cast<std::size_t>(out_.map_of_point[i]);
      const auto frame = static_cast<std::size_t>(first_seen_[i].frame);
      if (n == 0 || of(order[n - 1]) != of(i)) {
        grey = picture_(c, frame);
        progress(static_cast<double>(n) / static_cast<double>(order.size()));
      }
      PointSource& source = sources_[i];
      source.camera = c;
      source.px = first_seen_[i].px;
      source.T_start_camera =
          body_at(cameras_[c].map.frames[frame].stamp - from_seconds(state_.clock_offset_s[c])) *
          state_.T_body_camera[c];
      const Vec2 pixel(std::round(source.px.x()), std::round(source.px.y()));
      source.offset_px = source.px - pixel;
      const cv::Rect around(static_cast<int>(pixel.x()) - Patch::kSourceHalf_px,
                            static_cast<int>(pixel.y()) - Patch::kSourceHalf_px,
                            2 * Patch::kSourceHalf_px + 1, 2 * Patch::kSourceHalf_px + 1);
      if ((around & cv::Rect(0, 0, grey.cols, grey.rows)) == around) {
        source.grey = grey(around).clone();
      }
    }
  }

  /// Every camera's points in the other cameras' views.
  void search(Search how, const Progress& progress) {
    std::erase_if(out_.tracks.seen, [](const RigSeen& seen) { return !seen.own; });
    const std::size_t every = how == Search::kFirst ? kFirstSearched : 1;
    for (std::size_t v = 0; v < out_.tracks.views.size(); v += every) {
      if (!is_lost_[out_.tracks.views[v].camera]) {
        search_view(v, how);
      }
      progress(static_cast<double>(v + 1) / static_cast<double>(out_.tracks.views.size()));
    }
  }

  void search_view(std::size_t v, Search how) {
    const RigView& view = out_.tracks.views[v];
    const double sigma_px = how == Search::kFirst ? options_.first_search_px : options_.search_px;
    const Intrinsics& lens = state_.lenses[view.camera];
    const cv::Mat grey = picture_(view.camera, frame_of_view_[v]);
    const Pose3 T_start_camera = body_of_view(view) * state_.T_body_camera[view.camera];
    const Pose3 T_camera_start = T_start_camera.inverse();
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const PointSource& source = sources_[i];
      if (source.camera == view.camera || source.grey.empty()) {
        continue;
      }
      const Vec3& p_start = state_.points_start[i];
      PointFromBoth both;
      both.p_now = T_camera_start * p_start;
      if (both.p_now.norm() < kNearest_m || !lens.sees(both.p_now)) {
        continue;
      }
      const Projection drawn = project_with_jacobian(lens, both.p_now);
      const double border = Patch::kHalf_px + 1;
      if (drawn.px.x() < border || drawn.px.y() < border ||
          drawn.px.x() > lens.width_px - 1 - border || drawn.px.y() > lens.height_px - 1 - border) {
        continue;
      }
      both.from_first = p_start - source.T_start_camera.translation;
      both.from_now = p_start - T_start_camera.translation;
      both.R_now_first =
          (T_camera_start.rotation * source.T_start_camera.rotation).toRotationMatrix();
      const auto by_px = first_direction(source);
      const std::optional<Mat2> warp = by_px ? source_by_px(both, lens, *by_px) : std::nullopt;
      const std::optional<Patch> patch =
          warp ? Patch::seen(source.grey, source.offset_px, *warp) : std::nullopt;
      if (!patch) {
        continue;
      }
      Mat2 covariance = sigma_px * sigma_px * Mat2::Identity();
      if (how == Search::kFirst) {
        const Vec2 by_height =
            options_.height_sigma_m * drawn.px_by_point * (T_camera_start.rotation * Vec3::UnitZ());
        covariance += by_height * by_height.transpose();
        if (is_by_others(view.camera)) {
          covariance += as_mounted_px2(view, both.p_now, drawn.px_by_point);
        }
      }
      const std::optional<Patch::Found> found =
          patch->find(grey, drawn.px, covariance, kSearchSigmas, options_.least_correlation);
      if (found) {
        out_.tracks.seen.push_back({v, i, found->px, false, true});
      }
    }
  }

  /// How far a point may be drawn off, as long as a mounting is known by the rig file alone.
  Mat2 as_mounted_px2(const RigView& view, const Vec3& p_camera,
                      const Eigen::Matrix<double, 2, 3>& px_by_p) const {
    const CameraSigmas& known = believed_[view.camera].sigma;
    const std::optional<Odometry> odometry = wheels_(out_.tracks.instants[view.instant]);
    Vec3 turn_rad = known.rotation_rad;
    if (odometry) {
      turn_rad.z() = std::hypot(turn_rad.z(), odometry->twist_body.w_radps * known.clock_s);
    }
    const Mat3 R_body_camera = state_.T_body_camera[view.camera].rotation.toRotationMatrix();
    const Eigen::Matrix<double, 2, 3> by_shift = px_by_p * R_body_camera.transpose();
    const Eigen::Matrix<double, 2, 3> by_turn = by_shift * cross_matrix(R_body_camera * p_camera);
    return by_turn * turn_rad.cwiseAbs2().asDiagonal() * by_turn.transpose() +
           by_shift * known.position_m.cwiseAbs2().asDiagonal() * by_shift.transpose();
  }

  /// Turns a camera that has no map of its own to where the points of others that were found in its
  /// pictures agree; those that do not are forgotten. False where too few agree.
  bool turn_by_others(std::size_t c) {
    const Intrinsics& lens = state_.lenses[c];
    const double shift_m = believed_[c].sigma.position_m.maxCoeff();
    std::vector<std::size_t> of;  // where a pair is among what is seen
    std::vector<DirectionPair> pairs;
    for (std::size_t i = 0; i < out_.tracks.seen.size(); ++i) {
      const RigSeen& seen = out_.tracks.seen[i];
      const RigView& view = out_.tracks.views[seen.view];
      const std::optional<Vec3> direction =
          view.camera == c ? lens.direction(seen.px) : std::nullopt;
      if (direction) {
        const Vec3 p_body = body_of_view(view).inverse() * state_.points_start[seen.point] -
                            state_.T_body_camera[c].translation;
        of.push_back(i);
        pairs.push_back({direction->normalized(), p_body.normalized(),
                         kSearchSigmas * std::hypot(options_.first_search_px / lens.fx_px,
                                                    shift_m / p_body.norm())});
      }
    }
    const std::optional<TurnByDirections> turn =
        turn_by_directions(pairs, kFewestToFind, Rng(c).fork("turn by others"));
    std::vector<bool> is_kept(out_.tracks.seen.size(), true);
    for (const std::size_t i : of) {
      is_kept[i] = false;
    }
    if (turn) {
      state_.T_body_camera[c].rotation = turn->R_a_b.conjugate();
      for (const std::size_t k : turn->agree) {
        is_kept[of[k]] = true;
      }
    }
    std::vector<RigSeen> kept;
    for (std::size_t i = 0; i < is_kept.size(); ++i) {
      if (is_kept[i]) {
        kept.push_back(out_.tracks.seen[i]);
      }
    }
    out_.tracks.seen = std::move(kept);
    return turn.has_value();
  }

  Pose3 body_of_view(const RigView& view) const {
    const Time instant = out_.tracks.instants[view.instant];
    const std::optional<Odometry> then = wheels_(instant);
    const std::optional<Odometry> taken =
        wheels_(view.stamp - from_seconds(state_.clock_offset_s[view.camera]));
    const Pose3& T = state_.T_start_body[view.instant];
    return then && taken ? T * on_floor(then->T_odom_body.inverse() * taken->T_odom_body) : T;
  }

  std::optional<Eigen::Matrix<double, 3, 2>> first_direction(const PointSource& source) const {
    const Intrinsics& lens = state_.lenses[source.camera];
    const std::optional<Vec3> direction = lens.direction(source.px);
    return direction ? direction_by_px(lens, *direction) : std::nullopt;
  }

  RigCalibrationOptions options_;
  const std::vector<MappedCamera>& cameras_;
  WheelReadings wheels_;
  const FramePicture& picture_;
  std::vector<RigCamera> believed_;
  std::vector<double> clock_offset_s_;  // as it is known by now, by camera
  std::vector<bool> is_lost_;           // by camera: not even others' points tell where it is
  std::vector<bool> is_placed_;         // by instant
  std::vector<std::size_t> frame_of_view_;
  std::vector<MonoMap::Seen> first_seen_;  // by point
  std::vector<PointSource> sources_;       // by point
  RigBundleState state_;
  RigCalibration out_;
};

}  // namespace

Rig calibrated(const Rig& believed, const RigCalibration& calibration) {
  Rig rig = believed;
  const RigBundleState& state = calibration.bundle.state;
  const RigCovariance& known = calibration.bundle.known;
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    RigCamera& camera = rig.cameras.at(calibration.cameras[c]);
    const Eigen::Index at = known.camera[c];
    const Eigen::VectorXd sigma = known.covariance.diagonal().cwiseMax(0).cwiseSqrt();
    camera.T_body_camera = state.T_body_camera[c];
    camera.sigma.rotation_rad = sigma.segment<3>(at);
    camera.sigma.position_m = sigma.segment<3>(at + 3);
    const Intrinsics& lens = state.lenses[c];
    if (lens_fault(lens).empty()) {
      camera.intrinsics = lens;
      camera.sigma.focal_ratio = std::max(sigma[at + 6] / lens.fx_px, sigma[at + 7] / lens.fy_px);
      camera.sigma.centre_px = std::max(sigma[at + 8], sigma[at + 9]);
    }
    camera.clock_offset_s = state.clock_offset_s[c];
    camera.sigma.clock_s = sigma[at + 6 + lens_parameters(lens).size()];
  }
  return rig;
}

RigCalibration calibrate_rig(const RigCalibrationOptions& options,
                             const std::vector<MappedCamera>& cameras, const WheelReadings& wheels,
                             const FramePicture& picture,
                             const std::function<void(double)>& progress) {
  if (wheels) {
    return Calibration(options, cameras, wheels, picture).run(progress);
  }
  RigCalibrationOptions without = options;
  without.bundle.has_wheels = false;
  return Calibration(without, cameras, wheels_by_path(cameras), picture).run(progress);
}

}  // namespace panoptes
