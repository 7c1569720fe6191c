// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/board.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/support/board_pictures.h"

namespace panoptes {
namespace {

TEST(Board, IsToldByCornersAndSquares) {
  const auto board = parse_board("9x6x0.025");
  ASSERT_TRUE(board.has_value());
  EXPECT_EQ(board->columns, 9);
  EXPECT_EQ(board->rows, 6);
  EXPECT_EQ(board->square_m, 0.025);
  EXPECT_EQ(board->corner_board(0), Vec3(0, 0, 0));
  EXPECT_EQ(board->corner_board(8), Vec3(8 * 0.025, 0, 0));
  EXPECT_EQ(board->corner_board(9), Vec3(0, 0.025, 0));
}

TEST(Board, WhatIsNoneIsRefused) {
  for (const char* text : {"", "9x6", "9x6x", "9x6x0", "9x6x-1", "9x6x25", "2x6x0.025", "9x2x0.025",
                           "9x6x0.025m", "9 6 0.025", "999x6x0.025", "9x6xnan", "9x6xinf"}) {
    EXPECT_FALSE(parse_board(text).has_value()) << text;
  }
}

/// How far each found corner is from where it is, whichever end was taken first.
std::vector<double> off_px(const std::vector<Vec2>& found, std::vector<Vec2> truth) {
  const auto distances = [&] {
    std::vector<double> all;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      all.push_back((found[i] - truth[i]).norm());
    }
    return all;
  };
  const std::vector<double> forth = distances();
  std::reverse(truth.begin(), truth.end());
  const std::vector<double> back = distances();
  return forth[0] < back[0] ? forth : back;
}

TEST(Board, CornersAreFoundToAFiftiethOfAPixel) {
  const Board board;
  for (const Intrinsics& lens :
       {lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.28, 0.08, 0.0008, -0.0006, 0}),
        lens_of_view(640, 480, deg_to_rad(185), Equidistant{-0.01, 0.002, 0, 0})}) {
    Rng rng(3);
    const BoardPainter painter(board, lens);
    std::vector<double> all_px;
    constexpr int kPictures = 6;
    BoardLight still;
    still.moves_mps = 0;
    for (const Pose3& T_camera_board : board_poses(board, lens, {}, kPictures, rng)) {
      const auto corners = find_board(painter.draw(T_camera_board, still, rng), board);
      ASSERT_TRUE(corners.has_value());
      for (const double px :
           off_px(*corners, seen_corners(board, lens, {T_camera_board}, 0, rng)[0])) {
        all_px.push_back(px);
      }
    }
    // one in fifty may be no corner at all, where a fisheye bends the board most
    std::sort(all_px.begin(), all_px.end());
    all_px.resize(all_px.size() * 49 / 50);
    double squared = 0;
    for (const double px : all_px) {
      squared += px * px;
    }
    constexpr double kFiftieth_px = 0.02;  // each way
    EXPECT_LT(std::sqrt(squared / (2.0 * static_cast<double>(all_px.size()))), kFiftieth_px);
    constexpr double kFifth_px = 0.2;
    EXPECT_LT(all_px.back(), kFifth_px);
  }
}

TEST(Board, NoneIsSeenWhereThereIsNoWholeOne) {
  const Board board;
  const Intrinsics lens = lens_of_view(640, 480, deg_to_rad(80), NoDistortion{});
  const BoardPainter painter(board, lens);
  Rng rng(4);
  EXPECT_FALSE(find_board(cv::Mat(480, 640, CV_8U, cv::Scalar(128)), board).has_value());
  const Pose3 cut{Eigen::Quaterniond::Identity(), Vec3(0.1, -0.06, 0.25)};
  EXPECT_FALSE(find_board(painter.draw(cut, {}, rng), board).has_value());
  Board larger = board;
  larger.columns = 11;
  const Pose3 whole{Eigen::Quaterniond::Identity(), Vec3(-0.1, -0.06, 0.4)};
  EXPECT_FALSE(find_board(painter.draw(whole, {}, rng), larger).has_value());
}

}  // namespace
}  // namespace panoptes
