// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/planned_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/rng.h"
#include "core/base/text.h"
#include "core/calib/joint_of_rig.h"
#include "core/calib/rig_views.h"

namespace panoptes {
namespace {

constexpr double kClear_m = 1;    // from where a robot drives to a wall, at least,
constexpr double kUnder_m = 0.5;  // and from its cameras to the ceiling
constexpr double kNearest_m = 0.2;
constexpr int kTries = 20;

/// The room that the points are in, in start.
struct AssumedRoom {
  Vec3 least;
  Vec3 most;

  /// How far it is to walls, floor or ceiling from a place inside.
  double way_m(const Vec3& from, const Vec3& direction) const {
    double way = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
      if (direction[i] != 0) {
        way = std::min(way, ((direction[i] > 0 ? most : least)[i] - from[i]) / direction[i]);
      }
    }
    return way;
  }
  bool on_wall(const Vec3& p) const {
    constexpr double kThin_m = 1e-6;
    return p.z() > least.z() + kThin_m && p.z() < most.z() - kThin_m;
  }
};

class Plan {
 public:
  Plan(const PlanOptions& options, const std::vector<std::pair<std::string, RigCamera>>& cameras,
       const DrivePath& path)
      : options_(options), path_(path) {
    for (const auto& [name, camera] : cameras) {
      out_.cameras.push_back(name);
      rig_.push_back(camera);
    }
    if (options.known_together) {
      options_.bundle.before = covariance_before(out_.cameras, rig_, options.known_together);
    }
  }

  RigCalibration run() {
    choose();
    make_room();
    Rng places = rng_.fork("places");
    for (std::size_t v = 0; v < out_.tracks.views.size(); ++v) {
      look(v, places);
    }
    see();
    RigBundleState truth;
    const Pose2 first = *path_.at(out_.tracks.instants.front());
    for (const Time instant : out_.tracks.instants) {
      truth.T_start_body.push_back(on_floor(first.inverse() * *path_.at(instant)));
    }
    for (const RigCamera& camera : rig_) {
      truth.T_body_camera.push_back(camera.T_body_camera);
      truth.lenses.push_back(camera.intrinsics);
      truth.clock_offset_s.push_back(camera.clock_offset_s);
    }
    truth.points_start = seen_points_;
    out_.bundle = expect_rig(
        options_.bundle, rig_, [this](Time at) { return path_.odometry(at); }, out_.tracks, truth,
        options_.noise);
    out_.shared = shared_points(out_.tracks, out_.map_of_point, rig_.size());
    out_.wheels_known = options_.bundle.wheels;
    return std::move(out_);
  }

 private:
  void choose() {
    std::vector<TakenPicture> taken;
    for (std::size_t c = 0; c < rig_.size(); ++c) {
      const double end_s = to_seconds(path_.end());
      for (std::size_t frame = 0; static_cast<double>(frame) / rig_[c].rate_hz <= end_s; ++frame) {
        taken.push_back({time_at(static_cast<double>(frame) / rig_[c].rate_hz), c, frame});
      }
    }
    std::stable_sort(taken.begin(), taken.end(),
                     [](const auto& a, const auto& b) { return a.instant < b.instant; });
    const ChosenViews chosen = choose_views(
        taken, rig_.size(), [this](Time at) { return path_.odometry(at); }, kSameInstant);
    out_.tracks.instants = chosen.instants;
    const Pose2 first = *path_.at(chosen.instants.front());
    for (const auto& [camera, instant, frame] : chosen.views) {
      const Time at = chosen.instants[instant];
      out_.tracks.views.push_back(
          {camera, instant, at + from_seconds(rig_[camera].clock_offset_s)});
      T_start_camera_.push_back(on_floor(first.inverse() * *path_.at(at)) *
                                rig_[camera].T_body_camera);
    }
  }

  void make_room() {
    const Vec3 half(options_.room_m.x() / 2, options_.room_m.y() / 2, 0);
    room_ = {-half, half + Vec3(0, 0, options_.room_m.z())};
    for (const Pose3& T : T_start_camera_) {
      room_.least = room_.least.cwiseMin(T.translation - Vec3(kClear_m, kClear_m, 0));
      room_.most = room_.most.cwiseMax(T.translation + Vec3(kClear_m, kClear_m, kUnder_m));
    }
  }

  /// A camera maps what it sees, until enough of its own points are in view.
  void look(std::size_t v, Rng& rng) {
    const std::size_t c = out_.tracks.views[v].camera;
    const Intrinsics& lens = rig_[c].intrinsics;
    const Pose3& T_start_camera = T_start_camera_[v];
    const Pose3 T_camera_start = T_start_camera.inverse();
    auto in_view = std::count_if(points_.begin(), points_.end(), [&](const Mapped& point) {
      return point.camera == c && lens.sees(T_camera_start * point.p_start);
    });
    for (int i = 0; i < kTries * options_.points_in_view && in_view < options_.points_in_view;
         ++i) {
      const double u_px = rng.uniform(0, lens.width_px - 1.0);
      const double v_px = rng.uniform(0, lens.height_px - 1.0);
      const double share = rng.uniform(options_.nearest_share, 1);
      const std::optional<Vec3> direction = lens.direction(Vec2(u_px, v_px));
      if (!direction) {
        continue;
      }
      const Vec3 along = T_start_camera.rotation * *direction;
      const double way_m = room_.way_m(T_start_camera.translation, along);
      const bool before_wall = room_.on_wall(T_start_camera.translation + way_m * along);
      const Vec3 p = T_start_camera.translation + (before_wall ? share : 1) * way_m * along;
      if ((p - T_start_camera.translation).norm() > kNearest_m) {
        points_.push_back({p, c});
        ++in_view;
      }
    }
  }

  /// Where the points are found. What a camera saw of its own once tells nothing.
  void see() {
    Rng found = rng_.fork("found");
    for (const Mapped& point : points_) {
      std::vector<RigSeen> seen = sightings(rig_, out_.tracks.views, T_start_camera_, point.p_start,
                                            seen_points_.size(), point.camera);
      std::erase_if(seen, [&](const RigSeen& each) {
        return found.uniform() >= (each.own ? options_.own_found : options_.other_found);
      });
      if (std::count_if(seen.begin(), seen.end(), [](const auto& each) { return each.own; }) >= 2) {
        out_.tracks.seen.insert(out_.tracks.seen.end(), seen.begin(), seen.end());
        out_.map_of_point.push_back(static_cast<int>(point.camera));
        seen_points_.push_back(point.p_start);
      }
    }
  }

  struct Mapped {
    Vec3 p_start;
    std::size_t camera = 0;
  };

  PlanOptions options_;
  const DrivePath& path_;
  const Rng rng_{1};
  std::vector<RigCamera> rig_;
  std::vector<Pose3> T_start_camera_;  // by view
  AssumedRoom room_;
  std::vector<Mapped> points_;
  std::vector<Vec3> seen_points_;
  RigCalibration out_;
};

}  // namespace

RigCalibration plan_calibration(const PlanOptions& options,
                                const std::vector<std::pair<std::string, RigCamera>>& cameras,
                                const DrivePath& path) {
  PANOPTES_CHECK(!cameras.empty(), "a plan is of cameras");
  return Plan(options, cameras, path).run();
}

std::vector<std::string> plan_advice(const RigCalibration& plan) {
  std::vector<std::string> advice;
  std::map<std::string, std::vector<std::string>> open;  // the cameras that each is open of
  std::vector<std::string> heights;
  std::vector<std::string> alone;
  for (std::size_t c = 0; c < plan.cameras.size(); ++c) {
    for (const std::string& what : plan.bundle.known.unobservable[c]) {
      (what == "its height" ? heights : open[what]).push_back(plan.cameras[c]);
    }
    if (plan.cameras.size() > 1 && plan.shared[c] < kFewestShared) {
      alone.push_back(plan.cameras[c]);
    }
  }
  std::vector<std::string> words;
  for (const auto& [what, cameras] : open) {
    words.push_back(fmt::format("{} ({})", what, joined(cameras)));
  }
  if (!plan.bundle.tells_metre) {
    advice.emplace_back(
        "a turn on the spot shows no metre, and lengths stay as the rig file has them: drive a "
        "motion with legs, or a rose");
  } else if (!words.empty()) {
    advice.push_back(
        fmt::format("this motion leaves open {}: drive straight legs and turns on the spot by more "
                    "than a whole turn, or a rose",
                    joined(words)));
  }
  if (!alone.empty()) {
    advice.push_back(fmt::format(
        "fewer than {} points in common with other cameras: {}; heights against the others stay as "
        "believed: turn by more than a whole turn, so that each sees what others have seen",
        kFewestShared, joined(alone)));
  }
  if (!heights.empty()) {
    advice.emplace_back(
        "no drive over a level floor shows the height of all cameras together: measure it");
  }
  return advice;
}

}  // namespace panoptes
