// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/config/fields.h"
#include "core/geometry/pose2.h"
#include "sim/world/generate.h"
#include "sim/world/world.h"

namespace panoptes::sim {

void bind(Fields& f, AreaLight& o);

/// A thing as a world file mentions it.
struct ObjectSettings {
  std::string name;
  std::string mesh;  ///< any file assimp reads, its y axis up: (x, y, z) there is (x, -z, y) here
  Pose2 at;
  double z_m = 0;
  bool movable = false;                         ///< an event may take it elsewhere
  std::map<std::string, std::string> textures;  ///< pictures instead of the mesh's own, by material

  std::string mesh_mention;                             ///< file:line:column of what the user wrote
  std::map<std::string, std::string> texture_mentions;  ///< the same, by material
};
void bind(Fields& f, ObjectSettings& o);

/// A box with pictures on its faces: walls, floors, ceilings and what else is square.
struct BoxSettings {
  std::string name;
  Vec3 size_m = Vec3::Ones();  ///< along its x, y and z
  Pose2 at;                    ///< of the middle of its footprint
  double z_m = 0;              ///< of its underside
  std::string picture;         ///< on every face
  std::map<std::string, std::string>
      faces;  ///< other pictures: front (+x), back, left (+y), right, top, bottom; empty: no face
  Vec2 picture_m = Vec2::Zero();  ///< size of one repeat, its top left on the face's own; 0, 0: the
                                  ///< picture once over each face

  std::string mention;  ///< file:line:column of what the user wrote
};
void bind(Fields& f, BoxSettings& o);

/// Something that happens at an instant; exactly one of lights, move and open is given.
struct EventSettings {
  double at_s = 0;
  double over_s = 0;   ///< it takes so long, evenly
  std::string lights;  ///< the group whose lights go to `power`
  double power = 1;
  std::string move;  ///< the movable object that goes to `to`
  Pose2 to;
  std::string open;      ///< the movable object, a door, that turns about its origin
  double angle_rad = 0;  ///< from where it was at time 0

  std::string mention;
};
void bind(Fields& f, EventSettings& o);

/// Somebody who walks. See Person.
struct PersonSettings {
  std::string name;
  std::string mesh = "data:people/walker.gltf";
  std::vector<Vec2> path;
  double speed_mps = 1;
  double start_s = 0;
  bool returns = true;
  double waits_m = 0.5;

  std::string mention;
};
void bind(Fields& f, PersonSettings& o);

/// Walls from a ROS map_server map: its occupied cells, by the thresholds of its yaml, extruded.
struct FloorPlanSettings {
  std::string map;  ///< the yaml
  double height_m = 2.5;
  std::string wall;  ///< pictures; ours when empty
  std::string floor;
  std::string ceiling;
  bool has_ceiling = true;

  std::string mention;
};
void bind(Fields& f, FloorPlanSettings& o);

/// A world as its file says it, meshes and textures not yet read.
struct WorldSettings {
  std::string name;
  double ambient = 0.35;
  std::string ambient_group;
  std::vector<AreaLight> lights;
  std::optional<Sun> sun;
  Vec3 sky_bgr = Vec3::Zero();       ///< the light of each colour, 0 to 1
  std::vector<std::string> include;  ///< other world files, whose things stand here too
  std::optional<GenerateOptions> generate;
  std::optional<FloorPlanSettings> floor_plan;
  std::vector<BoxSettings> boxes;
  std::vector<ObjectSettings> objects;
  std::vector<EventSettings> events;
  std::vector<PersonSettings> people;
};
void bind(Fields& f, WorldSettings& o);

/// Reads the meshes and textures. Throws IoError, with the place that mentions the file, for one
/// that is missing, cannot be read, has no faces or has numbers that are not finite.
World make_world(const WorldSettings& settings);

/// Both at once; throws ConfigError for faults in the world file itself.
World load_world(const std::string& file);

}  // namespace panoptes::sim
