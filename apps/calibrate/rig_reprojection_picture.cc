// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_reprojection_picture.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <fmt/format.h>

#include "apps/calibrate/picture_pane.h"
#include "apps/calibrate/rig_reprojection.h"
#include "apps/draw/canvas.h"
#include "apps/draw/pictures.h"
#include "apps/draw/plan_picture.h"
#include "core/base/time.h"

namespace panoptes {
namespace {

constexpr double kMargin = 20;
constexpr double kTitle = 46;
constexpr double kHeading = 30;
constexpr double kCaption = 28;
constexpr double kLegend = 64;
constexpr double kWidth = 640;  // of a picture
constexpr double kLong = 32;    // a line that is well seen, pixels of the canvas

/// By how much lines are enlarged: what is off by so much is well seen.
double enlargement(double off_px, double scale) {
  double enlarged = 1;
  for (const double by : {2.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
    enlarged = off_px * scale * by <= kLong ? by : enlarged;
  }
  return enlarged;
}

/// How much of a line from `at` is drawn: it stays in its box, and is no longer than helps.
double share_inside(const Vec2& at, const Vec2& off, const Vec2& low, const Vec2& high) {
  double share = std::min(1.0, 0.15 * kWidth / (off.norm() + 1e-9));
  for (int axis = 0; axis < 2; ++axis) {
    const double room = off[axis] > 0 ? high[axis] - at[axis] : at[axis] - low[axis];
    share = std::min(share, room / (std::abs(off[axis]) + 1e-9));
  }
  return std::max(share, 0.0);
}

std::string told(const ReprojectionRms& rms) {
  return fmt::format("own points {:.2f} px off, others' {:.2f} px (rms)", rms.own_px, rms.other_px);
}

}  // namespace

std::vector<std::size_t> telling_views(const RigCalibration& calibration, std::size_t camera,
                                       std::size_t most) {
  const RigTracks& tracks = calibration.tracks;
  std::vector<std::vector<std::size_t>> points(tracks.views.size());
  for (const RigSeen& seen : tracks.seen) {
    if (seen.believed && tracks.views[seen.view].camera == camera) {
      points[seen.view].push_back(seen.point);
    }
  }
  std::vector<std::size_t> chosen;
  std::set<std::size_t> shown;
  while (chosen.size() < most) {
    const auto adds = [&](const std::vector<std::size_t>& of_view) {
      return std::count_if(of_view.begin(), of_view.end(),
                           [&shown](std::size_t point) { return !shown.contains(point); });
    };
    const auto best =
        std::max_element(points.begin(), points.end(),
                         [&adds](const auto& a, const auto& b) { return adds(a) < adds(b); });
    if (best == points.end() || adds(*best) == 0) {
      break;
    }
    shown.insert(best->begin(), best->end());
    chosen.push_back(static_cast<std::size_t>(best - points.begin()));
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

cv::Mat draw_rig_reprojection(const RigCalibration& calibration, const WheelReadings& wheels,
                              std::size_t camera, const std::vector<ShownView>& shown) {
  const RigTracks& tracks = calibration.tracks;
  const Intrinsics& lens = calibration.bundle.state.lenses[camera];
  const double height = PicturePane::height_of(lens.width_px, lens.height_px, kWidth);
  const double row = height + kCaption;
  const double top = kTitle + kHeading;
  Canvas canvas(static_cast<int>(2 * kWidth + 3 * kMargin),
                static_cast<int>(top + static_cast<double>(shown.size()) * row + kLegend), kPaper);
  const ReprojectionRms before = reprojection_rms(tracks, calibration.before, wheels, camera);
  const ReprojectionRms after = reprojection_rms(tracks, calibration.bundle.state, wheels, camera);
  const double enlarged =
      enlargement(std::max(before.own_px, before.other_px), kWidth / lens.width_px);
  canvas.text(fmt::format("{}: where the points of all cameras' maps are drawn in its keyframes",
                          calibration.cameras[camera]),
              {kMargin, 30}, kInk, 18);
  for (const bool is_after : {false, true}) {
    const double x = kMargin + (is_after ? kWidth + kMargin : 0);
    canvas.text(fmt::format("{}: {}", is_after ? "after it" : "before joint adjustment",
                            told(is_after ? after : before)),
                {x, top - 10}, kInk);
    const RigBundleState& state = is_after ? calibration.bundle.state : calibration.before;
    for (std::size_t i = 0; i < shown.size(); ++i) {
      const double y = top + static_cast<double>(i) * row;
      const PicturePane pane(canvas, shown[i].grey, {x, y}, kWidth);
      for (const RigSeen& seen : tracks.seen) {
        if (seen.view != shown[i].view) {
          continue;
        }
        const Vec2 at = pane.at(seen.px);
        if (!seen.believed) {
          canvas.cross(at, 4, kWrongColour, 1.5);
          continue;
        }
        const Colour colour =
            nth_colour(static_cast<std::size_t>(calibration.map_of_point[seen.point]));
        if (const std::optional<Vec2> px = drawn_px(tracks, state, wheels, seen)) {
          const Vec2 off = enlarged * pane.scale() * (*px - seen.px);
          canvas.line(at, at + off * share_inside(at, off, {x, y}, {x + kWidth, y + height}),
                      colour, 2);
        }
        canvas.ring(at, 4, colour, 2);
      }
      const double at_s = to_seconds(tracks.instants[tracks.views[shown[i].view].instant] -
                                     tracks.instants.front());
      canvas.text(fmt::format("{:.1f} s after the first keyframe", at_s), {x, y + height + 18},
                  kFaint);
    }
  }
  const double y = top + static_cast<double>(shown.size()) * row + 20;
  double x = kMargin;
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const std::string what = calibration.cameras[c] + (c == camera ? "'s own points" : "'s points");
    canvas.ring({x + 6, y - 5}, 4, nth_colour(c), 2);
    canvas.text(what, {x + 18, y}, kInk);
    x += 18 + Canvas::text_width(what, 15) + 24;
  }
  canvas.cross({x + 6, y - 5}, 4, kWrongColour, 1.5);
  canvas.text("left out: contradicts the others", {x + 18, y}, kInk);
  canvas.text(fmt::format("ring: where a point was seen; line: to where it is drawn, {:g} times as "
                          "far",
                          enlarged),
              {kMargin, y + 24}, kInk);
  return canvas.shrunk();
}

}  // namespace panoptes
