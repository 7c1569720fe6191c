// SPDX-License-Identifier: BSD-3-Clause
// How far COLMAP and panoptes calibrate are from the truth, one beside the other:
//   rig_beside RECORDING RESULT OUT MODEL...
// RECORDING holds the truth, RESULT is what panoptes calibrate left, OUT what
// tests/compare/colmap_rig did: of each model mapped/images.txt and rig/images.txt, the pictures'
// poses before and after the rig's adjustment, and cpu_s.txt, a line a step with the seconds of
// user and system; OUT/cpu_s.txt has those that all models share. Of each camera but the first one,
// as that one sees it: the angle, and the place after the one factor on all places that is best by
// least squares; of ours also in metres as they are.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/eval/truth.h"
#include "core/geometry/pose3.h"
#include "core/io/file.h"
#include "hw/replay/truth_files.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

/// As the first camera sees them, by their names; the first one itself is left out.
using RelativePoses = std::map<std::string, Pose3>;

RelativePoses relative_poses(const Rig& rig) {
  RelativePoses poses;
  const Pose3 T_first_body = rig.cameras.begin()->second.T_body_camera.inverse();
  for (const auto& [name, camera] : rig.cameras) {
    if (name != rig.cameras.begin()->first) {
      poses[name] = T_first_body * camera.T_body_camera;
    }
  }
  return poses;
}

/// images.txt of COLMAP: T_camera_world by snapshot and camera.
struct Reconstruction {
  std::map<std::string, std::map<std::string, Pose3>> snapshots;
  int pictures = 0;
};

Reconstruction read_images(const fs::path& file) {
  Reconstruction read;
  std::istringstream lines(read_file(file));
  std::string line;
  while (std::getline(lines, line)) {
    if (line.empty() || line.front() == '#') {
      continue;
    }
    std::istringstream words(line);
    int image = 0;
    int lens = 0;
    Pose3 T;
    std::string name;
    words >> image >> T.rotation.w() >> T.rotation.x() >> T.rotation.y() >> T.rotation.z() >>
        T.translation.x() >> T.translation.y() >> T.translation.z() >> lens >> name;
    const std::size_t slash = name.find('/');
    if (!words || slash == std::string::npos) {
      throw ConfigError(file.string() + ": is no table of pictures: " + line);
    }
    T.rotation.normalize();
    read.snapshots[name.substr(slash + 1)][name.substr(0, slash)] = T;
    ++read.pictures;
    std::getline(lines, line);  // its points, none perhaps
  }
  return read;
}

/// The means over all snapshots that have both cameras.
RelativePoses relative_poses(const Reconstruction& reconstruction, const Rig& rig) {
  RelativePoses poses;
  const std::string& first = rig.cameras.begin()->first;
  for (const auto& [name, camera] : rig.cameras) {
    Eigen::Matrix4d outer = Eigen::Matrix4d::Zero();
    Vec3 sum = Vec3::Zero();
    int count = 0;
    for (const auto& [stamp, T_camera_world] : reconstruction.snapshots) {
      if (name != first && T_camera_world.contains(first) && T_camera_world.contains(name)) {
        const Pose3 T = T_camera_world.at(first) * T_camera_world.at(name).inverse();
        outer += T.rotation.coeffs() * T.rotation.coeffs().transpose();
        sum += T.translation;
        ++count;
      }
    }
    if (count > 0) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> mean(outer);
      poses[name] = {Eigen::Quaterniond(Eigen::Vector4d(mean.eigenvectors().col(3))), sum / count};
    }
  }
  return poses;
}

/// What all places are multiplied by to lie as near to the true ones as they can.
double best_scale(const RelativePoses& found, const RelativePoses& truth) {
  double product = 0;
  double square = 0;
  for (const auto& [name, T] : found) {
    product += T.translation.dot(truth.at(name).translation);
    square += T.translation.squaredNorm();
  }
  return product / square;
}

/// A line of the table for each camera.
void say(const std::string& of, const RelativePoses& found, const RelativePoses& truth,
         bool metric) {
  const double scale = best_scale(found, truth);
  double most_deg = 0;
  double most_mm = 0;
  double most_metric_mm = 0;
  const auto in_metres = [&](double mm) {
    return metric ? fmt::format("{:8.2f}", mm) : fmt::format("{:>8}", "-");
  };
  for (const auto& [name, T_true] : truth) {
    const auto T = found.find(name);
    if (T == found.end()) {
      fmt::print("{:<28} {:<10} is not there\n", of, name);
      continue;
    }
    const double off_deg = rad_to_deg(T->second.rotation.angularDistance(T_true.rotation));
    const double off_mm = 1000 * (scale * T->second.translation - T_true.translation).norm();
    const double metric_mm = 1000 * (T->second.translation - T_true.translation).norm();
    fmt::print("{:<28} {:<10} {:8.4f} {:8.2f} {}\n", of, name, off_deg, off_mm,
               in_metres(metric_mm));
    most_deg = std::max(most_deg, off_deg);
    most_mm = std::max(most_mm, off_mm);
    most_metric_mm = std::max(most_metric_mm, metric_mm);
  }
  fmt::print("{:<28} {:<10} {:8.4f} {:8.2f} {}\n", of, "worst", most_deg, most_mm,
             in_metres(most_metric_mm));
}

/// What the steps of a cpu_s.txt took together, and in words each.
struct Spent {
  double sum_s = 0;
  std::string steps;
};

Spent read_spent(const fs::path& file) {
  Spent spent;
  std::istringstream lines(read_file(file));
  std::string step;
  double user_s = 0;
  double system_s = 0;
  while (lines >> step >> user_s >> system_s) {
    spent.sum_s += user_s + system_s;
    spent.steps += fmt::format(" {} {:.0f}", step, user_s + system_s);
  }
  return spent;
}

int run(const fs::path& recording, const fs::path& result, const fs::path& out,
        const std::vector<std::string>& models) {
  const std::optional<hw::RecordedTruth> recorded = hw::RecordedTruth::read(recording);
  if (!recorded || recorded->observations() == 0) {
    throw ConfigError(recording.string() + ": is no recording with its truth");
  }
  const std::optional<Rig> true_rig = recorded->after(recorded->observations()).rig;
  if (!true_rig) {
    throw ConfigError(recording.string() + ": does not know its true rig");
  }
  const RelativePoses truth = relative_poses(*true_rig);
  const Spent shared = read_spent(out / "cpu_s.txt");
  fmt::print("{:<28} {:<10} {:>8} {:>8} {:>8}\n", "", "camera", "deg", "mm", "metric");
  std::string summary;
  for (const std::string& model : models) {
    const Reconstruction mapped = read_images(out / model / "mapped" / "images.txt");
    const Reconstruction adjusted = read_images(out / model / "rig" / "images.txt");
    say("COLMAP " + model + ", mapper", relative_poses(mapped, *true_rig), truth, false);
    say("COLMAP " + model + ", rig", relative_poses(adjusted, *true_rig), truth, false);
    const Spent own = read_spent(out / model / "cpu_s.txt");
    summary += fmt::format("COLMAP {}: {} pictures registered; {:.0f} CPU s:{}{}\n", model,
                           mapped.pictures, shared.sum_s + own.sum_s, shared.steps, own.steps);
  }
  say("panoptes calibrate",
      relative_poses(read_settings<Rig>((result / "rig_calibrated.yaml").string())), truth, true);
  const auto figures = nlohmann::json::parse(read_file(result / "metrics.json"));
  fmt::print("{}panoptes calibrate: {}; {:.0f} CPU s\n", summary,
             figures.at("verdict").get<std::string>(), figures.at("cpu_s").get<double>());
  return 0;
}

}  // namespace
}  // namespace panoptes

int main(int argc, char** argv) {
  if (argc < 5) {
    std::fprintf(stderr, "rig_beside RECORDING RESULT OUT MODEL...\n");
    return 2;
  }
  try {
    return panoptes::run(argv[1], argv[2], argv[3], {argv + 4, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
