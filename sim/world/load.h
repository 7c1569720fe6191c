// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"
#include "sim/world/generate.h"
#include "sim/world/world.h"

namespace panoptes::sim {

void bind(Fields& f, AreaLight& o);

/// An object as a world file mentions it.
struct ObjectSettings {
  std::string name;
  std::string mesh;    ///< any file assimp reads
  double scale = 1;    ///< on the lengths in it, which are metres where its format does not say
  Up up = Up::kUsual;  ///< its axis that points up here, where its format does not say
  Pose2 at;
  double z_m = 0;
  bool movable = false;                         ///< an event may take it elsewhere
  std::map<std::string, std::string> textures;  ///< pictures instead of the mesh's own, by material

  std::string mention;                                  ///< file:line:column of what the user wrote
  std::string mesh_mention;                             ///< the same, of the mesh
  std::map<std::string, std::string> texture_mentions;  ///< the same, by material
};
void bind(Fields& f, ObjectSettings& o);

/// A box with pictures on its faces: walls, floors, ceilings and what else is square.
struct BoxSettings {
  std::string name;
  Vec3 size_m = Vec3::Ones();   ///< along its x, y and z
  Pose2 at;                     ///< of its hinge
  Vec2 hinge_m = Vec2::Zero();  ///< from the middle of its footprint: what a door turns about
  double z_m = 0;               ///< of its underside
  bool movable = false;         ///< an event may take it elsewhere
  std::string picture;          ///< on every face
  std::map<std::string, std::string>
      faces;  ///< other pictures: front (+x), back, left (+y), right, top, bottom; empty: no face.
              ///< An underside on the floor, which nobody sees, has none unless it is named here
  Vec2 picture_m = Vec2::Zero();  ///< size of one repeat, its top left on the face's own; 0, 0: the
                                  ///< picture once over each face

  std::string mention;  ///< file:line:column of what the user wrote
  std::string picture_mention;
  std::map<std::string, std::string> face_mentions;
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
  double turns_back_s = 10;

  std::string mention;
  std::string mesh_mention;
  std::string path_mention;
};
void bind(Fields& f, PersonSettings& o);

/// Walls from a ROS map_server map: its occupied cells, by the thresholds of its yaml, extruded,
/// and a wall around it all. Cells are joined to straight stretches of wall; where these still make
/// more than 50 000 triangles, two by two cells become one, wall where any of them is, and again.
struct FloorPlanSettings {
  std::string map;  ///< the yaml
  double height_m = 2.5;
  std::string wall;  ///< pictures; ours when empty
  std::string floor;
  std::string ceiling;
  bool has_ceiling = true;
  bool unknown_is_wall = false;  ///< else what the map does not know is floor

  std::string mention;  ///< of the map
  std::string wall_mention;
  std::string floor_mention;
  std::string ceiling_mention;
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
  std::vector<std::string> include;  ///< other world files, whose objects, lamps and events are
                                     ///< here too; their sky, sun and ambient light are not
  std::optional<GenerateOptions> generate;
  std::optional<FloorPlanSettings> floor_plan;
  std::vector<BoxSettings> boxes;
  std::vector<ObjectSettings> objects;
  std::vector<EventSettings> events;
  std::vector<PersonSettings> people;

  std::string file;     ///< that says all this, else empty
  std::string mention;  ///< file:line:column of what the user wrote
  std::vector<std::string> include_mentions;
  std::string generate_mention;
};
void bind(Fields& f, WorldSettings& o);

/// Gives a generated room that has no seed of its own the mission's, so that every seed has
/// another.
void draw_place(WorldSettings& settings, std::uint64_t seed);

/// The same world without `generate` and `include`: the places are made and the files read, and
/// what is in them stands among the rest. Throws ConfigError for what is wrong in them and for
/// files that include each other in a ring.
WorldSettings expanded(const WorldSettings& settings);

/// Makes the world, `expanded` or not: reads meshes, pictures and maps. Every fault is said at once
/// with the place that mentions it: ConfigError for what contradicts itself (names given twice,
/// events on what is not there, a path that leads through a wall) and for files that are no good
/// (damaged, without faces, with numbers that are not finite, or larger than a renderer can take:
/// kMostTriangles, kMostTextures); IoError where all there is to complain of is files that are
/// missing or that the machine cannot read.
World make_world(const WorldSettings& settings);

/// Nothing stands farther from the origin along an axis: beyond it single precision, in which
/// pictures are drawn and bodies touch, is coarser than a tenth of a millimetre.
inline constexpr double kFarthest_m = 1000;

/// Drawing a 640x480 picture of 40 k triangles takes 10 ms, of 330 k twice as long, and the bake
/// looks at every one: beyond this a world is too slow to be of use.
inline constexpr std::size_t kMostTriangles = 400'000;
/// The renderer keeps each at up to 512 x 512, with its smaller copies 1.4 MB: this is 0.7 GB.
inline constexpr std::size_t kMostTextures = 512;

/// Both at once; throws ConfigError for faults in the world file itself.
World load_world(const std::string& file);

}  // namespace panoptes::sim
