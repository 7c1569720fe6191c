// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/map_server.h"

#include <string>

#include <opencv2/imgcodecs.hpp>
#include <yaml-cpp/yaml.h>

#include "core/base/error.h"
#include "core/io/digits.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

constexpr unsigned char kFree = 254;
constexpr unsigned char kUnknown = 205;
constexpr unsigned char kOccupied = 0;

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

}  // namespace

void write_map_server(const std::filesystem::path& stem, const OccupancyMap& map) {
  const std::filesystem::path picture = with_suffix(stem, ".pgm");
  std::string pgm =
      "P5\n" + std::to_string(map.columns) + " " + std::to_string(map.rows) + "\n255\n";
  for (int row = map.rows - 1; row >= 0; --row) {
    for (int column = 0; column < map.columns; ++column) {
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

OccupancyMap read_map_server(const std::filesystem::path& yaml_path) {
  const MapYaml yaml(yaml_path);
  OccupancyMap map;
  map.cell_m = yaml.value<double>("resolution");
  if (!(map.cell_m > 0 && map.cell_m < 10)) {
    yaml.fault("resolution",
               "must be > 0 and < 10 metres, got " + yaml.value<std::string>("resolution"));
  }
  const auto origin = yaml.value<std::vector<double>>("origin");
  if (origin.size() < 2 || origin.size() > 3) {
    yaml.fault("origin", "must be [x, y, yaw]");
  }
  if (origin.size() == 3 && origin[2] != 0) {
    yaml.fault("origin", "yaw must be 0; turn the picture instead");
  }
  map.origin = {origin[0], origin[1]};
  const auto mode = yaml.value<std::string>("mode", "trinary");
  if (mode != "trinary" && mode != "scale") {
    yaml.fault("mode", "must be trinary or scale, got " + mode);
  }
  const bool negate = yaml.value<int>("negate", 0) != 0;
  const auto occupied_above = yaml.value<double>("occupied_thresh");
  const auto free_below = yaml.value<double>("free_thresh");
  if (!(free_below >= 0 && free_below <= occupied_above && occupied_above <= 1)) {
    yaml.fault("free_thresh", "must be from 0 to occupied_thresh, and that at most 1");
  }

  const std::filesystem::path picture_path =
      yaml_path.parent_path() / yaml.value<std::string>("image");
  const std::string bytes = read_file(picture_path);
  cv::Mat picture;
  if (!bytes.empty()) {
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U,
                          const_cast<char*>(bytes.data()));  // cv::Mat has no read-only view
    picture = cv::imdecode(encoded, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  }
  if (picture.empty()) {
    throw IoError(picture_path.string() + ": is not a picture that can be read");
  }
  map.columns = picture.cols;
  map.rows = picture.rows;
  map.cells.reserve(static_cast<std::size_t>(map.columns) * static_cast<std::size_t>(map.rows));
  for (int row = 0; row < map.rows; ++row) {
    const unsigned char* line = picture.ptr<unsigned char>(map.rows - 1 - row);
    for (int column = 0; column < map.columns; ++column) {
      const int grey = negate ? 255 - line[column] : line[column];
      const double occupied = (255 - grey) / 255.0;
      map.cells.push_back(occupied > occupied_above ? Cell::kOccupied
                          : occupied < free_below   ? Cell::kFree
                                                    : Cell::kUnknown);
    }
  }
  return map;
}

}  // namespace panoptes
