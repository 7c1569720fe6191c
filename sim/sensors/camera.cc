// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/check.h"
#include "core/base/error.h"
#include "sim/sensors/floor_pixels.h"

namespace panoptes::sim {
std::vector<FloorMark> survey_floor(const std::string& name, const RigCamera& true_camera,
                                    const Body& body, const SurveyError& error, const Rng& rng) {
  PANOPTES_CHECK(true_camera.floor.has_value(), "only a camera with a floor view is surveyed");
  // Near left, near right, far left, far right: the mapped pixels that lie farthest that way.
  constexpr std::array<std::array<int, 2>, 4> kDirections{{{-1, 1}, {1, 1}, {-1, -1}, {1, -1}}};
  constexpr int kMargin_px = 4;  // a mark is not a point: all of it has to be in the picture
  struct Place {
    int score = std::numeric_limits<int>::min();
    FloorMark mark;
  };
  std::array<Place, 4> places;
  const Intrinsics& lens = true_camera.intrinsics;
  for (int v = first_mapped_row(true_camera) + kMargin_px; v < lens.height_px - kMargin_px; ++v) {
    for (int u = kMargin_px; u < lens.width_px - kMargin_px; ++u) {
      const Vec2 px(u, v);
      const std::optional<Vec2> p_body = floor_under(true_camera, px);
      if (!p_body || !in_mapped_range(true_camera, body, *p_body)) {
        continue;
      }
      for (std::size_t i = 0; i < places.size(); ++i) {
        const int score = kDirections[i][0] * u + kDirections[i][1] * v;
        if (score > places[i].score) {
          places[i] = {score, {*p_body, px}};
        }
      }
    }
  }
  const Vec2 across = places[1].mark.px - places[2].mark.px;
  if (places[0].score == std::numeric_limits<int>::min() || across.x() < lens.width_px / 8.0 ||
      across.y() < lens.height_px / 8.0) {
    throw ConfigError("rig.cameras." + name +
                      ".floor: too little of the floor from near_m to far_m is in this camera's "
                      "picture to lay four marks on it; tilt it down or widen the range");
  }
  Rng draw = rng.fork(name);
  std::vector<FloorMark> marks;
  for (const Place& place : places) {
    FloorMark mark = place.mark;
    mark.p_body.x() += draw.normal(0, error.floor_m);
    mark.p_body.y() += draw.normal(0, error.floor_m);
    mark.px.x() += draw.normal(0, error.pixel_px);
    mark.px.y() += draw.normal(0, error.pixel_px);
    marks.push_back(mark);
  }
  return marks;
}

}  // namespace panoptes::sim
