// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "sim/physics/obstacles.h"
#include "sim/world/layers.h"
#include "sim/world/world.h"

namespace panoptes::sim {

/// The place between two others, evenly, turning the short way.
Pose2 between(const Pose2& T_a_from, const Pose2& T_a_to, double share);

/// The body of the robot, as dynamic objects meet it.
struct Disc {
  Vec2 at_scene = Vec2::Zero();
  double radius_m = 0;
};

/// What moves by itself: objects that events take elsewhere, people who walk, lights. It advances
/// with the steps of DriveWorld and draws nothing by chance. Whatever would run into the robot goes
/// as far as it touches it and stands there until the way is free: nothing here ever pushes the
/// robot. Objects pass through one another and through walls.
class DynamicObjects {
 public:
  DynamicObjects() = default;  ///< a world where nothing moves

  /// Bounds movable objects by their slice between the heights, people by their discs.
  DynamicObjects(const World& world, double z_low_m, double z_high_m);

  void step(Time from, Time to, const Disc& robot);

  std::size_t count() const { return objects_.size(); }
  const std::string& name(std::size_t index) const { return objects_[index].name; }
  double radius_m(std::size_t index) const { return objects_[index].radius_m; }
  /// In the base frame of the object; a person has none.
  const std::vector<Outline>& outlines(std::size_t index) const { return objects_[index].outlines; }
  bool stands_against_robot(std::size_t index) const { return objects_[index].held; }

  /// Where each is now, in the order of the world's objects.
  const std::vector<Pose2>& places() const { return places_; }

  /// The point of an object with its base frame there that is nearest to another point, and its
  /// distance.
  Nearest nearest_on(std::size_t index, const Pose2& T_scene_base, const Vec2& p_scene) const;

  /// All of them where they are now, people as polygons around their discs.
  std::vector<Outline> outlines_now() const;

  /// How the world looks at an instant, everything standing at `places`.
  SceneState scene_state(Time at, const std::vector<Pose2>& places) const;

 private:
  struct Move {
    Time at;
    Duration over{};
    Pose2 to_scene;
  };
  struct DynamicObject {
    std::string name;
    std::size_t world_index = 0;  // in World::objects
    Pose3 T_scene_object;         // at time 0
    Pose3 T_base_object;          // its height and tilt, which stay
    std::vector<Outline> outlines;
    double radius_m = 0;
    double reach_m = 0;  // of its farthest corner
    bool held = false;
    // one that events move
    std::vector<Move> moves;
    std::size_t next_move = 0;
    bool moving = false;  // by the last move
    Pose2 from_scene;
    double moved = 0;  // share of it
    // one who walks
    std::vector<Vec2> path_scene;
    double path_m = 0;
    double speed_mps = 0;
    Time start;
    bool returns = false;
    double waits_m = 0;
    double turns_back_s = 0;
    double waited_s = 0;  // for the robot to go
    double walked_m = 0;
  };

  void move(std::size_t index, Time from, Time to, const Disc& robot);
  void walk(std::size_t index, Time from, Time to, const Disc& robot);
  static Pose2 place_on_path(const DynamicObject& object, double walked_m);

  std::vector<DynamicObject> objects_;
  std::vector<Pose2> places_;
  std::map<std::string, std::vector<LightEvent>> lights_;  // by group, in order of time
};

}  // namespace panoptes::sim
