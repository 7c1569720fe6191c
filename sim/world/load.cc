// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/load.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <set>
#include <utility>

#include <assimp/Importer.hpp>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/config/data_files.h"
#include "core/config/geometry_fields.h"

namespace panoptes::sim {
namespace {

/// The textures of a world, each kept once.
class TextureShelf {
 public:
  explicit TextureShelf(std::vector<Texture>& textures) : textures_(textures) {}

  template <class Read>
  int find_or_add(const std::string& name, const Read& read) {
    const auto [entry, is_new] = index_.try_emplace(name, static_cast<int>(textures_.size()));
    if (is_new) {
      textures_.push_back({name, read()});
    }
    return entry->second;
  }

 private:
  std::vector<Texture>& textures_;
  std::map<std::string, int> index_;
};

std::string prefix(const std::string& mention) { return mention.empty() ? "" : mention + ": "; }

void require_readable(const std::string& file, const std::string& mention, const char* what) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) {
    throw IoError(fmt::format("{}{} '{}' does not exist; correct its path or put the file there",
                              prefix(mention), what, file));
  }
}

cv::Mat read_picture(const std::string& file, const std::string& mention) {
  require_readable(file, mention, "texture");
  cv::Mat bgr = cv::imread(file, cv::IMREAD_COLOR);
  if (bgr.empty()) {
    throw IoError(fmt::format(
        "{}texture '{}' is not a picture that can be read; save it again as PNG or JPEG",
        prefix(mention), file));
  }
  return bgr;
}

cv::Mat decode_embedded(const aiTexture& texture, const std::string& mesh,
                        const std::string& mention) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(texture.pcData);
  cv::Mat bgr;
  if (texture.mHeight == 0) {  // a picture file, mWidth bytes of it
    bgr = cv::imdecode(std::vector<unsigned char>(bytes, bytes + texture.mWidth), cv::IMREAD_COLOR);
  } else {
    const cv::Mat bgra(static_cast<int>(texture.mHeight), static_cast<int>(texture.mWidth), CV_8UC4,
                       texture.pcData);
    cv::cvtColor(bgra, bgr, cv::COLOR_BGRA2BGR);
  }
  if (bgr.empty()) {
    throw IoError(fmt::format(
        "{}mesh '{}' embeds a texture that is not a picture; export it again with PNG textures",
        prefix(mention), mesh));
  }
  return bgr;
}

/// The picture of a material: what the world file says, else the mesh's own, else its plain colour.
int texture_of(const aiScene& scene, const aiMaterial& material, const ObjectSettings& settings,
               TextureShelf& shelf) {
  const std::string material_name = material.GetName().C_Str();
  if (const auto own = settings.textures.find(material_name); own != settings.textures.end()) {
    const auto mention = settings.texture_mentions.find(material_name);
    return shelf.find_or_add(own->second, [&] {
      return read_picture(own->second,
                          mention == settings.texture_mentions.end() ? "" : mention->second);
    });
  }
  aiString path;
  if (material.GetTexture(aiTextureType_BASE_COLOR, 0, &path) == AI_SUCCESS ||
      material.GetTexture(aiTextureType_DIFFUSE, 0, &path) == AI_SUCCESS) {
    if (const aiTexture* embedded = scene.GetEmbeddedTexture(path.C_Str())) {
      return shelf.find_or_add(settings.mesh + ":" + path.C_Str(), [&] {
        return decode_embedded(*embedded, settings.mesh, settings.mesh_mention);
      });
    }
    const std::filesystem::path beside = std::filesystem::path(settings.mesh).parent_path();
    const std::string file = (beside / path.C_Str()).lexically_normal().string();
    return shelf.find_or_add(
        file, [&] { return read_picture(file, prefix(settings.mesh_mention) + settings.mesh); });
  }
  aiColor4D colour(0.8F, 0.8F, 0.8F, 1);
  if (material.Get(AI_MATKEY_BASE_COLOR, colour) != AI_SUCCESS) {
    material.Get(AI_MATKEY_COLOR_DIFFUSE, colour);
  }
  // Colours of materials are amounts of light, pictures hold (nearly) their square roots.
  const auto root = [](float c) {
    return static_cast<unsigned char>(
        std::lround(255 * std::sqrt(std::clamp(static_cast<double>(c), 0.0, 1.0))));
  };
  const cv::Vec3b bgr(root(colour.b), root(colour.g), root(colour.r));
  return shelf.find_or_add(fmt::format("colour {},{},{}", bgr[2], bgr[1], bgr[0]),
                           [&] { return cv::Mat(1, 1, CV_8UC3, cv::Scalar(bgr)); });
}

void append_triangles(const aiMesh& mesh, int texture, const ObjectSettings& settings,
                      std::vector<Triangle>& triangles) {
  const auto corner = [&](unsigned index) {
    const aiVector3D& p = mesh.mVertices[index];
    Corner c;
    c.p_object = Vec3(p.x, -p.z, p.y);
    if (mesh.HasTextureCoords(0)) {  // assimp's run up from the bottom
      c.uv = Vec2(mesh.mTextureCoords[0][index].x, 1.0 - mesh.mTextureCoords[0][index].y);
    }
    if (!c.p_object.allFinite() || !c.uv.allFinite()) {
      throw IoError(
          fmt::format("{}mesh '{}' has a corner that is not a finite number; export it again",
                      prefix(settings.mesh_mention), settings.mesh));
    }
    return c;
  };
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) {  // points and lines have no surface
      continue;
    }
    Triangle t;
    t.texture = texture;
    for (unsigned i = 0; i < 3; ++i) {
      t.corners[i] = corner(face.mIndices[i]);
    }
    const Vec3 a = t.corners[1].p_object - t.corners[0].p_object;
    const Vec3 b = t.corners[2].p_object - t.corners[0].p_object;
    if (a.cross(b).norm() > 0) {
      triangles.push_back(t);
    }
  }
}

/// A mesh as read, so that a chair that stands in twenty places is read once.
using MeshKey = std::pair<std::string, std::map<std::string, std::string>>;

std::vector<Triangle> read_mesh(const ObjectSettings& settings, TextureShelf& shelf) {
  require_readable(settings.mesh, settings.mesh_mention, "mesh");
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFile(settings.mesh, aiProcess_Triangulate | aiProcess_PreTransformVertices);
  if (scene == nullptr) {
    std::string reason = importer.GetErrorString();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw IoError(fmt::format("{}mesh '{}' cannot be read: {}; export it again, as glTF or OBJ",
                              prefix(settings.mesh_mention), settings.mesh, reason));
  }
  std::set<std::string> materials;
  std::vector<Triangle> triangles;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    const aiMaterial& material = *scene->mMaterials[mesh.mMaterialIndex];
    materials.insert(material.GetName().C_Str());
    append_triangles(mesh, texture_of(*scene, material, settings, shelf), settings, triangles);
  }
  if (triangles.empty()) {
    throw IoError(fmt::format("{}mesh '{}' has no faces; export it with its surfaces",
                              prefix(settings.mesh_mention), settings.mesh));
  }
  for (const auto& [material, file] : settings.textures) {
    if (materials.count(material) == 0) {
      std::string known;
      for (const std::string& name : materials) {
        known += (known.empty() ? "" : ", ") + name;
      }
      const auto mention = settings.texture_mentions.find(material);
      throw ConfigError(
          fmt::format("{}mesh '{}' has no material '{}'; it has {}",
                      prefix(mention == settings.texture_mentions.end() ? "" : mention->second),
                      settings.mesh, material, known));
    }
  }
  return triangles;
}

}  // namespace

struct TexturePaths {  // by material
  std::map<std::string, std::string> file;
  std::map<std::string, std::string> mention;
};
void bind(Fields& f, TexturePaths& o) {
  for (auto& [material, file] : o.file) {
    f.path(material, file);
    o.mention[material] = f.where(material);
  }
}

void bind(Fields& f, AreaLight& o) {
  f.needed("at_m", o.at_m);
  f("size_m", o.size_m, positive);
  f("normal", o.normal);
  f.require(o.normal.norm() > 0, "normal", "must not be zero: it is where the light shines to");
  f("power", o.power, not_negative);
}

void bind(Fields& f, ObjectSettings& o) {
  f("name", o.name);
  f.path("mesh", o.mesh);
  o.mesh_mention = f.where("mesh");
  f("at", o.at);
  f("z_m", o.z_m);
  TexturePaths textures{o.textures, {}};
  if (f.present("textures")) {
    f("textures", textures.file);  // first which materials are named, then their files
  }
  if (!textures.file.empty()) {
    f("textures", textures);
  }
  o.textures = textures.file;
  o.texture_mentions = textures.mention;
}

void bind(Fields& f, WorldSettings& o) {
  f("name", o.name);
  f("ambient", o.ambient, not_negative);
  f("lights", o.lights);
  f.needed("objects", o.objects);
}

World make_world(const WorldSettings& settings) {
  World world;
  world.name = settings.name;
  world.ambient = settings.ambient;
  world.lights = settings.lights;
  TextureShelf shelf(world.textures);
  std::map<MeshKey, std::size_t> seen;
  for (const ObjectSettings& object : settings.objects) {
    const auto [first, is_new] =
        seen.try_emplace({object.mesh, object.textures}, world.objects.size());
    Pose3 T_scene_object = on_floor(object.at);
    T_scene_object.translation.z() = object.z_m;
    std::vector<Triangle> triangles =
        is_new ? read_mesh(object, shelf) : world.objects[first->second].triangles;
    world.objects.push_back({object.name, T_scene_object, std::move(triangles),
                             object.movable ? Object::Kind::kMovable : Object::Kind::kFixed});
  }
  return world;
}

World load_world(const std::string& file) { return make_world(read_settings<WorldSettings>(file)); }

}  // namespace panoptes::sim
