// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/stage_cameras.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "apps/calibrate/camera_pictures.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/config/fields.h"
#include "core/io/dataset.h"

namespace panoptes {

namespace fs = std::filesystem;

namespace {

std::string in_words(const std::vector<std::string>& names) {
  return names.empty() ? "none" : joined(names);
}

/// What a rig file calls exact is known as well as a number can be told.
RigCamera weighable(RigCamera camera) {
  constexpr double kRotation_rad = 1e-6;
  constexpr double kPosition_m = 1e-6;
  constexpr double kFocal_ratio = 1e-6;
  constexpr double kCentre_px = 1e-3;
  constexpr double kClock_s = 1e-6;
  CameraSigmas& sigma = camera.sigma;
  sigma.rotation_rad = sigma.rotation_rad.cwiseMax(kRotation_rad);
  sigma.position_m = sigma.position_m.cwiseMax(kPosition_m);
  sigma.focal_ratio = std::max(sigma.focal_ratio, kFocal_ratio);
  sigma.centre_px = std::max(sigma.centre_px, kCentre_px);
  sigma.clock_s = std::max(sigma.clock_s, kClock_s);
  return camera;
}

}  // namespace

Rig whole_rig(const std::string& dataset, const std::string& rig_file) {
  if (std::error_code ignored; !fs::is_directory(dataset, ignored)) {
    throw ConfigError(
        dataset + (fs::exists(dataset, ignored)
                       ? ": is no folder; give a dataset, as panoptes record leaves it"
                       : ": is not there; give the file of a mission, or a dataset, as panoptes "
                         "record leaves it"));
  }
  const std::optional<Rig> rig =
      rig_file.empty() ? rig_beside(dataset) : read_settings<Rig>(rig_file);
  if (!rig) {
    throw ConfigError(dataset +
                      ": has no rig.yaml, which says what its lenses are; give one with --rig");
  }
  return *rig;
}

std::vector<std::pair<std::string, RigCamera>> rig_cameras(const Rig& rig,
                                                           const std::vector<std::string>& names) {
  std::vector<std::pair<std::string, RigCamera>> cameras;
  if (names.empty()) {
    for (const auto& [name, camera] : rig.cameras) {
      cameras.emplace_back(name, weighable(camera));
    }
  }
  std::set<std::string> taken;
  for (const std::string& name : names) {
    const auto found = rig.cameras.find(name);
    if (found == rig.cameras.end()) {
      std::vector<std::string> there;
      for (const auto& [camera, believed] : rig.cameras) {
        there.push_back(camera);
      }
      throw ConfigError(fmt::format("the rig has no camera {}; it has {}", name, in_words(there)));
    }
    if (taken.insert(name).second) {
      cameras.emplace_back(name, weighable(found->second));
    }
  }
  return cameras;
}

std::vector<std::pair<std::string, RigCamera>> stage_cameras(const std::string& dataset,
                                                             const std::string& rig_file,
                                                             std::vector<std::string> names) {
  const Rig rig = whole_rig(dataset, rig_file);
  if (names.empty()) {
    for (const std::string& name : camera_folders(fs::path(dataset) / "mav0")) {
      if (rig.cameras.contains(name)) {
        names.push_back(name);
      }
    }
  }
  if (names.empty()) {
    std::vector<std::string> cameras;
    for (const auto& [name, camera] : rig.cameras) {
      cameras.push_back(name);
    }
    throw ConfigError(fmt::format(
        "{}: has pictures of no camera of the rig: in mav0 there are {}, in the rig {}", dataset,
        in_words(camera_folders(fs::path(dataset) / "mav0")), in_words(cameras)));
  }
  return rig_cameras(rig, names);
}

std::vector<std::string> cameras_left_out(const std::string& dataset, const std::string& rig_file,
                                          const std::vector<std::string>& names) {
  std::vector<std::string> left_out;
  const std::vector<std::string> there = camera_folders(fs::path(dataset) / "mav0");
  for (const auto& [name, camera] : whole_rig(dataset, rig_file).cameras) {
    if (names.empty() && std::find(there.begin(), there.end(), name) == there.end()) {
      left_out.push_back(name);
    }
  }
  return left_out;
}

}  // namespace panoptes
