// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/stage_cameras.h"

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

}  // namespace

Rig whole_rig(const std::string& dataset, const std::string& rig_file) {
  if (std::error_code ignored; !fs::is_directory(dataset, ignored)) {
    throw ConfigError(dataset + ": is no folder; give a dataset, as panoptes record leaves it");
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
      cameras.emplace_back(*found);
    }
  }
  return names.empty() ? std::vector<std::pair<std::string, RigCamera>>(rig.cameras.begin(),
                                                                        rig.cameras.end())
                       : cameras;
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

}  // namespace panoptes
