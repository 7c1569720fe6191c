// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "apps/draw/canvas.h"
#include "core/geometry/pose2.h"
#include "core/map/occupancy.h"

namespace panoptes {

constexpr Colour kEstimateColour{31, 98, 196};
constexpr Colour kTruthColour{24, 150, 72};
constexpr Colour kOdometryColour{226, 125, 20};
constexpr Colour kLoopColour{132, 62, 178};
constexpr Colour kWrongColour{214, 28, 38};

struct LoopLine {
  Vec2 a_map;
  Vec2 b_map;
  bool wrong = false;
};

struct ContactMark {
  Vec2 p_map;
  bool while_moving = true;
};

/// A place that the robot was told to drive to.
struct GoalMark {
  enum class End { kReached, kRefused, kNeither };

  Vec2 p_map;
  End end = End::kNeither;
};

struct MapPicture {
  OccupancyMap map;
  std::vector<Pose2> estimate_map;  ///< the path as the map has it, from start to end
  std::vector<Vec2> truth_map;      ///< true path, empty where it is not known
  std::vector<LoopLine> loops;      ///< accepted closures
  std::vector<ContactMark> contacts;
  std::vector<GoalMark> goals;  ///< in turn
  std::string title;
};

/// The map with both paths on it, where the robot is at their end, the closures, what was touched
/// and the goals, numbered; with metres along the sides, a scale bar and a legend. A goal too far
/// out to be shown lies on the frame. 8-bit BGR.
cv::Mat draw_map(const MapPicture& picture);

struct Curve {
  std::string name;
  Colour colour;
  std::vector<Vec2> points;  ///< in the units of the axes
};
struct Tick {
  double x = 0;
  Colour colour;
};
struct Level {
  double y = 0;
  std::string name;
};

struct Plot {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<Curve> curves;
  std::vector<Tick> ticks;  ///< small marks on the x axis
  std::vector<std::pair<std::string, Colour>> tick_names;
  std::vector<Level> levels;  ///< dashed lines across
  double y_top = 0;           ///< at least this high
};

/// Curves over a common axis, from zero. 8-bit BGR.
cv::Mat draw_plot(const Plot& plot);

/// PNG bytes, the same for the same picture.
std::string png(const cv::Mat& bgr);

}  // namespace panoptes
