// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/config/fields.h"
#include "core/geometry/pose2.h"
#include "sim/world/world.h"

namespace panoptes::sim {

void bind(Fields& f, AreaLight& o);

/// A thing as a world file mentions it.
struct ObjectSettings {
  std::string name;
  std::string mesh;  ///< any file assimp reads, its y axis up: (x, y, z) there is (x, -z, y) here
  Pose2 at;
  double z_m = 0;
  std::map<std::string, std::string> textures;  ///< pictures instead of the mesh's own, by material

  std::string mesh_mention;                             ///< file:line:column of what the user wrote
  std::map<std::string, std::string> texture_mentions;  ///< the same, by material
};
void bind(Fields& f, ObjectSettings& o);

/// A world as its file says it, meshes and textures not yet read.
struct WorldSettings {
  std::string name;
  double ambient = 0.35;
  std::vector<AreaLight> lights;
  std::vector<ObjectSettings> objects;
};
void bind(Fields& f, WorldSettings& o);

/// Reads the meshes and textures. Throws IoError, with the place that mentions the file, for one
/// that is missing, cannot be read, has no faces or has numbers that are not finite.
World make_world(const WorldSettings& settings);

/// Both at once; throws ConfigError for faults in the world file itself.
World load_world(const std::string& file);

}  // namespace panoptes::sim
