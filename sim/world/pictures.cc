// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/pictures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "core/config/data_files.h"
#include "core/io/file.h"
#include "core/io/picture.h"

namespace panoptes::sim {

template <class Read>
int Pictures::find_or_add(const std::string& name, const std::string& mention, const Read& read) {
  const auto [entry, is_new] = index_.try_emplace(name, static_cast<int>(textures_.size()));
  if (is_new) {
    textures_.push_back({name, {}});
    try {
      textures_.back().bgr = read();
    } catch (const IoError& error) {
      faults_.machine(mention, fmt::format("texture '{}' {}", name, error.what()));
    } catch (const ConfigError& error) {
      faults_.user(mention, fmt::format("texture '{}' {}", name, error.what()));
    }
  }
  return entry->second;
}

int Pictures::from_file(const std::string& file, const std::string& mention) {
  const std::string name = file.starts_with("data:") ? resolve_path(file, "") : file;
  return find_or_add(name, mention, [&name] {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(name, ignored)) {
      constexpr const char* kMissing = "does not exist; correct its path or put the file there";
      if (is_shipped(name)) {
        throw IoError(kMissing);
      }
      throw ConfigError(kMissing);
    }
    return decode_picture(read_file(name), kMostPictureSide_px, PictureColours::kBgr);
  });
}

int Pictures::from_bytes(const std::string& name, const std::string& bytes,
                         const std::string& mention) {
  return find_or_add(name, mention, [&bytes] {
    return decode_picture(bytes, kMostPictureSide_px, PictureColours::kBgr);
  });
}

int Pictures::from_pixels(const std::string& name, const cv::Mat& bgr) {
  return find_or_add(name, "", [&bgr] { return bgr; });
}

int Pictures::plain(double red, double green, double blue) {
  const auto root = [](double light) {
    return static_cast<unsigned char>(std::lround(255 * std::sqrt(std::clamp(light, 0.0, 1.0))));
  };
  const cv::Vec3b bgr(root(blue), root(green), root(red));
  return find_or_add(fmt::format("colour {},{},{}", bgr[2], bgr[1], bgr[0]), "",
                     [&bgr] { return cv::Mat(1, 1, CV_8UC3, cv::Scalar(bgr)); });
}

}  // namespace panoptes::sim
