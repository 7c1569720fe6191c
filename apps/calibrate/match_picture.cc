// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/match_picture.h"

#include <algorithm>
#include <set>
#include <string>

#include <fmt/format.h>

#include "apps/calibrate/picture_pane.h"
#include "apps/draw/canvas.h"
#include "apps/draw/pictures.h"
#include "core/base/text.h"
#include "core/base/time.h"

namespace panoptes {
namespace {

constexpr double kMargin = 20;
constexpr double kTitle = 46;
constexpr double kLegend = 72;
constexpr double kWidth = 640;  // of a picture

/// A point's places in the views of two cameras, of which just one has it in its own map.
struct PointPlaces {
  std::vector<const RigSeen*> first;
  std::vector<const RigSeen*> second;
};

std::vector<PointPlaces> places_by_point(const RigCalibration& calibration,
                                         std::size_t first_camera, std::size_t second_camera) {
  std::vector<PointPlaces> places(calibration.map_of_point.size());
  for (const RigSeen& seen : calibration.tracks.seen) {
    const auto map = static_cast<std::size_t>(calibration.map_of_point[seen.point]);
    const std::size_t camera = calibration.tracks.views[seen.view].camera;
    if (map == first_camera || map == second_camera) {
      if (camera == first_camera) {
        places[seen.point].first.push_back(&seen);
      } else if (camera == second_camera) {
        places[seen.point].second.push_back(&seen);
      }
    }
  }
  return places;
}

/// Points of the map of `of` that `by` has found, and that are believed.
std::size_t points_found(const RigCalibration& calibration, std::size_t of, std::size_t by) {
  std::set<std::size_t> found;
  for (const RigSeen& seen : calibration.tracks.seen) {
    if (seen.believed && calibration.tracks.views[seen.view].camera == by &&
        calibration.map_of_point[seen.point] == static_cast<int>(of)) {
      found.insert(seen.point);
    }
  }
  return found.size();
}

}  // namespace

std::optional<MatchedViews> best_matched_views(const RigCalibration& calibration,
                                               std::size_t first_camera,
                                               std::size_t second_camera) {
  const std::size_t views = calibration.tracks.views.size();
  const std::vector<PointPlaces> places = places_by_point(calibration, first_camera, second_camera);
  std::vector<int> common(views * views, 0);  // row: the first camera's view
  for (const PointPlaces& point : places) {
    for (const RigSeen* a : point.first) {
      for (const RigSeen* b : point.second) {
        common[a->view * views + b->view] += a->believed && b->believed ? 1 : 0;
      }
    }
  }
  const auto best = std::max_element(common.begin(), common.end());
  if (best == common.end() || *best == 0) {
    return std::nullopt;
  }
  const auto at = static_cast<std::size_t>(best - common.begin());
  MatchedViews matched{at / views, at % views, {}};
  for (const PointPlaces& point : places) {
    for (const RigSeen* a : point.first) {
      for (const RigSeen* b : point.second) {
        if (a->view == matched.first && b->view == matched.second) {
          matched.matches.push_back({a->px, b->px, a->believed && b->believed});
        }
      }
    }
  }
  return matched;
}

cv::Mat draw_matches(const RigCalibration& calibration, const MatchedViews& views,
                     const cv::Mat& first_grey, const cv::Mat& second_grey) {
  const RigTracks& tracks = calibration.tracks;
  const std::size_t first_camera = tracks.views[views.first].camera;
  const std::size_t second_camera = tracks.views[views.second].camera;
  const std::string& first = calibration.cameras[first_camera];
  const std::string& second = calibration.cameras[second_camera];
  const double height =
      std::max(PicturePane::height_of(first_grey.cols, first_grey.rows, kWidth),
               PicturePane::height_of(second_grey.cols, second_grey.rows, kWidth));
  Canvas canvas(static_cast<int>(2 * kWidth + 3 * kMargin),
                static_cast<int>(kTitle + height + kLegend + kMargin), kPaper);
  const PicturePane left(canvas, first_grey, {kMargin, kTitle}, kWidth);
  const PicturePane right(canvas, second_grey, {2 * kMargin + kWidth, kTitle}, kWidth);
  // Those that are left out last: they are few.
  for (const bool believed : {true, false}) {
    const Colour& colour = believed ? kTruthColour : kWrongColour;
    for (const InterMapMatch& match : views.matches) {
      if (match.believed == believed) {
        canvas.line(left.at(match.first_px), right.at(match.second_px), colour, 1);
      }
    }
    for (const InterMapMatch& match : views.matches) {
      if (match.believed == believed) {
        canvas.ring(left.at(match.first_px), 4, colour, 2);
        canvas.ring(right.at(match.second_px), 4, colour, 2);
      }
    }
  }
  const auto inliers = std::count_if(views.matches.begin(), views.matches.end(),
                                     [](const InterMapMatch& match) { return match.believed; });
  canvas.text(fmt::format("{} and {}: {} of their maps that both of these keyframes show", first,
                          second, counted(static_cast<std::size_t>(inliers), "point")),
              {kMargin, 30}, kInk, 18);
  const auto at_s = [&tracks](std::size_t view) {
    return to_seconds(tracks.instants[tracks.views[view].instant] - tracks.instants.front());
  };
  const double below = kTitle + height + 22;
  canvas.text(fmt::format("{}, {:.1f} s after the first keyframe", first, at_s(views.first)),
              {kMargin, below}, kInk);
  canvas.text(fmt::format("{}, {:.1f} s after the first keyframe", second, at_s(views.second)),
              {2 * kMargin + kWidth, below}, kInk);
  const double y = below + 26;
  canvas.line({kMargin, y - 5}, {kMargin + 24, y - 5}, kTruthColour, 2);
  canvas.text("match that agrees with the others", {kMargin + 32, y}, kInk);
  canvas.line({kMargin + 350, y - 5}, {kMargin + 374, y - 5}, kWrongColour, 2);
  canvas.text(fmt::format("left out, for it does not: {}",
                          views.matches.size() - static_cast<std::size_t>(inliers)),
              {kMargin + 382, y}, kInk);
  const std::size_t by_second = points_found(calibration, first_camera, second_camera);
  const std::size_t by_first = points_found(calibration, second_camera, first_camera);
  // Maps that are laid on each other have the same points: nobody looked for the other's.
  canvas.text(
      by_second > 0 && by_first > 0
          ? fmt::format("In all keyframes {} found {} of {}'s map, and {} found {} of {}'s map",
                        second, counted(by_second, "point"), first, first,
                        counted(by_first, "point"), second)
          : fmt::format("In all keyframes they have {} in common",
                        counted(by_second + by_first, "point")),
      {kMargin, y + 26}, kInk);
  return canvas.shrunk();
}

}  // namespace panoptes
