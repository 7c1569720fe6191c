// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/urdf.h"

#include <cmath>
#include <exception>
#include <filesystem>
#include <memory>
#include <numbers>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_parser/urdf_parser.h>

#include "core/base/error.h"
#include "core/config/inputs.h"
#include "core/geometry/pose3.h"
#include "core/io/file.h"
#include "sim/world/mesh.h"

namespace panoptes::sim {
namespace {

namespace fs = std::filesystem;

constexpr int kSides = 32;  // of what is round

/// Keeps what the parser says, which it would print.
class Said : public console_bridge::OutputHandler {
 public:
  Said() { console_bridge::useOutputHandler(this); }
  ~Said() override { console_bridge::restorePreviousOutputHandler(); }
  Said(const Said&) = delete;
  Said& operator=(const Said&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/,
           int /*line*/) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) {
      text_ += (text_.empty() ? "" : "; ") + text;
    }
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string without_comments(std::string xml) {
  constexpr std::string_view kBegin = "<!--";
  constexpr std::string_view kEnd = "-->";
  for (std::size_t at = xml.find(kBegin); at != std::string::npos; at = xml.find(kBegin, at)) {
    const std::size_t end = xml.find(kEnd, at);
    xml.erase(at, end == std::string::npos ? end : end + kEnd.size() - at);
  }
  return xml;
}

Pose3 pose_of(const urdf::Pose& pose) {
  return {Eigen::Quaterniond(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z),
          Vec3(pose.position.x, pose.position.y, pose.position.z)};
}

void add_quad(std::vector<Face>& faces, const Vec3& a, const Vec3& b, const Vec3& c,
              const Vec3& d) {
  faces.push_back({a, b, c});
  faces.push_back({a, c, d});
}

/// Of a box, whose middle is the origin.
std::vector<Face> faces_of(const urdf::Box& box) {
  std::vector<Face> faces;
  const Vec3 half = 0.5 * Vec3(box.dim.x, box.dim.y, box.dim.z);
  for (int out = 0; out < 3; ++out) {
    for (const double sign : {-1.0, 1.0}) {
      const auto corner = [&](double across, double along) {
        Vec3 p;
        p[out] = sign * half[out];
        p[(out + 1) % 3] = across * half[(out + 1) % 3];
        p[(out + 2) % 3] = along * half[(out + 2) % 3];
        return p;
      };
      add_quad(faces, corner(-1, -1), corner(sign, -sign), corner(1, 1), corner(-sign, sign));
    }
  }
  return faces;
}

/// Of a body of revolution about z, by its outline from below: points (radius, height).
std::vector<Face> turned(const std::vector<Vec2>& outline) {
  std::vector<Face> faces;
  for (int k = 0; k < kSides; ++k) {
    const auto at = [&](int side, const Vec2& point) {
      const double angle = 2 * std::numbers::pi * side / kSides;
      return Vec3(point.x() * std::cos(angle), point.x() * std::sin(angle), point.y());
    };
    for (std::size_t i = 0; i + 1 < outline.size(); ++i) {
      add_quad(faces, at(k, outline[i]), at(k + 1, outline[i]), at(k + 1, outline[i + 1]),
               at(k, outline[i + 1]));
    }
  }
  return faces;
}

std::vector<Face> faces_of(const urdf::Cylinder& cylinder) {
  const double half_m = cylinder.length / 2;
  return turned({{0, -half_m}, {cylinder.radius, -half_m}, {cylinder.radius, half_m}, {0, half_m}});
}

std::vector<Face> faces_of(const urdf::Sphere& sphere) {
  std::vector<Vec2> outline;
  for (int i = 0; i <= kSides / 2; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    outline.emplace_back(sphere.radius * std::sin(angle), -sphere.radius * std::cos(angle));
  }
  return turned(outline);
}

/// Reads one robot.
class UrdfReader {
 public:
  UrdfReader(const std::string& file, const std::string& mention)
      : file_(file), mention_(mention.empty() ? "" : mention + ": ") {}

  std::vector<Face> read() {
    note_input(file_);
    const std::string text = read_file(file_);
    if (without_comments(text).find("<xacro:") != std::string::npos) {
      raise("is made of xacro; run `xacro FILE > robot.urdf` first and name what comes out");
    }
    urdf::ModelInterfaceSharedPtr robot;
    Said said;
    try {
      robot = urdf::parseURDF(text);
    } catch (const std::exception& error) {
      raise(std::string("is no URDF: ") + error.what());
    }
    if (robot == nullptr || robot->getRoot() == nullptr) {
      raise("is no URDF: " + (said.text().empty() ? "it has no link" : said.text()));
    }
    add(*robot->getRoot(), Pose3());
    if (faces_.empty()) {
      raise("has no link with a shape; give one a <visual> with a <geometry>");
    }
    return std::move(faces_);
  }

 private:
  [[noreturn]] void raise(const std::string& what) const {
    throw ConfigError(fmt::format("{}robot '{}' {}", mention_, file_, what));
  }

  void add(const urdf::Link& link, const Pose3& T_root_link) {
    if (!links_.insert(link.name).second) {
      raise(fmt::format("has the link {} under two joints; a robot is a tree", link.name));
    }
    for (const auto& visual : link.visual_array) {
      add(link, visual->geometry.get(), T_root_link * pose_of(visual->origin));
    }
    if (link.visual_array.empty()) {
      for (const auto& collision : link.collision_array) {
        add(link, collision->geometry.get(), T_root_link * pose_of(collision->origin));
      }
    }
    for (const auto& joint : link.child_joints) {
      for (const auto& child : link.child_links) {
        if (child->name == joint->child_link_name) {
          add(*child, T_root_link * pose_of(joint->parent_to_joint_origin_transform));
        }
      }
    }
  }

  void add(const urdf::Link& link, const urdf::Geometry* geometry, const Pose3& T_root_shape) {
    std::vector<Face> faces;
    if (const auto* box = dynamic_cast<const urdf::Box*>(geometry)) {
      faces = faces_of(*box);
    } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(geometry)) {
      faces = faces_of(*cylinder);
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(geometry)) {
      faces = faces_of(*sphere);
    } else if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(geometry)) {
      const Vec3 scale(mesh->scale.x, mesh->scale.y, mesh->scale.z);
      const double largest = scale.cwiseAbs().maxCoeff();
      if (!scale.allFinite() || !(largest > 0)) {
        raise(fmt::format("has the link {} with a mesh of no size; correct its scale", link.name));
      }
      faces = read_mesh_of(found(mesh->filename, link.name), largest);
      for (Face& face : faces) {
        for (Vec3& corner : face) {
          corner = corner.cwiseProduct(scale / largest);
        }
      }
    }
    for (const Face& face : faces) {
      faces_.push_back({T_root_shape * face[0], T_root_shape * face[1], T_root_shape * face[2]});
    }
  }

  /// In URDF z points up, where a mesh does not say otherwise.
  std::vector<Face> read_mesh_of(const std::string& mesh, double scale) const {
    const std::string format = format_of(mesh);
    const bool says_up = format == ".dae" || format == ".gltf" || format == ".glb";
    return read_faces(mesh, scale, says_up ? Up::kUsual : Up::kZ, mention_ + file_);
  }

  /// The file of a mesh.
  std::string found(const std::string& written, const std::string& link) const {
    const fs::path folder = fs::absolute(file_).parent_path();
    constexpr std::string_view kPackage = "package://";
    constexpr std::string_view kFile = "file:///";
    if (written.starts_with(kFile)) {
      return written.substr(kFile.size() - 1);
    }
    if (!written.starts_with(kPackage)) {
      if (written.find("://") != std::string::npos) {
        raise(fmt::format(
            "has the link {} with the mesh '{}'; name it by package://, file:///, or from the "
            "folder of the robot's file",
            link, written));
      }
      return (folder / written).string();
    }
    const fs::path in_package = written.substr(kPackage.size());
    for (fs::path above = folder;; above = above.parent_path()) {
      if (std::error_code ignored; fs::is_regular_file(above / in_package, ignored)) {
        return (above / in_package).string();
      }
      if (above == above.parent_path()) {
        raise(fmt::format(
            "has the link {} with the mesh '{}', but there is no '{}' in the file's folder or in "
            "one above; put the robot's package there",
            link, written, in_package.string()));
      }
    }
  }

  std::string file_;
  std::string mention_;
  std::set<std::string> links_;
  std::vector<Face> faces_;
};

}  // namespace

std::vector<Face> read_urdf(const std::string& file, const std::string& mention) {
  return UrdfReader(file, mention).read();
}

}  // namespace panoptes::sim
