// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/dynamic_objects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

// No point of a object moves farther than this between two looks at whether it meets the robot: a
// tenth of the radius of any body.
constexpr double kLook_m = 0.02;
constexpr int kMostLooks = 1000;
// Halvings of such a piece until the object touches, to less than a tenth of a micrometre.
constexpr int kHalvings = 18;

Pose2 in_plane(const Pose3& T) {
  const Vec3 ahead = T.rotation * Vec3::UnitX();
  return {T.translation.x(), T.translation.y(), std::atan2(ahead.y(), ahead.x())};
}

/// From a disc to a object at a place; negative where they overlap by the disc's radius.
double gap_m(const std::vector<Outline>& outlines, double radius_m, const Pose2& T_scene_base,
             const Disc& robot) {
  const Vec2 p_base = T_scene_base.inverse() * robot.at_scene;
  if (radius_m > 0) {
    return p_base.norm() - radius_m - robot.radius_m;
  }
  double gap = std::numeric_limits<double>::infinity();
  for (const Outline& outline : outlines) {
    gap = std::min(gap, nearest_on(outline, p_base).distance_m - robot.radius_m);
  }
  return gap;
}

/// Which share of a motion from 0 to 1 is free until the object touches the robot.
template <class GapAt>
double free_share(double longest_m, const GapAt& gap_at) {
  const double gap_now_m = gap_at(0.0);
  // What rests against the robot may go away from it.
  const auto meets = [&](double share) {
    const double gap = gap_at(share);
    return gap < 0 && gap < gap_now_m;
  };
  if (gap_now_m > longest_m) {
    return 1;
  }
  const int looks = std::clamp(static_cast<int>(std::ceil(longest_m / kLook_m)), 1, kMostLooks);
  for (int i = 1; i <= looks; ++i) {
    if (!meets(static_cast<double>(i) / looks)) {
      continue;
    }
    double free = static_cast<double>(i - 1) / looks;
    double met = static_cast<double>(i) / looks;
    for (int k = 0; k < kHalvings; ++k) {
      const double middle = (free + met) / 2;
      (meets(middle) ? met : free) = middle;
    }
    return free;
  }
  return 1;
}

double power_at(const std::vector<LightEvent>& events, Time at) {
  double power = 1;
  for (std::size_t i = 0; i < events.size() && events[i].at <= at; ++i) {
    const LightEvent& event = events[i];
    const Time until = i + 1 < events.size() ? std::min(at, events[i + 1].at) : at;
    const double share = event.over.count() > 0
                             ? std::min(1.0, to_seconds(until - event.at) / to_seconds(event.over))
                             : 1.0;
    power = share < 1 ? power + share * (event.power - power) : event.power;
  }
  return power;
}

}  // namespace

Pose2 between(const Pose2& T_a_from, const Pose2& T_a_to, double share) {
  return {
      T_a_from.x_m + share * (T_a_to.x_m - T_a_from.x_m),
      T_a_from.y_m + share * (T_a_to.y_m - T_a_from.y_m),
      wrap_angle(T_a_from.theta_rad + share * wrap_angle(T_a_to.theta_rad - T_a_from.theta_rad))};
}

DynamicObjects::DynamicObjects(const World& world, double z_low_m, double z_high_m) {
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const Object& object = world.objects[i];
    if (object.kind == Object::Kind::kFixed) {
      continue;
    }
    DynamicObject dynamic;
    dynamic.name = object.name;
    dynamic.world_index = i;
    dynamic.T_scene_object = object.T_scene_object;
    const Pose2 T_scene_base = in_plane(object.T_scene_object);
    dynamic.T_base_object = on_floor(T_scene_base).inverse() * object.T_scene_object;
    Pose2 place = T_scene_base;
    for (const Person& person : world.people) {
      if (person.object == i) {
        PANOPTES_CHECK(!person.path_scene.empty(), "a person's way has a first point");
        dynamic.radius_m = person.radius_m;
        dynamic.path_scene = person.path_scene;
        for (std::size_t k = 0; k + 1 < person.path_scene.size(); ++k) {
          dynamic.path_m += (person.path_scene[k + 1] - person.path_scene[k]).norm();
        }
        dynamic.speed_mps = person.speed_mps;
        dynamic.start = person.start;
        dynamic.returns = person.returns;
        dynamic.waits_m = person.waits_m;
        dynamic.turns_back_s = person.turns_back_s;
        place = place_on_path(dynamic, 0);
      }
    }
    if (dynamic.path_scene.empty()) {
      World alone;
      alone.objects = {object};
      alone.objects.front().T_scene_object = dynamic.T_base_object;
      dynamic.outlines = sim::outlines(alone, z_low_m, z_high_m);
      for (const Outline& outline : dynamic.outlines) {
        for (const Vec2& corner : outline.corners_scene) {
          dynamic.reach_m = std::max(dynamic.reach_m, corner.norm());
        }
      }
    }
    for (const MoveEvent& event : world.move_events) {
      if (event.object == i) {
        dynamic.moves.push_back({event.at, event.over, event.T_scene_object});
      }
    }
    objects_.push_back(std::move(dynamic));
    places_.push_back(place);
  }
  for (const LightEvent& event : world.light_events) {
    lights_[event.group].push_back(event);
  }
}

void DynamicObjects::step(Time from, Time to, const Disc& robot) {
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    objects_[i].held = false;
    if (objects_[i].path_scene.empty()) {
      move(i, from, to, robot);
    } else {
      walk(i, from, to, robot);
    }
  }
}

void DynamicObjects::move(std::size_t index, Time from, Time to, const Disc& robot) {
  DynamicObject& object = objects_[index];
  Pose2& place = places_[index];
  while (object.next_move < object.moves.size() && object.moves[object.next_move].at < to) {
    ++object.next_move;
    object.moving = true;
    object.from_scene = place;
    object.moved = 0;
  }
  if (!object.moving) {
    return;
  }
  const Move& last = object.moves[object.next_move - 1];
  const auto gap_at = [&](const Pose2& T_scene_base) {
    return gap_m(object.outlines, object.radius_m, T_scene_base, robot);
  };
  if (last.over.count() <= 0) {  // from one place to the other with nothing between
    if (gap_at(last.to_scene) >= 0) {
      place = last.to_scene;
      object.moving = false;
    }
    return;
  }
  const double before = object.moved;
  const double after =
      std::min(1.0, before + to_seconds(to - std::max(from, last.at)) / to_seconds(last.over));
  const Pose2 T_base_to = object.from_scene.inverse() * last.to_scene;
  const double longest_m = (after - before) * (T_base_to.position().norm() +
                                               std::abs(T_base_to.theta_rad) * object.reach_m);
  const double share = free_share(longest_m, [&](double s) {
    return gap_at(between(object.from_scene, last.to_scene, before + s * (after - before)));
  });
  object.held = share < 1;
  object.moved = share < 1 ? before + share * (after - before) : after;
  place =
      object.moved < 1 ? between(object.from_scene, last.to_scene, object.moved) : last.to_scene;
  object.moving = object.moved < 1;
}

Pose2 DynamicObjects::place_on_path(const DynamicObject& object, double walked_m) {
  const std::vector<Vec2>& path = object.path_scene;
  const double there_and_back_m = 2 * object.path_m;
  double along_m = walked_m;
  bool back = false;
  if (object.returns && there_and_back_m > 0) {
    along_m = std::fmod(walked_m, there_and_back_m);
    back = along_m > object.path_m;
    along_m = back ? there_and_back_m - along_m : along_m;
  }
  double theta_rad = 0;
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    const Vec2 leg = path[k + 1] - path[k];
    const double leg_m = leg.norm();
    if (leg_m == 0) {
      continue;
    }
    theta_rad = std::atan2(back ? -leg.y() : leg.y(), back ? -leg.x() : leg.x());
    if (along_m <= leg_m) {
      const Vec2 at = path[k] + leg * (along_m / leg_m);
      return {at.x(), at.y(), theta_rad};
    }
    along_m -= leg_m;
  }
  return {path.back().x(), path.back().y(), theta_rad};
}

void DynamicObjects::walk(std::size_t index, Time from, Time to, const Disc& robot) {
  DynamicObject& object = objects_[index];
  Pose2& place = places_[index];
  double step_m = object.speed_mps * std::max(0.0, to_seconds(to - std::max(from, object.start)));
  if (!object.returns) {
    step_m = std::min(step_m, object.path_m - object.walked_m);
  }
  if (step_m <= 0 || object.path_m == 0) {
    return;
  }
  // What the person would run into straight ahead is in the way.
  const Vec2 robot_ahead = place.inverse() * robot.at_scene;
  const double together_m = object.radius_m + robot.radius_m;
  if (robot_ahead.x() > 0 && std::abs(robot_ahead.y()) < together_m &&
      robot_ahead.norm() - together_m < object.waits_m) {
    object.waited_s += to_seconds(to - from);
    if (object.returns && object.waited_s >= object.turns_back_s) {
      object.waited_s = 0;
      object.walked_m = 2 * object.path_m - std::fmod(object.walked_m, 2 * object.path_m);
      place = place_on_path(object, object.walked_m);
    }
    return;
  }
  object.waited_s = 0;
  const double share = free_share(step_m, [&](double s) {
    return gap_m({}, object.radius_m, place_on_path(object, object.walked_m + s * step_m), robot);
  });
  object.held = share < 1;
  object.walked_m += share * step_m;
  place = place_on_path(object, object.walked_m);
}

Nearest DynamicObjects::nearest_on(std::size_t index, const Pose2& T_scene_base,
                                   const Vec2& p_scene) const {
  const DynamicObject& object = objects_[index];
  if (object.radius_m > 0) {
    const Vec2 offset = p_scene - T_scene_base.position();
    const double distance_m = offset.norm();
    if (distance_m <= object.radius_m) {
      return {nullptr, 0, p_scene};
    }
    return {nullptr, distance_m - object.radius_m,
            T_scene_base.position() + offset * (object.radius_m / distance_m)};
  }
  const Vec2 p_base = T_scene_base.inverse() * p_scene;
  Nearest best{nullptr, std::numeric_limits<double>::infinity(), p_scene};
  for (const Outline& outline : object.outlines) {
    const Nearest found = sim::nearest_on(outline, p_base);
    if (found.distance_m < best.distance_m) {
      best = {&outline, found.distance_m, T_scene_base * found.p_scene};
    }
  }
  return best;
}

std::vector<Outline> DynamicObjects::outlines_now() const {
  constexpr int kCorners = 24;
  std::vector<Outline> all;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const DynamicObject& object = objects_[i];
    if (object.radius_m > 0) {
      Outline around{object.name, {}};
      const double corner_m = object.radius_m / std::cos(std::numbers::pi / kCorners);
      for (int k = 0; k < kCorners; ++k) {
        const double angle_rad = 2 * std::numbers::pi * k / kCorners;
        around.corners_scene.push_back(places_[i].position() +
                                       corner_m * Vec2(std::cos(angle_rad), std::sin(angle_rad)));
      }
      all.push_back(std::move(around));
    }
    for (Outline outline : object.outlines) {
      for (Vec2& corner : outline.corners_scene) {
        corner = places_[i] * corner;
      }
      all.push_back(std::move(outline));
    }
  }
  return all;
}

SceneState DynamicObjects::scene_state(Time at, const std::vector<Pose2>& places) const {
  PANOPTES_CHECK(places.size() == objects_.size(), "every object has its place");
  SceneState scene_state;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const DynamicObject& object = objects_[i];
    if (object.path_scene.empty() && places[i] == in_plane(object.T_scene_object)) {
      continue;
    }
    scene_state.T_scene_object[object.world_index] = on_floor(places[i]) * object.T_base_object;
  }
  for (const auto& [group, events] : lights_) {
    const double power = power_at(events, at);
    if (power != 1) {
      scene_state.power[group] = power;
    }
  }
  return scene_state;
}

}  // namespace panoptes::sim
