// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/camera_pictures.h"

#include <algorithm>
#include <system_error>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/dataset.h"
#include "core/io/picture.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> folders_in(const fs::path& folder) {
  std::vector<fs::path> folders;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.is_directory(ignored)) {
      folders.push_back(entry.path());
    }
  }
  std::sort(folders.begin(), folders.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.string(), b.string());
  });
  return folders;
}

std::string name_of(const fs::path& folder) {
  const fs::path whole = fs::weakly_canonical(folder);
  const std::string name = whole.filename().empty() ? whole.parent_path().filename().string()
                                                    : whole.filename().string();
  return name.empty() ? "camera" : name;
}

}  // namespace

std::vector<CameraPictures> camera_pictures(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) {
    throw ConfigError(folder.string() +
                      (fs::exists(folder, ignored) ? ": is not a folder" : ": no such folder"));
  }
  std::vector<CameraPictures> cameras;
  if (fs::is_directory(folder / "mav0", ignored)) {
    for (const std::string& camera : camera_folders(folder / "mav0")) {
      std::vector<std::string> files = pictures_in(folder / "mav0" / camera / "data");
      if (!files.empty()) {
        cameras.push_back({camera, std::move(files)});
      }
    }
  } else if (std::vector<std::string> files = pictures_in(folder); !files.empty()) {
    cameras.push_back({name_of(folder), std::move(files)});
  } else {
    for (const fs::path& camera : folders_in(folder)) {
      if (std::vector<std::string> of_camera = pictures_in(camera); !of_camera.empty()) {
        cameras.push_back({camera.filename().string(), std::move(of_camera)});
      }
    }
  }
  if (cameras.empty()) {
    throw ConfigError(folder.string() +
                      ": holds no pictures; name a folder of PNG or JPEG files, a folder with one "
                      "such folder for each camera, or a dataset");
  }
  return cameras;
}

std::optional<Rig> rig_beside(const fs::path& folder) {
  const fs::path file = folder / "rig.yaml";
  std::error_code ignored;
  return fs::exists(file, ignored) ? std::optional(read_settings<Rig>(file.string()))
                                   : std::nullopt;
}

}  // namespace panoptes
