// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/board_pictures.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "tests/support/picture_noise.h"

namespace panoptes {
namespace {

constexpr int kParts = 4;  // of a pixel, each way

Eigen::Quaterniond turn(double angle_rad, const Vec3& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, axis));
}

/// A room, out of focus.
float room(const Vec3& direction) {
  return static_cast<float>(90 +
                            40 * std::sin(3 * direction.x() + 1) * std::cos(4 * direction.y()) +
                            20 * std::sin(9 * direction.z()));
}

/// The board and a square about it.
bool whole(const Board& board, const Intrinsics& lens, const Pose3& T_camera_board) {
  for (const double column : {-1.5, board.columns / 2.0, board.columns + 0.5}) {
    for (const double row : {-1.5, board.rows / 2.0, board.rows + 0.5}) {
      const Vec3 p = T_camera_board * Vec3(column * board.square_m, row * board.square_m, 0);
      if (!lens.sees(p)) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

std::vector<Pose3> board_poses(const Board& board, const Intrinsics& lens, const BoardPoses& held,
                               int count, Rng& rng) {
  const Vec3 middle_board((board.columns - 1) * board.square_m / 2,
                          (board.rows - 1) * board.square_m / 2, 0);
  const double width_m = (board.columns + 1) * board.square_m;
  std::vector<Pose3> poses;
  for (int tries = 0; static_cast<int>(poses.size()) < count; ++tries) {
    PANOPTES_CHECK(tries < 100000, "a board that fits the picture");
    const Vec2 px(lens.width_px * rng.uniform(held.from.x(), held.to.x()),
                  lens.height_px * rng.uniform(held.from.y(), held.to.y()));
    const std::optional<Vec3> d = lens.direction(px);
    if (!d) {
      continue;
    }
    const double angle_rad =
        rng.uniform(held.least_width, held.most_width) * lens.width_px / lens.fx_px;
    const double distance_m = width_m / (2 * std::tan(std::min(angle_rad, 2.0) / 2));
    const double slant_rad = held.most_slant_rad * std::sqrt(rng.uniform());
    const double towards_rad = rng.uniform(-3.2, 3.2);
    const Eigen::Quaterniond R =
        Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), *d) *
        turn(slant_rad, Vec3(std::cos(towards_rad), std::sin(towards_rad), 0)) *
        turn(rng.uniform(-held.most_roll_rad, held.most_roll_rad), Vec3::UnitZ());
    const Pose3 T{R, distance_m * *d - R * middle_board};
    if (whole(board, lens, T)) {
      poses.push_back(T);
    }
  }
  return poses;
}

std::vector<Pose3> board_poses_in_corners(const Board& board, const Intrinsics& lens, int count,
                                          Rng& rng) {
  constexpr double kNear = 0.3;  // of the picture
  std::vector<Pose3> poses;
  for (int i = 0; i < count; ++i) {
    BoardPoses held;
    held.most_width = 0.35;
    held.from = Vec2(i % 2 == 0 ? 0 : 1 - kNear, i / 2 % 2 == 0 ? 0 : 1 - kNear);
    held.to = held.from + Vec2(kNear, kNear);
    poses.push_back(board_poses(board, lens, held, 1, rng).front());
  }
  return poses;
}

std::vector<BoardCorners> seen_corners(const Board& board, const Intrinsics& lens,
                                       const std::vector<Pose3>& poses, double noise_px, Rng& rng) {
  return seen_corners(corners_board(board, {}), lens, poses, noise_px, rng);
}

std::vector<BoardCorners> seen_corners(const std::vector<Vec3>& corners_board,
                                       const Intrinsics& lens, const std::vector<Pose3>& poses,
                                       double noise_px, Rng& rng) {
  std::vector<BoardCorners> views;
  for (const Pose3& T_camera_board : poses) {
    BoardCorners& corners = views.emplace_back();
    for (const Vec3& p_board : corners_board) {
      const Vec2 px = lens.project(T_camera_board * p_board);
      corners.push_back(px + noise_px * Vec2(rng.normal(), rng.normal()));
    }
  }
  return views;
}

BoardPainter::BoardPainter(const Board& board, const Intrinsics& lens, const BoardShape& shape)
    : board_(board), shape_(shape), lens_(lens) {
  directions_.reserve(static_cast<std::size_t>(lens.width_px) * lens.height_px * kParts * kParts);
  const auto part = [](int i) { return (i + 0.5) / kParts - 0.5; };
  for (int y = 0; y < lens.height_px; ++y) {
    for (int x = 0; x < lens.width_px; ++x) {
      for (int j = 0; j < kParts; ++j) {
        for (int i = 0; i < kParts; ++i) {
          const auto d = lens.direction({x + part(i), y + part(j)});
          directions_.push_back(d ? Eigen::Vector3f(d->cast<float>()) : Eigen::Vector3f::Zero());
          room_.push_back(room(directions_.back().cast<double>()));
        }
      }
    }
  }
}

double BoardPainter::shade(std::size_t part, const Pose3& T_board_camera) const {
  const Vec3 direction = directions_[part].cast<double>();
  constexpr double kBlack = 35;
  constexpr double kWhite = 190;
  const Vec3 d = T_board_camera.rotation * direction;
  const Vec3& eye = T_board_camera.translation;
  if (direction.isZero()) {
    return 0;
  }
  const Vec3 half = board_.corner_board(board_.corners() - 1) / 2;
  double along = d.z() != 0 ? -eye.z() / d.z() : -1;
  double bow_m = 0;
  if (shape_.bow_rows_m != 0 || shape_.bow_columns_m != 0 || shape_.twist_m != 0) {
    constexpr int kRounds = 3;  // each is off by the bow's slope times what the last was
    for (int round = 0; round < kRounds; ++round) {
      const Vec2 at =
          (eye + along * d - half).head<2>().cwiseQuotient(half.head<2>()).cwiseMax(-2).cwiseMin(2);
      bow_m = shape_.bow_rows_m * at.x() * at.x() + shape_.bow_columns_m * at.y() * at.y() +
              shape_.twist_m * at.x() * at.y();
      along = d.z() != 0 ? (bow_m - eye.z()) / d.z() : -1;
    }
  }
  const Vec3 off_middle = eye + along * d - half;
  const double stretch = 1 + shape_.stretch / 2;
  const double x = (off_middle.x() / stretch + half.x()) / board_.square_m + 1;
  const double y = (off_middle.y() * stretch + half.y()) / board_.square_m + 1;
  constexpr double kMargin = 0.7;  // of a square, white
  if (along <= 0 || x < -kMargin || y < -kMargin || x > board_.columns + 1 + kMargin ||
      y > board_.rows + 1 + kMargin) {
    return room_[part];
  }
  if (x < 0 || y < 0 || x >= board_.columns + 1 || y >= board_.rows + 1) {
    return kWhite;
  }
  return (static_cast<int>(x) + static_cast<int>(y)) % 2 == 0 ? kBlack : kWhite;
}

cv::Mat BoardPainter::draw(const Pose3& T_camera_board, const BoardLight& light, Rng& rng) const {
  // Each part of a pixel is seen at another of four instants, the instants spread over the pixel.
  std::array<Pose3, kParts> T_board_camera;
  const Vec3 moves = light.moves_mps * Vec3(rng.normal(), rng.normal(), rng.normal());
  for (int i = 0; i < kParts; ++i) {
    Pose3 then = T_camera_board;
    then.translation += moves * light.shutter_s * ((i + 0.5) / kParts - 0.5);
    T_board_camera[i] = then.inverse();
  }
  const double bright = 1 + rng.uniform(-light.exposure, light.exposure);
  const Vec2 middle_px(lens_.width_px / 2.0, lens_.height_px / 2.0);
  cv::Mat picture(lens_.height_px, lens_.width_px, CV_32F);
  std::size_t at = 0;
  for (int y = 0; y < lens_.height_px; ++y) {
    for (int x = 0; x < lens_.width_px; ++x) {
      double sum = 0;
      for (int j = 0; j < kParts; ++j) {
        for (int i = 0; i < kParts; ++i) {
          sum += shade(at++, T_board_camera[(i + 2 * j) % kParts]);
        }
      }
      const double out = (Vec2(x, y) - middle_px).squaredNorm() / middle_px.squaredNorm();
      picture.at<float>(y, x) =
          static_cast<float>(sum / (kParts * kParts) * bright * (1 - light.vignetting * out));
    }
  }
  PictureNoise noise(rng);
  cv::GaussianBlur(picture, picture, cv::Size(), light.sharpness_px);
  for (int y = 0; y < lens_.height_px; ++y) {
    for (int x = 0; x < lens_.width_px; ++x) {
      picture.at<float>(y, x) += static_cast<float>(light.noise_grey * noise.normal());
    }
  }
  cv::Mat grey;
  picture.convertTo(grey, CV_8U);
  return grey;
}

}  // namespace panoptes
