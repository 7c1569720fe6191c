// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/board_picture.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "apps/draw/canvas.h"
#include "apps/draw/pictures.h"

namespace panoptes {
namespace {

constexpr double kMargin = 20;
constexpr double kTitle = 46;
constexpr double kLegend = 40;
constexpr double kEnlarged = 50;
constexpr Colour kUnused{236, 224, 216};

}  // namespace

cv::Mat draw_boards(const LensByBoards& told, const Board& board) {
  constexpr double kWidth = 900;
  const double scale = kWidth / told.width_px;
  const double height = told.height_px * scale;
  Canvas canvas(static_cast<int>(kWidth + 2 * kMargin),
                static_cast<int>(height + kTitle + kLegend + kMargin), kPaper);
  const Vec2 corner(kMargin, kTitle);
  const auto at = [&](const Vec2& px) { return Vec2(corner + scale * (px + Vec2(0.5, 0.5))); };
  const Vec2 part(kWidth / kPartsAcross, height / kPartsDown);
  for (int row = 0; row < kPartsDown; ++row) {
    for (int column = 0; column < kPartsAcross; ++column) {
      const Vec2 low = corner + part.cwiseProduct(Vec2(column, row));
      const bool used =
          std::any_of(told.corners.begin(), told.corners.end(), [&](const BoardCorners& corners) {
            return std::any_of(corners.begin(), corners.end(), [&](const Vec2& px) {
              const Vec2 p = at(px) - low;
              return p.minCoeff() >= 0 && p.x() < part.x() && p.y() < part.y();
            });
          });
      if (!used) {
        canvas.box(low, low + part, kUnused);
      }
    }
  }
  for (int column = 1; column < kPartsAcross; ++column) {
    const double x = corner.x() + column * part.x();
    canvas.line({x, corner.y()}, {x, corner.y() + height}, kGridColour, 1);
  }
  for (int row = 1; row < kPartsDown; ++row) {
    const double y = corner.y() + row * part.y();
    canvas.line({corner.x(), y}, {corner.x() + kWidth, y}, kGridColour, 1);
  }
  const std::vector<Vec3> corners = corners_board(board, told.fit.shape);
  for (std::size_t i = 0; i < told.corners.size(); ++i) {
    const FittedView& view = told.fit.views[i];
    for (int k = 0; k < board.corners(); ++k) {
      const Vec2& seen_px = told.corners[i][k];
      if (view.used) {
        const Vec2 drawn_px = told.fit.lens.project(view.T_camera_board * corners[k]);
        canvas.line(at(seen_px), at(seen_px + kEnlarged * (seen_px - drawn_px)), kOdometryColour,
                    1);
      }
      canvas.disc(at(seen_px), 1.6, view.used ? kEstimateColour : kWrongColour);
    }
  }
  canvas.frame(corner, corner + Vec2(kWidth, height), kFaint, 1);
  canvas.text(
      fmt::format("{}: {} boards in {} pictures, {} used; {}", told.camera, told.corners.size(),
                  told.looked_at.size(), told.fit.used(), name(told.fit.verdict)),
      {kMargin, 30}, kInk, 18);
  const double y = kTitle + height + 26;
  canvas.disc({kMargin + 6, y - 5}, 3, kEstimateColour);
  canvas.text("corner", {kMargin + 16, y}, kInk);
  canvas.disc({kMargin + 96, y - 5}, 3, kWrongColour);
  canvas.text("of a picture left out", {kMargin + 106, y}, kInk);
  canvas.line({kMargin + 280, y - 5}, {kMargin + 300, y - 5}, kOdometryColour, 1);
  canvas.text("off the lens, 50 times", {kMargin + 308, y}, kInk);
  canvas.box({kMargin + 500, y - 12}, {kMargin + 516, y}, kUnused);
  canvas.text("no corners here", {kMargin + 524, y}, kInk);
  return canvas.shrunk();
}

}  // namespace panoptes
