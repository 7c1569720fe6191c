// SPDX-License-Identifier: BSD-3-Clause
// By which angle the cameras of a rig are turned from the first one, in truth, by panoptes
// calibrate and by the thesis's way, as its Tables 4.1 and 4.2 have it:
//   rig_angles RECORDING OUT
// RECORDING holds the truth, OUT what tests/compare/thesis_rig left there. A row of Markdown for
// each camera but the first, and one of the pictures; of seeds the mean and the standard deviation.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/camera/rig.h"
#include "core/eval/truth.h"
#include "core/geometry/pose3.h"
#include "core/io/file.h"
#include "hw/replay/truth_files.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

double angle_deg(const Eigen::Quaterniond& q) {
  return rad_to_deg(q.angularDistance(Eigen::Quaterniond::Identity()));
}

/// Of the results of a method, those that tell a rig.
struct MethodResults {
  std::vector<Json> told;
  std::size_t tried = 0;
  std::size_t good = 0;
};

MethodResults read_results(const fs::path& out, const std::string& method) {
  MethodResults results;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(out)) {
    if (entry.path().filename().string().starts_with(method)) {
      folders.push_back(entry.path());
    }
  }
  std::sort(folders.begin(), folders.end());
  for (const fs::path& folder : folders) {
    Json figures = Json::parse(read_file(folder / "metrics.json"));
    ++results.tried;
    results.good += figures.at("verdict") == "good" ? 1 : 0;
    if (figures.at("verdict") != "failed") {
      results.told.push_back(std::move(figures));
    }
  }
  return results;
}

/// `1.23`, or of several their mean and standard deviation.
std::string spread(const std::vector<double>& values, int digits) {
  if (values.empty()) {
    return "not told";
  }
  double mean = 0;
  for (const double value : values) {
    mean += value / static_cast<double>(values.size());
  }
  double square = 0;
  for (const double value : values) {
    square += (value - mean) * (value - mean);
  }
  return values.size() == 1
             ? fmt::format("{:.{}f}", mean, digits)
             : fmt::format("{:.{}f} +- {:.{}f}", mean, digits,
                           std::sqrt(square / static_cast<double>(values.size() - 1)), digits);
}

/// The angle and how far it is off of one camera, by all results that tell of it.
std::string cell(const MethodResults& results, const std::string& camera) {
  if (results.tried == 0) {
    return "";
  }
  std::vector<double> angles;
  std::vector<double> errors;
  for (const Json& figures : results.told) {
    const Json& found = figures.at("cameras").at(camera);
    if (found.contains("T_reference_camera")) {
      const auto q = found["T_reference_camera"]["rotation_wxyz"].get<std::vector<double>>();
      angles.push_back(angle_deg(Eigen::Quaterniond(q[0], q[1], q[2], q[3])));
      errors.push_back(found.at("rotation_error_deg").get<double>());
    }
  }
  return errors.empty() ? "not told"
                        : fmt::format("{}; off by {}{}", spread(angles, 3), spread(errors, 3),
                                      angles.size() < results.tried
                                          ? fmt::format(" ({} of {})", angles.size(), results.tried)
                                          : "");
}

std::string pictures_cell(const MethodResults& results) {
  if (results.tried == 0) {
    return "";
  }
  std::vector<double> mse_px2;
  for (const Json& figures : results.told) {
    mse_px2.push_back(std::pow(figures.at("reprojection_rms_px").at("after").get<double>(), 2));
  }
  return fmt::format("{}; {} of {} good", spread(mse_px2, 3), results.good, results.tried);
}

int run(const fs::path& recording, const fs::path& out) {
  const std::optional<hw::RecordedTruth> recorded = hw::RecordedTruth::read(recording);
  const std::optional<Rig> truth = recorded && recorded->observations() > 0
                                       ? recorded->after(recorded->observations()).rig
                                       : std::nullopt;
  if (!truth) {
    throw ConfigError(recording.string() + ": does not hold its true rig");
  }
  const MethodResults guided = read_results(out, "guided");
  const MethodResults thesis = read_results(out, "thesis_");
  const MethodResults cycles = read_results(out, "cycles_");
  fmt::print(
      "| degrees from {0} | truth | thesis | cycles | guided |\n| --- | --- | --- | --- | --- |\n",
      truth->cameras.begin()->first);
  const Pose3& first = truth->cameras.begin()->second.T_body_camera;
  for (const auto& [name, camera] : truth->cameras) {
    if (name != truth->cameras.begin()->first) {
      fmt::print("| `{}` | {:.3f} | {} | {} | {} |\n", name,
                 angle_deg(first.rotation.conjugate() * camera.T_body_camera.rotation),
                 cell(thesis, name), cell(cycles, name), cell(guided, name));
    }
  }
  fmt::print("| MSE, px^2; verdicts | | {} | {} | {} |\n", pictures_cell(thesis),
             pictures_cell(cycles), pictures_cell(guided));
  return 0;
}

}  // namespace
}  // namespace panoptes

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "rig_angles RECORDING OUT\n");
    return 2;
  }
  try {
    return panoptes::run(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
