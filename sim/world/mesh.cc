// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/mesh.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <assimp/DefaultIOSystem.h>
#include <assimp/Importer.hpp>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/config/data_files.h"
#include "core/config/inputs.h"

namespace panoptes::sim {
namespace {

namespace fs = std::filesystem;

// A mesh with as many triangles as may be, in the wordiest format (an STL of text, 260 bytes each),
// with room for embedded pictures; beyond it reading alone would take minutes.
constexpr std::uintmax_t kMostFile_bytes = 256U << 20U;
constexpr double kSmallest_m = 1e-3;  // smaller than the finest detail of a picture
constexpr double kLargest_m = 1e3;    // the map of what is true has cells of a centimetre

/// What all faults of one mesh begin with.
class Complaint {
 public:
  Complaint(const ObjectSettings& settings, std::string file)
      : mention_(settings.mesh_mention.empty() ? "" : settings.mesh_mention + ": "),
        file_(std::move(file)) {}

  [[noreturn]] void raise(const std::string& what) const { throw ConfigError(line(what)); }
  [[noreturn]] void raise_missing(const std::string& what) const {
    if (is_shipped(file_)) {
      throw IoError(line(what));
    }
    raise(what);
  }
  [[noreturn]] void raise_many(std::uint64_t triangles) const {
    raise(
        fmt::format("has {} triangles; a world takes {} in all: make it coarser (Blender: "
                    "Decimate), or cut it up",
                    triangles, kMostTriangles));
  }

 private:
  std::string line(const std::string& what) const {
    return fmt::format("{}mesh '{}' {}", mention_, file_, what);
  }

  std::string mention_;
  std::string file_;
};

/// Lines of an OBJ that begin a face, as triangles; the files of materials it names must be there,
/// for without them it would silently be grey.
std::uint64_t count_obj(std::ifstream& stream, const fs::path& folder, bool painted,
                        const Complaint& complaint) {
  constexpr std::string_view kMaterials = "mtllib ";
  std::uint64_t triangles = 0;
  std::string line;
  while (std::getline(stream, line)) {
    if (painted && line.starts_with(kMaterials)) {
      const std::size_t last = line.find_last_not_of(" \t\r");
      const std::string name = line.substr(kMaterials.size(), last + 1 - kMaterials.size());
      std::error_code ignored;
      if (!fs::is_regular_file(folder / name, ignored)) {
        complaint.raise_missing(
            fmt::format("takes its materials from '{}', which does not exist; put that file there, "
                        "or take out its line mtllib",
                        (folder / name).string()));
      }
    }
    if (line.size() > 1 && line[0] == 'f' && (line[1] == ' ' || line[1] == '\t')) {
      std::uint64_t corners = 0;
      for (std::size_t i = 1; i < line.size(); ++i) {
        const bool is_space = std::isspace(static_cast<unsigned char>(line[i])) != 0;
        const bool after_space = std::isspace(static_cast<unsigned char>(line[i - 1])) != 0;
        corners += after_space && !is_space ? 1 : 0;
      }
      triangles += corners > 2 ? corners - 2 : 0;
    }
  }
  return triangles;
}

/// What the header of a PLY says; its faces may have more corners than three. Room is made for as
/// many corners as it says before any is read.
std::uint64_t count_ply(std::ifstream& stream, std::uintmax_t size_bytes,
                        const Complaint& complaint) {
  constexpr int kMostHeaderLines = 1000;
  constexpr std::string_view kElement = "element ";
  std::string line;
  for (int i = 0; i < kMostHeaderLines && std::getline(stream, line); ++i) {
    if (line.starts_with("end_header")) {
      break;
    }
    if (!line.starts_with(kElement)) {
      continue;
    }
    const char* const end = line.data() + line.size();
    std::uint64_t count = 0;
    if (std::from_chars(line.data() + line.find_last_of(' ') + 1, end, count).ec ==
        std::errc::result_out_of_range) {
      count = std::numeric_limits<std::uint64_t>::max();
    }
    if (line.starts_with("element face ")) {
      return count;
    }
    if (count > size_bytes) {
      complaint.raise("says that it has more corners than a file of its size can; export it again");
    }
  }
  return 0;
}

/// What the header of a binary STL says, where the file is as long as that.
std::uint64_t count_stl(std::ifstream& stream, std::uintmax_t size_bytes) {
  std::array<char, 84> header{};
  stream.read(header.data(), static_cast<std::streamsize>(header.size()));
  std::uint64_t count = 0;
  for (std::size_t i = 4; i-- > 0 && stream;) {
    count = count << 8U | static_cast<unsigned char>(header[80 + i]);
  }
  return 84 + 50 * count == size_bytes ? count : 0;
}

/// Triangles as far as they can be told without reading the mesh; 0 where they cannot.
std::uint64_t count_before_reading(const std::string& file, std::uintmax_t size_bytes, bool painted,
                                   const Complaint& complaint) {
  const std::string format = format_of(file);
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    complaint.raise_missing("cannot be opened; make it readable");
  }
  return format == ".obj"   ? count_obj(stream, fs::path(file).parent_path(), painted, complaint)
         : format == ".ply" ? count_ply(stream, size_bytes, complaint)
         : format == ".stl" ? count_stl(stream, size_bytes)
                            : 0;
}

/// A mesh is often several files: buffers, materials, pictures.
class NotedFiles : public Assimp::DefaultIOSystem {
 public:
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    note_input(file);
    return DefaultIOSystem::Open(file, mode);
  }
};

/// Triangles that the scene makes: a mesh that stands in two places counts twice.
std::uint64_t count_placed(const aiScene& scene, const aiNode& node) {
  std::uint64_t triangles = 0;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      triangles += mesh.mFaces[f].mNumIndices > 2 ? mesh.mFaces[f].mNumIndices - 2 : 0;
    }
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) {
    triangles += count_placed(scene, *node.mChildren[c]);
    if (triangles > (std::uint64_t{1} << 62U)) {
      break;
    }
  }
  return triangles;
}

void require_sound(const aiScene& scene, const Complaint& complaint) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D& p = mesh.mVertices[v];
      const aiVector3D uv = mesh.HasTextureCoords(0) ? mesh.mTextureCoords[0][v] : aiVector3D();
      if (!Vec3(p.x, p.y, p.z).allFinite() || !Vec2(uv.x, uv.y).allFinite()) {
        complaint.raise("has a corner that is not a finite number; export it again");
      }
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (std::any_of(face.mIndices, face.mIndices + face.mNumIndices,
                      [&mesh](unsigned i) { return i >= mesh.mNumVertices; })) {
        complaint.raise("has a face with a corner that is not there; export it again");
      }
    }
    if (mesh.mMaterialIndex >= scene.mNumMaterials) {
      complaint.raise("has a surface with a material that is not there; export it again");
    }
  }
}

Up up_of(const ObjectSettings& settings, const std::string& file) {
  const std::string format = format_of(file);
  if (settings.up == Up::kUsual) {
    return format == ".ply" || format == ".stl" || format == ".off" ? Up::kZ : Up::kY;
  }
  if (format == ".gltf" || format == ".glb" || format == ".dae") {
    throw ConfigError(fmt::format("{}up: a {} file says itself which axis is up; leave `up` out",
                                  settings.mesh_mention.empty() ? "" : settings.mesh_mention + ": ",
                                  format.substr(1)));
  }
  return settings.up;
}

/// The picture of a material: what the world file says, else the mesh's own, else its plain colour.
int texture_of(const aiScene& scene, const aiMaterial& material, const ObjectSettings& settings,
               const std::string& mesh_file, Pictures& pictures) {
  const std::string material_name = material.GetName().C_Str();
  if (const auto own = settings.textures.find(material_name); own != settings.textures.end()) {
    const auto mention = settings.texture_mentions.find(material_name);
    return pictures.from_file(own->second, mention == settings.texture_mentions.end()
                                               ? settings.mesh_mention
                                               : mention->second);
  }
  const std::string mention =
      (settings.mesh_mention.empty() ? "" : settings.mesh_mention + ": ") + mesh_file;
  aiString path;
  if (material.GetTexture(aiTextureType_BASE_COLOR, 0, &path) == AI_SUCCESS ||
      material.GetTexture(aiTextureType_DIFFUSE, 0, &path) == AI_SUCCESS) {
    if (const aiTexture* embedded = scene.GetEmbeddedTexture(path.C_Str())) {
      const std::string name = mesh_file + ":" + path.C_Str();
      const auto* bytes = reinterpret_cast<const char*>(embedded->pcData);
      if (embedded->mHeight == 0) {  // a picture file, mWidth bytes of it
        return pictures.from_bytes(name, std::string(bytes, embedded->mWidth), mention);
      }
      const cv::Mat bgra(static_cast<int>(embedded->mHeight), static_cast<int>(embedded->mWidth),
                         CV_8UC4, embedded->pcData);
      cv::Mat bgr;
      cv::cvtColor(bgra, bgr, cv::COLOR_BGRA2BGR);
      return pictures.from_pixels(name, bgr);
    }
    std::string written = path.C_Str();
    std::replace(written.begin(), written.end(), '\\', '/');  // written on another system
    return pictures.from_file((fs::path(mesh_file).parent_path() / written).lexically_normal(),
                              mention);
  }
  aiColor4D colour(0.8F, 0.8F, 0.8F, 1);
  if (material.Get(AI_MATKEY_BASE_COLOR, colour) != AI_SUCCESS) {
    material.Get(AI_MATKEY_COLOR_DIFFUSE, colour);
  }
  return pictures.plain(colour.r, colour.g, colour.b);
}

/// How the lengths and axes of a mesh become ours.
struct Conversion {
  double scale = 1;
  Up up = Up::kY;
};

void append_triangles(const aiMesh& mesh, const aiMatrix4x4& transform, int texture,
                      const Conversion& conversion, const Complaint& complaint,
                      std::vector<Triangle>& triangles) {
  const auto corner = [&](unsigned index) {
    const aiVector3D p = transform * mesh.mVertices[index];
    Corner c;
    c.p_object =
        conversion.scale * (conversion.up == Up::kY ? Vec3(p.x, -p.z, p.y) : Vec3(p.x, p.y, p.z));
    if (mesh.HasTextureCoords(0)) {  // assimp's run up from the bottom
      c.uv = Vec2(mesh.mTextureCoords[0][index].x, 1.0 - mesh.mTextureCoords[0][index].y);
    }
    if (!c.p_object.allFinite() || !c.uv.allFinite()) {
      complaint.raise("has a corner that is not a finite number; export it again");
    }
    return c;
  };
  const bool mirrored = transform.Determinant() < 0;  // its faces stay turned outwards
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) {  // points and lines have no surface
      continue;
    }
    Triangle t;
    t.texture = texture;
    for (unsigned i = 0; i < 3; ++i) {
      t.corners[i] = corner(face.mIndices[mirrored ? 2 - i : i]);
    }
    const Vec3 a = t.corners[1].p_object - t.corners[0].p_object;
    const Vec3 b = t.corners[2].p_object - t.corners[0].p_object;
    if (a.cross(b).norm() > 0) {
      triangles.push_back(t);
    }
  }
}

/// A node's meshes and those of its children, where its transforms put them.
void append_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& T_root_parent,
                 const std::vector<int>& textures, const Conversion& conversion,
                 const Complaint& complaint, std::vector<Triangle>& triangles) {
  const aiMatrix4x4 T_root_node = T_root_parent * node.mTransformation;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    append_triangles(mesh, T_root_node, textures[mesh.mMaterialIndex], conversion, complaint,
                     triangles);
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) {
    append_node(scene, *node.mChildren[c], T_root_node, textures, conversion, complaint, triangles);
  }
}

/// The pictures of the materials that surfaces have; for the others -1.
std::vector<int> textures_of(const aiScene& scene, const ObjectSettings& settings,
                             const std::string& file, Pictures& pictures) {
  std::vector<int> textures(scene.mNumMaterials, -1);
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    int& texture = textures[scene.mMeshes[m]->mMaterialIndex];
    if (texture < 0) {
      texture = texture_of(scene, *scene.mMaterials[scene.mMeshes[m]->mMaterialIndex], settings,
                           file, pictures);
    }
  }
  return textures;
}

void require_sensible_size(const std::vector<Triangle>& triangles, const Complaint& complaint) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const Triangle& t : triangles) {
    for (const Corner& corner : t.corners) {
      low = low.cwiseMin(corner.p_object);
      high = high.cwiseMax(corner.p_object);
    }
  }
  const double size_m = (high - low).maxCoeff();
  if (!(size_m >= kSmallest_m && size_m <= kLargest_m)) {
    complaint.raise(fmt::format(
        "is {:.3g} m big; things here are from 1 mm to 1 km: give its `scale` (0.001 for "
        "millimetres)",
        size_m));
  }
}

void require_known_materials(const ObjectSettings& settings, const std::string& file,
                             const aiScene& scene) {
  std::set<std::string> materials;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    materials.insert(scene.mMaterials[scene.mMeshes[m]->mMaterialIndex]->GetName().C_Str());
  }
  for (const auto& [material, picture] : settings.textures) {
    if (materials.count(material) == 0) {
      const auto mention = settings.texture_mentions.find(material);
      throw ConfigError(
          fmt::format("{}mesh '{}' has no material '{}'; it has {}",
                      mention == settings.texture_mentions.end() ? "" : mention->second + ": ",
                      file, material, fmt::join(materials, ", ")));
    }
  }
}

// The importer calls everything that is thrown in it an unreadable file. It is one where the
// importer says so itself, or where a number in the file leads out of a container.
[[noreturn]] void raise_unread(std::unique_ptr<Assimp::Importer> importer,
                               const Complaint& complaint) {
  try {
    if (const std::exception_ptr& thrown = importer->GetException()) {
      std::rethrow_exception(thrown);
    }
  } catch (const std::runtime_error&) {  // DeadlyImportError
  } catch (const std::out_of_range&) {
  } catch (const std::length_error&) {
  } catch (...) {
    importer.release();  // what it was making is half made: its destructor may crash
    throw;
  }
  std::string reason = importer->GetErrorString();
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  complaint.raise(fmt::format("cannot be read: {}; export it again, as glTF or OBJ", reason));
}

/// Without `pictures` nothing is painted.
std::vector<Triangle> read_triangles(const ObjectSettings& settings, Pictures* pictures) {
  const std::string file =
      settings.mesh.starts_with("data:") ? resolve_path(settings.mesh, "") : settings.mesh;
  const Complaint complaint(settings, file);
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) {
    complaint.raise_missing("does not exist; correct its path or put the file there");
  }
  const std::uintmax_t size_bytes = fs::file_size(file, ignored);
  if (size_bytes > kMostFile_bytes) {
    complaint.raise(
        fmt::format("is {} MB large; it may be {}: make it coarser, and its pictures "
                    "smaller",
                    size_bytes >> 20U, kMostFile_bytes >> 20U));
  }
  const Up up = up_of(settings, file);
  if (const std::uint64_t count =
          count_before_reading(file, size_bytes, pictures != nullptr, complaint);
      count > kMostTriangles) {
    complaint.raise_many(count);
  }
  auto importer = std::make_unique<Assimp::Importer>();
  importer->SetIOHandler(new NotedFiles);  // it is the importer's from now on
  const aiScene* scene = importer->ReadFile(file, 0);
  if (scene == nullptr) {
    raise_unread(std::move(importer), complaint);
  }
  if (scene->mRootNode == nullptr || scene->mNumMeshes == 0) {
    complaint.raise("has no faces; export it with its surfaces");
  }
  require_sound(*scene, complaint);
  if (const std::uint64_t count = count_placed(*scene, *scene->mRootNode); count > kMostTriangles) {
    complaint.raise_many(count);
  }
  scene = importer->ApplyPostProcessing(aiProcess_Triangulate | aiProcess_TransformUVCoords);
  if (scene == nullptr) {
    complaint.raise("cannot be cut into triangles; export it again, as glTF or OBJ");
  }
  require_sound(*scene, complaint);
  require_known_materials(settings, file, *scene);
  std::vector<Triangle> triangles;
  const std::vector<int> textures = pictures == nullptr
                                        ? std::vector<int>(scene->mNumMaterials, 0)
                                        : textures_of(*scene, settings, file, *pictures);
  append_node(*scene, *scene->mRootNode, aiMatrix4x4(), textures, {settings.scale, up}, complaint,
              triangles);
  if (triangles.empty()) {
    complaint.raise("has no faces; export it with its surfaces");
  }
  require_sensible_size(triangles, complaint);
  return triangles;
}

}  // namespace

std::string format_of(const std::string& file) {
  std::string suffix = fs::path(file).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return suffix;
}

std::vector<Triangle> read_mesh(const ObjectSettings& settings, Pictures& pictures) {
  return read_triangles(settings, &pictures);
}

std::vector<Face> read_faces(const std::string& file, double scale, Up up,
                             const std::string& mention) {
  ObjectSettings settings;
  settings.mesh = file;
  settings.mesh_mention = mention;
  settings.scale = scale;
  settings.up = up;
  std::vector<Face> faces;
  for (const Triangle& triangle : read_triangles(settings, nullptr)) {
    const auto& [a, b, c] = triangle.corners;
    faces.push_back({a.p_object, b.p_object, c.p_object});
  }
  return faces;
}

}  // namespace panoptes::sim
