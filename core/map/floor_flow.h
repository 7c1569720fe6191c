// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/map/floor_projection.h"

namespace panoptes {

/// By how much a floor camera sits and is timed otherwise than its projection says, to first order:
/// turned about the axes of `view` and shifted along them, and its stamps early.
inline constexpr int kFloorRoll = 0;
inline constexpr int kFloorPitch = 1;
inline constexpr int kFloorYaw = 2;
inline constexpr int kFloorShift = 3;  ///< x, y, z
inline constexpr int kFloorClock = 6;
inline constexpr int kFloorStates = 7;
using FloorState = Eigen::Matrix<double, kFloorStates, 1>;
using FloorInformation = Eigen::Matrix<double, kFloorStates, kFloorStates>;

/// How well the wheels tell of a step, one sigma along x, y (m) and theta (rad) of the body: by
/// their own noise, slip and constants, and by a body that is slightly elastic.
Vec3 step_sigma(const Pose2& T_before_now);

/// What pictures show of these states: information * state = vector.
struct FloorEvidence {
  FloorInformation information = FloorInformation::Zero();
  FloorState vector = FloorState::Zero();

  FloorEvidence& operator+=(const FloorEvidence& other) {
    information += other.information;
    vector += other.vector;
    return *this;
  }
  FloorEvidence& operator-=(const FloorEvidence& other) {
    information -= other.information;
    vector -= other.vector;
    return *this;
  }
};

/// How the texture of the floor moves from picture to picture, against how the wheels say that the
/// body has moved: where a camera is not mounted as its projection says, the two do not agree.
/// Patches of floor are tracked on the floor (Lucas and Kanade 1981); what moves otherwise, or
/// stands up, is told apart by being in the minority. The motion is fitted together with the
/// states: the wheels tell it but roughly, that the body does not move sideways more surely. A
/// floor without texture says nothing.
class FloorFlow {
 public:
  FloorFlow(std::shared_ptr<const FloorProjection> projection, const Intrinsics& lens);

  /// `evidence`: of floor, on the projection's raster. Empty until the body has moved a step since
  /// the picture that the last evidence was of, and where too little was recognised.
  std::optional<FloorEvidence> add(const cv::Mat& bgr, const std::vector<std::int8_t>& evidence,
                                   const Pose2& T_odom_body, const Twist2& twist_body);

  /// What comes is not of the same drive.
  void forget() { last_.reset(); }

 private:
  static constexpr int kSide = 9;  // samples of a patch, and one more to each side for its gradient
  static constexpr int kRim = kSide + 2;
  struct Patch {
    Vec2 p_view;
    std::array<Eigen::Vector2f, kRim * kRim> px;
    std::array<std::size_t, 5> cells;  // its middle and its corners
  };
  struct Seen {
    Pose2 T_odom_view;
    Vec3 twist_view;  // x, y, theta
    cv::Mat grey;
  };
  struct Look;   // of a patch now
  struct Track;  // and how far from where it was expected it was before

  std::vector<Look> looks(const cv::Mat& grey, const std::vector<std::int8_t>& evidence) const;
  std::optional<Track> track(const Look& look, const Seen& before, const Pose2& T_before_now) const;
  Eigen::Matrix<double, 2, 6> moved_by(const Vec2& p_view) const;

  std::shared_ptr<const FloorProjection> projection_;
  Mat3 H_px_view_;
  std::vector<Patch> patches_;
  std::optional<Seen> last_;
};

}  // namespace panoptes
