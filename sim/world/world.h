// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/geometry/pose3.h"

namespace panoptes::sim {

/// A corner of a triangle in its object's frame. Texture coordinates run right and down from the
/// picture's top left corner; the picture repeats outside of 0..1.
struct Corner {
  Vec3 p_object = Vec3::Zero();
  Vec2 uv = Vec2::Zero();
};

/// Counter-clockwise seen from its front; the back is not drawn.
struct Triangle {
  std::array<Corner, 3> corners;
  int texture = 0;  ///< in World::textures
};

/// What a surface looks like: the square root of the share of light it returns, as pictures have
/// it.
struct Texture {
  std::string name;
  cv::Mat bgr;
};

/// An upright convex pillar.
struct Pillar {
  std::vector<Vec2> corners_object;  ///< counter-clockwise, at least three
  double low_m = 0;                  ///< in its object's frame
  double high_m = 1;
};

/// A rigid object that stands in the world.
struct Object {
  enum class Kind {
    kFixed,    ///< stands where it is for ever; light and shadow are baked with it
    kMovable,  ///< a door, a chair: may be elsewhere later; throws no baked shadow
    kPerson    ///< the same, and no part of the true map
  };
  std::string name;
  Pose3 T_scene_object;  ///< at time 0
  std::vector<Triangle> triangles;
  Kind kind = Kind::kFixed;
  std::vector<Pillar> pillars{};  ///< what it fills, where its triangles do not show it (faces that
                                  ///< nobody sees are left out); empty: what they enclose
};

/// A shining rectangle. With power 1 it lights a surface that faces it from 1 m straight below its
/// middle with 1 (a white surface lit with 1 is drawn white). A surface of the world that lies in
/// the rectangle, its front the way the light shines, is seen shining.
struct AreaLight {
  Vec3 at_m = Vec3(0, 0, 2.5);
  Vec2 size_m = Vec2(0.6, 0.6);
  Vec3 normal = Vec3(0, 0, -1);
  double power = 1;
  std::string group;  ///< the switch it hangs on; empty: it shines for ever
};

/// Light from far away, with hard shadows. With power 1 it lights a surface square to it with 1.
struct Sun {
  Vec3 from = Vec3(0, 0, 1);  ///< direction to it in scene, of any length
  double power = 1;
  std::string group;
};

/// From `at` on the lights of a group go to `power` (1: as the world has them), evenly over `over`.
struct LightEvent {
  Time at;
  Duration over{};
  std::string group;
  double power = 1;
};

/// From `at` on a movable object goes to another place, evenly over `over`; it turns the short way.
struct MoveEvent {
  Time at;
  Duration over{};
  std::size_t object = 0;  ///< in World::objects
  Pose2 T_scene_object;    ///< where to; its height stays
};

/// Somebody who walks along a path, a disc on the floor with a figure to be seen.
struct Person {
  std::size_t object = 0;  ///< in World::objects; its x looks ahead
  std::vector<Vec2> path_scene;
  double speed_mps = 1;
  Time start;           ///< stands at the first point until then
  bool returns = true;  ///< walks the path back and again, for ever; else stops at its end
  double radius_m = 0.25;
  double waits_m =
      0.5;  ///< stands as long as the robot's body is nearer ahead than this; 0: walks on
  double turns_back_s = 10;  ///< of waiting for the robot, where it walks there and back
};

/// A synthetic world: a plain value in `scene`, z up, the floor at z = 0.
struct World {
  std::string name;
  double ambient = 0.35;      ///< light from everywhere, weakened in corners
  std::string ambient_group;  ///< the switch of the ambient light
  std::vector<AreaLight> lights;
  std::optional<Sun> sun;
  std::array<double, 3> sky_bgr{};  ///< seen where nothing is, as the light of each colour; goes
                                    ///< with the ambient light
  std::vector<Texture> textures;
  std::vector<Object> objects;
  std::vector<LightEvent> light_events;  ///< in order of time
  std::vector<MoveEvent> move_events;    ///< in order of time
  std::vector<Person> people;
};

/// How the world differs at an instant from what it is at time 0; by default in nothing.
struct SceneState {
  std::map<std::size_t, Pose3> T_scene_object;  ///< of objects that have moved
  std::map<std::string, double> power;          ///< of light groups that are not at 1
};

}  // namespace panoptes::sim
