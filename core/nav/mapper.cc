// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/mapper.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/geometry/pose3.h"
#include "core/map/reached_floor.h"
#include "core/map/shadows.h"

namespace panoptes {
namespace {

// After a bump what stands at the bumper must not be learned as floor until the robot has backed
// off.
constexpr Duration kShyAfterBump = std::chrono::seconds(3);

// The sweep of the body between two steps is filled in by places so far apart.
constexpr double kSweep_m = 0.05;

// Narrower than this share of the body, floor that is seen through a passage may be no floor.
constexpr double kPassageShare = 0.4;

// Whether a camera of a keyframe was so near to a point of its frame that it may have seen it.
bool has_looked_near(const GridCrop& grid, const Vec2& p) {
  constexpr double kNear_m = 4;
  return std::any_of(grid.cameras.begin(), grid.cameras.end(),
                     [&](const CameraPlace& camera) { return (camera.foot - p).norm() < kNear_m; });
}

// The camera that sees most of the floor that a floor camera maps, from another height.
std::string second_camera(const Rig& rig, const std::string& floor_camera,
                          const FloorProjection& projection) {
  std::string best;
  std::size_t most = 0;
  for (const auto& [name, camera] : rig.cameras) {
    if (name == floor_camera) {
      continue;
    }
    const std::optional<SecondView> view = second_view(projection, camera);
    if (view && view->pairs.size() > most) {
      best = name;
      most = view->pairs.size();
    }
  }
  return best;
}

}  // namespace

std::vector<std::string> floor_cameras(const Rig& rig) {
  std::vector<std::pair<double, std::string>> found;
  for (const auto& [name, camera] : rig.cameras) {
    if (camera.has_role("floor")) {
      found.emplace_back(std::abs(floor_heading_rad(camera.T_body_camera)), name);
    }
  }
  if (found.empty()) {
    throw ConfigError("rig: no camera has the role floor; free space is mapped with one");
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> names;
  for (const auto& [heading_rad, name] : found) {
    names.push_back(name);
  }
  return names;
}

void bind(Fields& f, MapperOptions& o) {
  f("floor", o.floor);
  f("cell_m", o.cell_m, between(0.005, 0.05));
  f("local_cell_m", o.local_cell_m, between(0.005, 0.1));
  f("local_half_width_m", o.local_half_width_m, between(1, 20));
  f("local_keyframes", o.local_keyframes, at_least(1));
  f("plan_cell_m", o.plan_cell_m, between(0.01, 0.1));
  f("refuse_s", o.refuse_s, positive);
  f("start_margin_m", o.start_margin_m, between(0, 1));
  f("contour_path_m", o.contour_path_m, positive);
  f("contour_cell_m", o.contour_cell_m, between(0.005, 0.1));
  f("contour_keyframes", o.contour_keyframes, at_least(1));
  f.renamed("contour_way_m", "contour_path_m");
}

Mapper::Mapper(const MapperOptions& options, const Body& body, const Rig& rig)
    : options_(options),
      body_(body),
      open_(options.cell_m),
      local_(options.local_cell_m, options.local_half_width_m, options.local_keyframes),
      global_(options.plan_cell_m) {
  for (const std::string& name : floor_cameras(rig)) {
    const RigCamera& camera = rig.cameras.at(name);
    const std::string second = second_camera(rig, name, project_floor(camera, body));
    FloorMapper floor(options.floor, camera, body,
                      second.empty() ? nullptr : &rig.cameras.at(second));
    FloorFlow flow(floor.projection(), camera.intrinsics);
    floor_cameras_.push_back({name, second, std::move(floor), std::move(flow), {}, {}});
  }
}

double Mapper::start_radius_m() const { return projection().front_m + options_.start_margin_m; }

Mapped Mapper::step(const Observation& seen, const Located& located,
                    const std::vector<Keyframe>& keyframes,
                    const std::vector<Pose2>& T_map_keyframes) {
  Mapped out;
  if (keyframes.empty()) {
    return out;
  }
  if (located.keyframe_made == 0) {
    open_.add_free_disc(Vec2::Zero(), start_radius_m());
  } else if (located.keyframe_made) {
    close_keyframe(keyframes, T_map_keyframes);
    open_ = KeyframeGrid(options_.cell_m);
    open_keyframe_ = *located.keyframe_made;
  }
  if (located.relaxed) {
    global_.move(std::span(T_map_keyframes).first(closed_.size()));
  }
  if (global_.waiting() > 0) {
    const double share = to_seconds(seen.stamp - last_step_) / options_.refuse_s;
    global_.refuse(
        static_cast<int>(std::ceil(static_cast<double>(closed_.size()) * std::min(share, 1.0))));
  }
  last_step_ = seen.stamp;
  if (seen.health.bumper_pressed) {
    bumped_ = true;
    bumped_at_ = seen.stamp;
  } else if (bumped_ && seen.stamp - bumped_at_ > kShyAfterBump) {
    bumped_ = false;
  }
  for (std::size_t i = 0; i < floor_cameras_.size(); ++i) {
    const auto picture = seen.pictures.find(floor_cameras_[i].camera);
    if (picture == seen.pictures.end()) {
      continue;
    }
    const Pose2 T_now_then = T_body_then(seen, picture->second.stamp);
    const Pose2 T_odom_then = seen.odometry.T_odom_body * T_now_then;
    std::optional<FloorMapper::SecondPicture> second;
    if (const auto other = seen.pictures.find(floor_cameras_[i].second);
        other != seen.pictures.end()) {
      second = {other->second.bgr,
                seen.odometry.T_odom_body * T_body_then(seen, other->second.stamp)};
    }
    FloorReading reading = floor_cameras_[i].floor.read(picture->second.bgr, T_odom_then, !bumped_,
                                                        second ? &*second : nullptr);
    check_camera(i, picture->second.bgr, reading, T_odom_then, seen.odometry.twist_body);
    for (const UprightPoint& point : reading.upright_odom) {
      open_.add_standing(
          {located.T_last_body * (seen.odometry.T_odom_body.inverse() * point.p_odom),
           point.height_m});
    }
    for (const Vec2& p_odom : reading.painted_odom) {
      open_.add_proved_floor(located.T_last_body * (seen.odometry.T_odom_body.inverse() * p_odom));
    }
    if (reading.learned_new_floor) {
      forget_obstacles();  // this reading does not know the new floor yet
    } else if (reading.sees_floor || i == 0) {
      open_.add(reading, located.T_last_body * T_now_then, static_cast<int>(i));
    }
    if (reading.sees_floor && !reading.learned_new_floor && !known_.empty()) {
      floor_cameras_[i].newcomers.add(reading, located.T_odom_body * T_now_then,
                                      known_.front().local_odom, seen.stamp);
      std::vector<Vec2> left;
      for (const Vec2& p_odom : floor_cameras_[i].newcomers.left_odom()) {
        left.push_back(located.T_last_body * (located.T_odom_body.inverse() * p_odom));
        open_.add_proved_floor(left.back());
      }
      take_back(left, T_map_keyframes);
    }
    if (i == 0) {
      out.reading = std::move(reading);
    }
  }
  drive_over(located.T_last_body, seen.odometry.T_odom_body, seen.health.bumper_pressed);
  out.local_odom =
      local_.map(open_, keyframes[static_cast<std::size_t>(open_keyframe_)].T_odom_body,
                 located.T_odom_body.position());
  remember_known(out.local_odom, keyframes.front().T_odom_body, seen.stamp);
  for (const FloorCamera& camera : floor_cameras_) {
    camera.newcomers.occupy(out.local_odom);
  }
  return out;
}

bool Mapper::something_came() const {
  return std::any_of(floor_cameras_.begin(), floor_cameras_.end(),
                     [](const FloorCamera& camera) { return camera.newcomers.ever(); });
}

// What was known before somebody came, and was not seen wrongly from afar just now. The ring about
// the start is assumed to be floor: where a floor of another colour begins in it, nobody has come.
void Mapper::remember_known(const OccupancyMap& local_odom, const Pose2& T_odom_start, Time stamp) {
  constexpr double kBefore_s = 1.5;
  constexpr double kStep_s = 0.25;
  if (known_.empty() || to_seconds(stamp - known_.back().at) >= kStep_s) {
    known_.push_back({stamp, local_odom});
    if (open_keyframe_ <= options_.local_keyframes) {
      for_each_in_disc(known_.back().local_odom, T_odom_start.position(),
                       start_radius_m() + options_.local_cell_m,
                       [](Cell& cell) { cell = cell == Cell::kFree ? Cell::kUnknown : cell; });
    }
  }
  while (known_.size() > 1 && to_seconds(stamp - known_[1].at) >= kBefore_s) {
    known_.pop_front();
  }
}

GridCrop Mapper::open_crop() const {
  GridCrop crop = open_.crop();
  hide_behind(crop, crop.standing);
  panoptes::forget_obstacles_on(crop, crop.proved_floor);
  return crop;
}

// What was seen here before another floor was known may be that floor.
void Mapper::forget_obstacles() {
  open_.forget_obstacles();
  for (std::size_t k = first_of_late(); k < closed_.size(); ++k) {
    auto cleared = std::make_shared<GridCrop>(*closed_[k]);
    if (panoptes::forget_obstacles(*cleared)) {
      replace(k, std::move(cleared));
    }
  }
}

// Keyframes from this one on may be changed by what is seen later.
std::size_t Mapper::first_of_late() const {
  constexpr std::size_t kBefore = 40;
  return closed_.size() - std::min(closed_.size(), kBefore);
}

void Mapper::replace(std::size_t keyframe, std::shared_ptr<const GridCrop> grid) {
  local_.replace(closed_[keyframe], grid);
  global_.replace(static_cast<int>(keyframe), grid);
  closed_[keyframe] = std::move(grid);
}

// What has proved to be floor was an obstacle to earlier keyframes.
void Mapper::take_back(const std::vector<Vec2>& proved_floor_open,
                       const std::vector<Pose2>& T_map_keyframes) {
  const auto open = static_cast<std::size_t>(open_keyframe_);
  for (std::size_t k = first_of_late(); k < closed_.size() && !proved_floor_open.empty(); ++k) {
    const Pose2 T_k_open = T_map_keyframes[k].inverse() * T_map_keyframes[open];
    std::vector<Vec2> proved_floor;
    for (const Vec2& p : proved_floor_open) {
      if (has_looked_near(*closed_[k], T_k_open * p)) {
        proved_floor.push_back(T_k_open * p);
      }
    }
    auto changed = proved_floor.empty() ? nullptr : std::make_shared<GridCrop>(*closed_[k]);
    if (changed && forget_obstacles_on(*changed, proved_floor)) {
      replace(k, std::move(changed));
    }
  }
}

// Something that stands hides the floor behind it from earlier keyframes, too, from which it was
// not told from the floor yet.
void Mapper::close_keyframe(const std::vector<Keyframe>& keyframes,
                            const std::vector<Pose2>& T_map_keyframes) {
  const auto open = static_cast<std::size_t>(open_keyframe_);
  GridCrop crop = open_crop();
  for (std::size_t k = first_of_late(); k < closed_.size() && !crop.standing.empty(); ++k) {
    const Pose2 T_k_open = T_map_keyframes[k].inverse() * T_map_keyframes[open];
    std::vector<StandingPoint> standing;
    for (const StandingPoint& point : crop.standing) {
      const StandingPoint at_k{T_k_open * point.p, point.height_m};
      if (has_looked_near(*closed_[k], at_k.p)) {
        standing.push_back(at_k);
      }
    }
    if (standing.empty()) {
      continue;
    }
    auto hidden = std::make_shared<GridCrop>(*closed_[k]);
    if (hide_behind(*hidden, standing)) {
      replace(k, std::move(hidden));
    }
  }
  take_back(crop.proved_floor, T_map_keyframes);
  closed_.push_back(std::make_shared<const GridCrop>(std::move(crop)));
  global_.add(closed_.back(), T_map_keyframes[open]);
  local_.close(closed_.back(), keyframes[open].T_odom_body);
}

// Wheels that turn against what the body touches would look like another mounting.
void Mapper::check_camera(std::size_t camera, const cv::Mat& bgr, const FloorReading& reading,
                          const Pose2& T_odom_body, const Twist2& twist_body) {
  FloorCamera& checked = floor_cameras_[camera];
  if (bumped_ || !reading.sees_floor) {
    checked.flow.forget();
    return;
  }
  const std::optional<FloorEvidence> evidence =
      checked.flow.add(bgr, reading.evidence, T_odom_body, twist_body);
  const std::optional<FloorKnock> knock = evidence ? checked.check.add(*evidence) : std::nullopt;
  if (knock && rig_fault_.empty()) {
    rig_fault_ = fmt::format(
        "{} was knocked: the floor moves in its pictures as if it had been turned by about {:.1f} "
        "degrees and shifted by {:.0f} mm; put it back or survey its floor marks again, and start "
        "anew",
        checked.camera, rad_to_deg(knock->turned_rad.norm()), 1000 * knock->shifted_m.norm());
  }
}

// The body is there, and has come there straight. Farther than its own radius it may have come some
// other way; and wheels that turn against what it touches tell of no motion at all.
void Mapper::drive_over(const Pose2& T_keyframe_body, const Pose2& T_wheels_body, bool touches) {
  const Vec2 here = T_keyframe_body.position();
  if (touches) {
    open_.add_free_disc(here, body_.radius_m);
  } else {
    Vec2 motion = Vec2::Zero();
    if (T_wheels_last_) {
      motion = here - T_keyframe_body * (T_wheels_body.inverse() * *T_wheels_last_).position();
    }
    const int places = motion.norm() <= body_.radius_m
                           ? std::max(1, static_cast<int>(std::ceil(motion.norm() / kSweep_m)))
                           : 1;
    for (int k = places - 1; k >= 0; --k) {
      open_.add_body(here - motion * k / places, body_.radius_m);
    }
  }
  T_wheels_last_ = T_wheels_body;
}

std::vector<PlacedGrid> Mapper::placed(const std::vector<Pose2>& T_map_keyframes) const {
  std::vector<PlacedGrid> all;
  for (std::size_t k = 0; k < closed_.size(); ++k) {
    all.push_back({closed_[k], T_map_keyframes[k]});
  }
  if (!T_map_keyframes.empty()) {
    all.push_back({std::make_shared<const GridCrop>(open_crop()), T_map_keyframes.back()});
  }
  return all;
}

OccupancyMap Mapper::map(const std::vector<Pose2>& T_map_keyframes) {
  if (T_map_keyframes.empty()) {
    return {};
  }
  return global_.map_with({std::make_shared<const GridCrop>(open_crop()), T_map_keyframes.back()});
}

std::optional<std::vector<Vec2>> Mapper::standing(const std::vector<Pose2>& T_map_keyframes) const {
  if (!options_.floor.upright) {
    return std::nullopt;
  }
  std::vector<Vec2> places;
  for (std::size_t k = 0; k < closed_.size(); ++k) {
    for (const StandingPoint& point : closed_[k]->standing) {
      places.push_back(T_map_keyframes[k] * point.p);
    }
  }
  return places;
}

OccupancyMap Mapper::finished_map(double cell_m, const std::vector<Pose2>& T_map_keyframes) const {
  const std::vector<PlacedGrid> grids = placed(T_map_keyframes);
  std::vector<Vec2> way_map;
  for (const PlacedGrid& grid : grids) {
    for (const Vec2& p : grid.grid->traversed) {
      way_map.push_back(grid.T_map_keyframe * p);
    }
  }
  return reached_floor(fuse(without_shadows(grids), cell_m), way_map,
                       kPassageShare * 2 * body_.radius_m);
}

std::vector<Vec2> Mapper::contour(int keyframe, const std::vector<Pose2>& T_map_keyframes) const {
  const Pose2 T_keyframe_map = T_map_keyframes[static_cast<std::size_t>(keyframe)].inverse();
  std::vector<PlacedGrid> around;
  const auto take = [&](int from, int step) {
    double path_m = 0;
    const int end =
        std::min(static_cast<int>(closed_.size()), keyframe + options_.contour_keyframes + 1);
    for (int k = from; k >= std::max(0, keyframe - options_.contour_keyframes) && k < end;
         k += step) {
      const Pose2 T_keyframe_k = T_keyframe_map * T_map_keyframes[static_cast<std::size_t>(k)];
      if (k != keyframe) {
        const Pose2 T_before_k = T_map_keyframes[static_cast<std::size_t>(k - step)].inverse() *
                                 T_map_keyframes[static_cast<std::size_t>(k)];
        path_m += T_before_k.position().norm();
      }
      if (path_m > options_.contour_path_m) {
        return;
      }
      around.push_back({closed_[static_cast<std::size_t>(k)], T_keyframe_k});
    }
  };
  take(keyframe, -1);
  take(keyframe + 1, 1);
  return obstacle_contour(fuse(around, options_.contour_cell_m));
}

}  // namespace panoptes
