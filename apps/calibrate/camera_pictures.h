// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/rig.h"

namespace panoptes {

/// The files of one camera's pictures, in the order of their names, 10 after 9.
struct CameraPictures {
  std::string camera;
  std::vector<std::string> files;
};

/// What lies in a folder: a dataset (the EuRoC layout, as panoptes record writes it), a folder of
/// one camera's pictures, or a folder with one such folder a camera. Throws ConfigError where there
/// are no pictures.
std::vector<CameraPictures> camera_pictures(const std::filesystem::path& folder);

/// The rig that a dataset holds; empty where it holds none.
std::optional<Rig> rig_beside(const std::filesystem::path& folder);

}  // namespace panoptes
