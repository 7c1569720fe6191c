// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/camera/rig.h"
#include "core/geometry/pose3.h"
#include "sim/render/renderer.h"

namespace panoptes::sim {

/// How the picture of any lens is cut from what pinholes see: from one that sees a little more, or,
/// where the lens sees too wide for one, from several that look different ways, joined. Every pixel
/// shows something: there is no border.
class LensView {
 public:
  /// Draws the world as a pinhole sees it.
  using Draw = std::function<Drawn(const View&, const Ask&)>;

  explicit LensView(const Intrinsics& lens);

  /// A pinhole whose picture is a part of what the lens sees.
  struct Face {
    Intrinsics pinhole;
    Pose3 T_camera_face;  ///< turned, not moved
  };
  const std::vector<Face>& faces() const { return faces_; }

  /// The rows from `first_row` to before `end_row` of the lens's picture, and the truth asked for,
  /// which is taken from the nearest pixel drawn.
  Drawn draw(const Draw& draw, const Pose3& T_scene_camera, double gain, const Ask& ask,
             int first_row, int end_row);
  Drawn draw(const Draw& draw, const Pose3& T_scene_camera, double gain, const Ask& ask) {
    return this->draw(draw, T_scene_camera, gain, ask, 0, lens_.height_px);
  }

 private:
  struct Span {
    int first = 0;
    int end = 0;
  };
  /// Where a pixel finds what it shows.
  struct Sight {
    std::size_t face = 0;
    Vec2 at = Vec2::Zero();  ///< in its face, at focal length 1
    double axis_per_face_depth = 1;
  };
  Span rows_needed(std::size_t face, int first_row, int end_row) const;
  void make_maps(const std::vector<Sight>& sights);

  Intrinsics lens_;
  std::vector<Face> faces_;
  std::vector<int> tile_top_;               // of each face in the canvas, where they stand in a
                                            // column
  std::vector<std::vector<Span>> rows_of_;  // of each face, for each row of the picture
  cv::Mat whole_px_;                        // of the canvas, under each pixel of the picture:
  cv::Mat part_px_;                         // whole pixels and 32nds of them,
  cv::Mat nearest_px_;                      // and the nearest whole one
  cv::Mat axis_per_face_depth_;             // empty where the one face looks along the axis
  cv::Size canvas_size_;
  Drawn canvas_;  // kept to save making it anew
};

}  // namespace panoptes::sim
