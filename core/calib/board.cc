// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/board.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/calib/saddle.h"

namespace panoptes {
namespace {

/// From a corner to the next one `step` further along a row or column of `count`. Beyond the last
/// one steps go on shrinking as they did.
cv::Point2f step_to_next(const std::vector<cv::Point2f>& corners, int i, int at, int count,
                         int step) {
  const int stride = std::abs(step);
  const int next = at + step / stride;
  if (next >= 0 && next < count) {
    return corners[i + step] - corners[i];
  }
  const cv::Point2f last = corners[i] - corners[i - step];
  const cv::Point2f before = corners[i - step] - corners[i - 2 * step];
  const double shrinks = cv::norm(last) / cv::norm(before);
  return last * static_cast<float>(std::min(1.0, shrinks));
}

/// What is known of the surroundings of a corner.
struct Surroundings {
  Vec2 along_row_px = Vec2::Zero();
  Vec2 along_column_px = Vec2::Zero();
  double other_edges_px =
      std::numeric_limits<double>::max();  ///< the nearest that do not meet here
};

Surroundings surroundings(const std::vector<cv::Point2f>& corners, const Board& board, int i) {
  Surroundings here;
  for (const int along : {-1, 1}) {
    for (const int down : {-1, 1}) {
      const cv::Point2f a = step_to_next(corners, i, i % board.columns, board.columns, along);
      const cv::Point2f b =
          step_to_next(corners, i, i / board.columns, board.rows, down * board.columns);
      here.other_edges_px =
          std::min(here.other_edges_px, std::abs(a.cross(b)) / std::max(cv::norm(a), cv::norm(b)));
      here.along_row_px += along * Vec2(a.x, a.y);
      here.along_column_px += down * Vec2(b.x, b.y);
    }
  }
  return here;
}

/// By gradients: a window that holds no other corner's edges. A small one is noisier, but where the
/// lens bends most a large one is led away.
Vec2 by_gradients(const cv::Mat& grey, const cv::Point2f& corner, const Surroundings& here) {
  const double farthest_px = std::max(1.0, 0.25 * here.other_edges_px);
  for (const double share : {0.5, 0.35, 0.25}) {
    const int half_px = static_cast<int>(std::clamp(share * here.other_edges_px, 2.0, 10.0));
    std::vector<cv::Point2f> at{corner};
    cv::cornerSubPix(grey, at, cv::Size(half_px, half_px), cv::Size(-1, -1),
                     cv::TermCriteria(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 40, 1e-3));
    if (cv::norm(at[0] - corner) <= farthest_px) {
      return {at[0].x, at[0].y};
    }
  }
  return {corner.x, corner.y};
}

Vec2 refined(const cv::Mat& grey, const cv::Point2f& corner, const Surroundings& here) {
  constexpr double kFarthest_px = 1;
  constexpr double kMostRadius_px = 12;  // farther off edges curve otherwise than a parabola
  const Vec2 near_px = by_gradients(grey, corner, here);
  const double radius_px = std::min(kMostRadius_px, 0.85 * here.other_edges_px - 1);
  return fit_saddle(grey, near_px, here.along_row_px, here.along_column_px, radius_px, kFarthest_px)
      .value_or(near_px);
}

}  // namespace

Vec3 Board::corner_board(int index) const {
  PANOPTES_CHECK(index >= 0 && index < corners(), "a corner of the board");
  return {(index % columns) * square_m, (index / columns) * square_m, 0};
}

std::optional<Board> parse_board(std::string_view text) {
  Board board;
  char rest = 0;
  const std::string whole(text);
  if (std::sscanf(whole.c_str(), "%3dx%3dx%lf%c", &board.columns, &board.rows, &board.square_m,
                  &rest) != 3) {
    return std::nullopt;
  }
  const auto side = [](int corners) {
    return corners >= Board::kFewestCorners && corners <= Board::kMostCorners;
  };
  const bool sized = board.square_m > 0 && board.square_m <= Board::kLargestSquare_m;
  return side(board.columns) && side(board.rows) && sized ? std::optional(board) : std::nullopt;
}

std::optional<std::vector<Vec2>> find_board(const cv::Mat& grey, const Board& board) {
  const cv::Size inner(board.columns, board.rows);
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCornersSB(grey, inner, corners, cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return std::nullopt;
  }
  std::vector<Vec2> found;
  found.reserve(corners.size());
  for (int i = 0; i < board.corners(); ++i) {
    found.push_back(refined(grey, corners[i], surroundings(corners, board, i)));
  }
  return found;
}

}  // namespace panoptes
