// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/camera/rig.h"
#include "core/map/floor_colour.h"
#include "core/map/floor_projection.h"
#include "core/map/second_view.h"

namespace panoptes {

/// Finds what stands up by where it reaches, whatever its colour: what hangs together with what is
/// seen above the horizon, without an edge between, is no floor. So the floor ends, at the
/// farthest, at the first edge that comes down from there: the foot of a plain wall or of a door
/// that has the floor's colour.
class UprightFaces {
 public:
  /// Of a camera that looks where the floor camera looks. Empty where it does not see the horizon
  /// there.
  static std::optional<UprightFaces> of(const FloorProjection& projection, const RigCamera& camera,
                                        double noise_grey);

  /// What stands on one ray.
  struct Face {
    Vec2 foot_view = Vec2::Zero();  ///< where it stands at the farthest
    double depth_m = 0;             ///< floor along the ray that a pixel covers there
    bool ends = false;              ///< its foot shows there
  };
  /// Of each ray of the scan, in these directions about the camera's own foot; empty where nothing
  /// is known. `bgr` is the camera's picture, 8 bit, of the size its rig says; `levels` and
  /// `colour` tell which of its colours are the floor's, null: nobody knows.
  std::vector<std::optional<Face>> find(const cv::Mat& bgr, const Levels* levels,
                                        FloorColour& colour) const;

 private:
  struct Sight {
    std::int32_t pixel = 0;
    float range_m = 0;  // to the floor; infinite above the horizon
  };
  int width_px_ = 0;
  int height_px_ = 0;
  Vec2 foot_view_ = Vec2::Zero();
  double noise_grey_ = 0;
  double near_m_ = 0;                       // of the floor that is mapped
  std::vector<Vec2> directions_;            // of the rays, in view
  std::vector<std::vector<Sight>> sights_;  // of each ray, from above the horizon down
};

}  // namespace panoptes
