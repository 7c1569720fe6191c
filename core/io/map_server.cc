// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/map_server.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include <opencv2/core/mat.hpp>
#include <yaml-cpp/yaml.h>

#include "core/base/error.h"
#include "core/io/digits.h"
#include "core/io/file.h"
#include "core/io/picture.h"

namespace panoptes {
namespace {

constexpr unsigned char kFree = 254;
constexpr unsigned char kUnknown = 205;
constexpr unsigned char kOccupied = 0;
constexpr int kMostSide_cells = 10'000;

std::filesystem::path with_suffix(std::filesystem::path stem, const char* suffix) {
  stem += suffix;
  return stem;
}

/// What a yaml says, with the place in it for each fault.
class MapYaml {
 public:
  explicit MapYaml(const std::filesystem::path& path) : file_(path.string()) {
    try {
      root_ = YAML::Load(read_file(path));
    } catch (const YAML::Exception& e) {
      fault(e.mark, "", e.msg);
    }
    if (!root_.IsMap()) {
      fault(root_.Mark(), "", "is not a map_server map; a mapping with image, resolution, origin");
    }
  }

  template <class T>
  T value(const char* key) const {
    const YAML::Node node = root_[key];
    if (!node) {
      fault(root_.Mark(), key, "is missing");
    }
    try {
      return node.as<T>();
    } catch (const YAML::Exception&) {
      fault(node.Mark(), key, "has the wrong type");
    }
  }
  template <class T>
  T value(const char* key, const T& otherwise) const {
    return root_[key] ? value<T>(key) : otherwise;
  }
  /// 0 or 1, or what YAML 1.1 takes for them.
  bool truth(const char* key) const {
    const auto word = value<std::string>(key, "0");
    constexpr std::array<std::string_view, 4> kTrue{"1", "true", "yes", "on"};
    constexpr std::array<std::string_view, 4> kFalse{"0", "false", "no", "off"};
    const bool is_true = std::find(kTrue.begin(), kTrue.end(), word) != kTrue.end();
    if (!is_true && std::find(kFalse.begin(), kFalse.end(), word) == kFalse.end()) {
      fault(key, "must be 0 or 1, got " + word);
    }
    return is_true;
  }
  [[noreturn]] void fault(const char* key, const std::string& what) const {
    fault(root_[key].Mark(), key, what);
  }

 private:
  [[noreturn]] void fault(const YAML::Mark& mark, const std::string& key,
                          const std::string& what) const {
    throw ConfigError(file_ + ":" + std::to_string(mark.line + 1) + ":" +
                      std::to_string(mark.column + 1) + ": " + (key.empty() ? "" : key + ": ") +
                      what);
  }

  std::string file_;
  YAML::Node root_;
};

double finite(const MapYaml& yaml, const char* key, double value) {
  if (!std::isfinite(value)) {
    yaml.fault(key, "must be finite");
  }
  return value;
}

enum class Mode { kTrinary, kScale, kRaw };

Mode mode_of(const MapYaml& yaml) {
  const auto word = yaml.value<std::string>("mode", "trinary");
  if (word != "trinary" && word != "scale" && word != "raw") {
    yaml.fault("mode", "must be trinary, scale or raw, got " + word);
  }
  return word == "raw" ? Mode::kRaw : word == "scale" ? Mode::kScale : Mode::kTrinary;
}

cv::Mat picture_of(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  try {
    return decode_picture(bytes, kMostSide_cells, PictureColours::kGrey);
  } catch (const ConfigError& error) {
    throw ConfigError(path.string() + ": " + error.what());
  }
}

MapServerMap read(const MapYaml& yaml, const std::filesystem::path& yaml_path) {
  MapServerMap found;
  OccupancyMap& map = found.map;
  map.cell_m = yaml.value<double>("resolution");
  if (!(map.cell_m >= 0.001 && map.cell_m < 10)) {
    yaml.fault("resolution", "must be at least 0.001 and less than 10 metres, got " +
                                 yaml.value<std::string>("resolution"));
  }
  const auto origin = yaml.value<std::vector<double>>("origin");
  if (origin.size() != 3) {
    yaml.fault("origin",
               "must be [x, y, yaw], three numbers; got " + std::to_string(origin.size()));
  }
  map.origin = {finite(yaml, "origin", origin[0]), finite(yaml, "origin", origin[1])};
  found.yaw_rad = finite(yaml, "origin", origin[2]);
  const Mode mode = mode_of(yaml);
  const bool negate = yaml.truth("negate");
  const auto occupied_above = yaml.value<double>("occupied_thresh");
  const auto free_below = yaml.value<double>("free_thresh");
  if (!(free_below >= 0 && free_below <= occupied_above && occupied_above <= 1)) {
    yaml.fault("free_thresh", "must be from 0 to occupied_thresh, and that at most 1");
  }
  const cv::Mat picture = picture_of(yaml_path.parent_path() / yaml.value<std::string>("image"));

  std::array<Cell, 256> cell_of{};
  for (int grey = 0; grey < 256; ++grey) {
    const double occupied = mode == Mode::kRaw ? grey / 100.0
                            : negate           ? grey / 255.0
                                               : (255 - grey) / 255.0;
    cell_of[static_cast<std::size_t>(grey)] = mode == Mode::kRaw && grey > 100 ? Cell::kUnknown
                                              : occupied > occupied_above      ? Cell::kOccupied
                                              : occupied < free_below          ? Cell::kFree
                                                                               : Cell::kUnknown;
  }
  map.columns = picture.cols;
  map.rows = picture.rows;
  map.cells.reserve(picture.total());
  for (int row = map.rows - 1; row >= 0; --row) {
    const unsigned char* line = picture.ptr<unsigned char>(row);
    for (int column = 0; column < map.columns; ++column) {
      map.cells.push_back(cell_of[line[column]]);
    }
  }
  return found;
}

}  // namespace

void write_map_server(const std::filesystem::path& stem, const OccupancyMap& map) {
  const std::filesystem::path picture = with_suffix(stem, ".pgm");
  const int columns = std::max(1, map.columns);
  const int rows = std::max(1, map.rows);
  std::string pgm = "P5\n" + std::to_string(columns) + " " + std::to_string(rows) + "\n255\n";
  for (int row = rows - 1; row >= 0; --row) {
    for (int column = 0; column < columns; ++column) {
      const Cell cell = map.at(column, row);
      pgm += static_cast<char>(cell == Cell::kFree       ? kFree
                               : cell == Cell::kOccupied ? kOccupied
                                                         : kUnknown);
    }
  }
  write_file(picture, pgm);
  write_file(with_suffix(stem, ".yaml"),
             "image: " + picture.filename().string() +
                 "\nmode: trinary\nresolution: " + shortest(map.cell_m) + "\norigin: [" +
                 shortest(map.origin.x()) + ", " + shortest(map.origin.y()) +
                 ", 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

MapServerMap read_turned_map_server(const std::filesystem::path& yaml_path) {
  return read(MapYaml(yaml_path), yaml_path);
}

OccupancyMap read_map_server(const std::filesystem::path& yaml_path) {
  const MapYaml yaml(yaml_path);
  MapServerMap found = read(yaml, yaml_path);
  if (found.yaw_rad != 0) {
    yaml.fault("origin", "yaw must be 0; turn the picture instead");
  }
  return std::move(found.map);
}

}  // namespace panoptes
