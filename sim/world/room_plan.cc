// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/room_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/config/data_files.h"

namespace panoptes::sim {
namespace {

constexpr double kFloorDepth_m = 0.1;
constexpr double kHangingGap_m = 0.03;
constexpr double kSkirtingHeight_m = 0.08;
constexpr double kSkirtingDepth_m = 0.015;
const Hanging kWindow{"office/window", {1.64, 1.44}};
const Hanging kDoor{"office/door", {1.02, 2.12}};
constexpr double kWindowMiddle_m = 1.64;
constexpr double kWindowDepth_m = 0.004;  // the pane before its wall
constexpr double kLampDepth_m = 0.025;

std::string data_file(const std::string& name, const char* ending) {
  return resolve_path("data:" + name + ending, "");
}

std::string stem_of(const std::string& name) {
  std::string stem = name.substr(name.rfind('/') + 1);
  std::replace(stem.begin(), stem.end(), '_', '-');
  return stem;
}

}  // namespace

double wall_repeat_m(const std::string& picture) {
  return picture.starts_with("home/") ? kPaper_m : kRoomHeight_m;
}

ObjectSettings& put(WorldSettings& into, const std::string& mesh, const Pose2& at, double z_m,
                    const std::map<std::string, std::string>& textures) {
  ObjectSettings object;
  object.name = fmt::format("{}-{:03}", stem_of(mesh), into.objects.size() + 1);
  object.mesh = data_file(mesh, ".gltf");
  object.at = at;
  object.z_m = z_m;
  for (const auto& [material, picture] : textures) {
    object.textures[material] = data_file(picture, ".png");
  }
  into.objects.push_back(std::move(object));
  return into.objects.back();
}

BoxSettings& put_box(WorldSettings& into, const std::string& kind, const Vec3& size_m,
                     const Pose2& at, double z_m, const std::string& picture,
                     const Vec2& picture_m) {
  BoxSettings box;
  box.name = fmt::format("{}-{:03}", kind, into.boxes.size() + 1);
  box.size_m = size_m;
  box.at = at;
  box.z_m = z_m;
  box.picture = data_file(picture, ".png");
  box.picture_m = picture_m;
  into.boxes.push_back(std::move(box));
  return into.boxes.back();
}

namespace {

/// A flat box of which one face is seen.
void put_slab(WorldSettings& into, const std::string& kind, const Vec2& low, const Vec2& high,
              double z_m, const std::string& seen_face, const std::string& picture, double tile_m) {
  const Vec2 middle = (low + high) / 2;
  BoxSettings& slab =
      put_box(into, kind, Vec3(high.x() - low.x(), high.y() - low.y(), kFloorDepth_m),
              {middle.x(), middle.y(), 0}, z_m, picture, Vec2(tile_m, tile_m));
  for (const char* face : {"front", "back", "left", "right", "top", "bottom"}) {
    if (face != seen_face) {
      slab.faces[face] = "";
    }
  }
}

}  // namespace

void put_floor(WorldSettings& into, const Vec2& low, const Vec2& high, const std::string& picture,
               double tile_m) {
  put_slab(into, "floor", low, high, -kFloorDepth_m, "top", picture, tile_m);
}

void put_ceiling(WorldSettings& into, const Vec2& low, const Vec2& high, const std::string& picture,
                 double tile_m, double height_m) {
  put_slab(into, "ceiling", low, high, height_m, "bottom", picture, tile_m);
}

void put_both_halves(WorldSettings& into, const WorldSettings& half, const Vec2& size_m) {
  const auto turned = [&size_m](const Pose2& at) -> Pose2 {
    return {size_m.x() - at.x_m, size_m.y() - at.y_m, wrap_angle(at.theta_rad + std::numbers::pi)};
  };
  for (const bool is_turned : {false, true}) {
    const auto in_place = [&](const Pose2& at) { return is_turned ? turned(at) : at; };
    const char* const suffix = is_turned ? "-east" : "-west";
    for (ObjectSettings object : half.objects) {
      object.name += suffix;
      object.at = in_place(object.at);
      into.objects.push_back(std::move(object));
    }
    for (BoxSettings box : half.boxes) {
      box.name += suffix;
      box.at = in_place(box.at);
      into.boxes.push_back(std::move(box));
    }
    for (AreaLight light : half.lights) {
      const Pose2 at = in_place({light.at_m.x(), light.at_m.y(), 0});
      light.at_m.head<2>() = at.position();
      if (is_turned) {
        light.normal.head<2>() *= -1;
      }
      into.lights.push_back(light);
    }
  }
}

void put_lamp(WorldSettings& into, const Pose2& at, double power, double ceiling_m) {
  put(into, "office/lamp", at, ceiling_m);
  AreaLight light;
  light.at_m = Vec3(at.x_m, at.y_m, ceiling_m - kLampDepth_m);
  const bool is_turned = std::abs(std::sin(at.theta_rad)) > std::numbers::sqrt2 / 2;
  light.size_m = is_turned ? Vec2(0.6, 1.2) : Vec2(1.2, 0.6);
  light.power = power;
  light.group = "lamps";
  into.lights.push_back(light);
}

void put_lamps(WorldSettings& into, const Vec2& low, const Vec2& high, double pitch_m, double power,
               double ceiling_m) {
  const Vec2 size = high - low;
  const auto count = [pitch_m](double length_m) {
    return std::max(1, static_cast<int>(std::lround(length_m / pitch_m)));
  };
  for (int j = 0; j < count(size.y()); ++j) {
    for (int i = 0; i < count(size.x()); ++i) {
      put_lamp(into,
               {low.x() + (i + 0.5) * size.x() / count(size.x()),
                low.y() + (j + 0.5) * size.y() / count(size.y()), 0},
               power, ceiling_m);
    }
  }
}

void put_wall(WorldSettings& into, const WallSettings& wall) {
  const Vec2 along = (wall.to - wall.from).normalized();
  const double length_m = (wall.to - wall.from).norm();
  const double heading_rad = std::atan2(along.y(), along.x());
  const auto piece = [&](double from_m, double to_m, double z_m) {
    if (to_m - from_m <= 0 || wall.height_m - z_m <= 0) {
      return;
    }
    const Vec2 middle = wall.from + along * (from_m + to_m) / 2;
    BoxSettings& box = put_box(
        into, "wall", Vec3(to_m - from_m, wall.thickness_m, wall.height_m - z_m),
        {middle.x(), middle.y(), heading_rad}, z_m, wall.left, Vec2(wall.height_m, wall.height_m));
    box.faces["right"] = data_file(wall.right, ".png");
    box.faces["top"] = "";
    if (z_m == 0) {
      box.faces["bottom"] = "";
    }
  };
  double reached_m = 0;
  for (const Opening& opening : wall.openings) {
    PANOPTES_CHECK(opening.from_m >= reached_m && opening.to_m <= length_m,
                   "openings lie in their wall, in order");
    piece(reached_m, opening.from_m, 0);
    piece(opening.from_m, opening.to_m, opening.height_m);
    reached_m = opening.to_m;
  }
  piece(reached_m, length_m, 0);
}

bool Rectangle::overlaps(const Rectangle& other) const {
  return (low.array() < other.high.array()).all() && (other.low.array() < high.array()).all();
}

bool Rectangle::contains(const Rectangle& other) const {
  return (low.array() <= other.low.array()).all() && (other.high.array() <= high.array()).all();
}

Rectangle Rectangle::grown(double by_m) const {
  return {low - Vec2(by_m, by_m), high + Vec2(by_m, by_m)};
}

WallFace::WallFace(const Vec2& left, const Vec2& right, double height_m)
    : left_(left),
      along_((right - left).normalized()),
      length_m_((right - left).norm()),
      height_m_(height_m) {}

Pose2 WallFace::at(double s_m) const {
  const Vec2 p = left_ + along_ * s_m;
  return {p.x(), p.y(), std::atan2(-along_.x(), along_.y())};
}

double WallFace::along(const Vec2& p_scene) const { return along_.dot(p_scene - left_); }

bool WallFace::is_clear(const Rectangle& what) const {
  return Rectangle{{0, 0}, {length_m_, height_m_}}.contains(what) &&
         std::none_of(taken_.begin(), taken_.end(),
                      [&what](const Rectangle& there) { return there.overlaps(what); });
}

void WallFace::take(const Rectangle& what) { taken_.push_back(what); }

bool hang(WorldSettings& into, WallFace& face, const Hanging& what, double s_m, double z_m,
          const std::map<std::string, std::string>& textures) {
  const Vec2 middle(s_m, z_m);
  const Rectangle room{middle - what.size_m / 2, middle + what.size_m / 2};
  if (!face.is_clear(room.grown(kHangingGap_m))) {
    return false;
  }
  face.take(room);
  put(into, what.mesh, face.at(s_m), z_m, textures);
  return true;
}

bool put_window(WorldSettings& into, WallFace& face, double s_m, double power,
                const std::string& view) {
  if (!hang(into, face, kWindow, s_m, kWindowMiddle_m, {{"view", view}})) {
    return false;
  }
  const Pose2 at = face.at(s_m);
  const Vec2 middle = at * Vec2(kWindowDepth_m, 0);
  AreaLight light;
  light.at_m = Vec3(middle.x(), middle.y(), kWindowMiddle_m);
  light.size_m = kWindow.size_m;
  light.normal = Vec3(std::cos(at.theta_rad), std::sin(at.theta_rad), 0);
  light.power = power;
  light.group = "daylight";
  into.lights.push_back(light);
  return true;
}

bool put_door(WorldSettings& into, WallFace& face, double s_m, const std::string& leaf) {
  const Rectangle room{{s_m - kDoor.size_m.x() / 2, 0},
                       {s_m + kDoor.size_m.x() / 2, kDoor.size_m.y()}};
  if (!face.is_clear(room)) {
    return false;
  }
  face.take(room);
  put(into, kDoor.mesh, face.at(s_m), kDoor.size_m.y() / 2, {{"door", leaf}});
  return true;
}

void put_skirting(WorldSettings& into, const WallFace& face) {
  // Between the objects that reach the floor: tried in steps, for they are few and the wall is
  // long.
  constexpr double kStep_m = 0.05;
  const auto steps = static_cast<int>(std::floor(face.length_m() / kStep_m));
  int first = -1;
  for (int k = 0; k <= steps; ++k) {
    const bool clear =
        k < steps && face.is_clear({{k * kStep_m, 0}, {(k + 1) * kStep_m, kSkirtingHeight_m}});
    if (clear && first < 0) {
      first = k;
    }
    if (!clear && first >= 0) {
      const double length_m = (k - first) * kStep_m;
      const Pose2 on_face = face.at((first + k) * kStep_m / 2);
      const Vec2 middle = on_face * Vec2(kSkirtingDepth_m / 2, 0);
      BoxSettings& board =
          put_box(into, "skirting", Vec3(kSkirtingDepth_m, length_m, kSkirtingHeight_m),
                  {middle.x(), middle.y(), on_face.theta_rad}, 0, "office/skirting",
                  Vec2(1, kSkirtingHeight_m));
      board.faces["back"] = "";
      board.faces["bottom"] = "";
      first = -1;
    }
  }
}

namespace {

std::vector<Hanging> numbered(const char* mesh, int count, const Vec2& size_m) {
  std::vector<Hanging> all;
  for (int k = 1; k <= count; ++k) {
    all.push_back({fmt::format("office/{}_{:02}", mesh, k), size_m});
  }
  return all;
}

/// At one height of a wall: what may hang there, and how far apart things do, at least and at most.
struct Row {
  double low_m = 0;  ///< of the middles
  double high_m = 0;
  double nearest_m = 0;
  double farthest_m = 0;
  std::vector<Hanging> choice;
};

std::vector<Row> rows_of_a_wall() {
  std::vector<Hanging> eye_level = numbered("poster", 16, {0.70, 0.70});
  eye_level.push_back({"office/pinboard", {1.60, 1.10}});
  eye_level.push_back({"office/whiteboard", {2.20, 1.30}});
  for (const char* sign : {"fire_plan", "calendar", "notice", "rota", "certificate", "picture"}) {
    eye_level.push_back({std::string("office/sign_") + sign, {0.40, 0.40}});
  }
  std::vector<Hanging> high;
  for (const char* sign : {"clock", "exit", "no_smoking", "recycling", "first_aid", "arrow"}) {
    high.push_back({std::string("office/sign_") + sign, {0.40, 0.40}});
  }
  const std::vector<Hanging> banners = numbered("banner", 8, {0.80, 0.44});
  high.insert(high.end(), banners.begin(), banners.end());
  std::vector<Hanging> low = numbered("sheet", 16, {0.26, 0.34});
  low.push_back({"office/duct", {0.64, 0.16}});
  return {{1.45, 1.60, 0.15, 0.7, eye_level},
          {0.62, 0.74, 0.10, 0.5, low},
          {2.32, 2.38, 0.25, 1.0, high},
          {0.30, 0.30, 1.0, 2.2, {{"office/socket", {0.20, 0.10}}}},
          {1.09,
           1.09,
           1.5,
           4.0,
           {{"office/switch", {0.10, 0.10}}, {"office/thermostat", {0.12, 0.12}}}}};
}

}  // namespace

void dress(WorldSettings& into, WallFace& face, double share, Rng& rng) {
  for (const Row& row : rows_of_a_wall()) {
    double s_m = rng.uniform(0, row.farthest_m);
    while (s_m < face.length_m()) {
      const Hanging& what =
          row.choice[static_cast<std::size_t>(rng.index(static_cast<int>(row.choice.size())))];
      const double middle_m = s_m + what.size_m.x() / 2;
      const bool wanted = rng.uniform() < share;
      const bool hangs =
          wanted && hang(into, face, what, middle_m, rng.uniform(row.low_m, row.high_m));
      s_m += hangs || !wanted ? what.size_m.x() + rng.uniform(row.nearest_m, row.farthest_m) : 0.1;
    }
  }
}

FloorSpace::FloorSpace(const Vec2& low, const Vec2& high) : area_{low, high} {}

Rectangle FloorSpace::outline(const Pose2& at, const Vec2& size_m) {
  const double c = std::abs(std::cos(at.theta_rad));
  const double s = std::abs(std::sin(at.theta_rad));
  const Vec2 half(c * size_m.x() / 2 + s * size_m.y() / 2, s * size_m.x() / 2 + c * size_m.y() / 2);
  return {at.position() - half, at.position() + half};
}

bool FloorSpace::is_clear(const Rectangle& what, double clearance_m) const {
  const Rectangle wide = what.grown(clearance_m);
  return area_.contains(what) &&
         std::none_of(taken_.begin(), taken_.end(),
                      [&wide](const Rectangle& there) { return there.overlaps(wide); });
}

void FloorSpace::take(const Rectangle& what) { taken_.push_back(what); }

}  // namespace panoptes::sim
