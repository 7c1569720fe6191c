// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/reached_floor.h"

#include <cstdint>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace panoptes {
namespace {

constexpr double kMargin_m = 0.05;  // beyond what half a passage reaches: corners

}  // namespace

OccupancyMap reached_floor(OccupancyMap map, std::span<const Vec2> way_map, double passage_m) {
  if (map.cells.empty()) {
    return map;
  }
  // a border, which is not free
  cv::Mat1b free(map.rows + 2, map.columns + 2, std::uint8_t{0});
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      free(row + 1, column + 1) = map(column, row) == Cell::kFree ? 1 : 0;
    }
  }
  cv::Mat1f to_edge;
  cv::distanceTransform(free, to_edge, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  const auto half = static_cast<float>(0.5 * passage_m / map.cell_m);
  const cv::Mat1b wide = to_edge >= half;
  cv::Mat1i labels;
  int count = cv::connectedComponents(wide, labels, 8, CV_32S);
  std::vector<std::uint8_t> reached(static_cast<std::size_t>(count), 0);
  bool any = false;
  for (const Vec2& p : way_map) {
    const int column = map.column(p);
    const int row = map.row(p);
    if (map.contains(column, row)) {
      const int label = labels(row + 1, column + 1);
      reached[static_cast<std::size_t>(label)] = 1;
      any = any || label > 0;
    }
  }
  if (!any) {
    return map;
  }
  cv::Mat1b beyond(free.size(), std::uint8_t{1});
  for (int row = 0; row < free.rows; ++row) {
    for (int column = 0; column < free.cols; ++column) {
      const int label = labels(row, column);
      if (label > 0 && reached[static_cast<std::size_t>(label)] != 0) {
        beyond(row, column) = 0;
      }
    }
  }
  cv::Mat1f to_reached;
  cv::distanceTransform(beyond, to_reached, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  const float most = half + static_cast<float>(kMargin_m / map.cell_m);
  cv::Mat1b about;
  cv::bitwise_and(free, to_reached <= most, about);
  count = cv::connectedComponents(about, labels, 8, CV_32S);
  std::vector<std::uint8_t> kept(static_cast<std::size_t>(count), 0);
  for (int row = 0; row < free.rows; ++row) {
    for (int column = 0; column < free.cols; ++column) {
      if (beyond(row, column) == 0) {
        kept[static_cast<std::size_t>(labels(row, column))] = 1;
      }
    }
  }
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const int label = labels(row + 1, column + 1);
      if (map(column, row) == Cell::kFree && kept[static_cast<std::size_t>(label)] == 0) {
        map(column, row) = Cell::kUnknown;
      }
    }
  }
  return map;
}

}  // namespace panoptes
