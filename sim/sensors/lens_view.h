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
/// shows something: there is no border. Depth is along the camera's axis; an equidistant lens,
/// which sees beside its axis and behind, has it along each pixel's ray.
class LensView {
 public:
  /// Draws the world as a View sees it.
  using Draw = std::function<RenderedImage(const View&, const RenderOutputs&)>;

  explicit LensView(const Intrinsics& lens);

  const std::vector<PinholeFaces::Face>& faces() const { return whole_.faces; }

  /// The rows from `first_row` to before `end_row` of the lens's picture, and the truth asked for.
  RenderedImage draw(const Draw& draw, const Pose3& T_scene_camera, double gain,
                     const RenderOutputs& outputs, int first_row, int end_row) const;
  RenderedImage draw(const Draw& draw, const Pose3& T_scene_camera, double gain,
                     const RenderOutputs& outputs) const {
    return this->draw(draw, T_scene_camera, gain, outputs, 0, lens_.height_px);
  }

 private:
  struct Span {
    int first = 0;
    int end = 0;
  };
  /// Where a pixel finds what it shows.
  struct PixelSource {
    std::size_t face = 0;
    Vec2 at = Vec2::Zero();  ///< in its face, at focal length 1
    double depth_per_face_depth = 1;
  };
  Span rows_needed(std::size_t face, int first_row, int end_row) const;
  void make_maps(const std::vector<PixelSource>& sources);
  double covered(const std::vector<PixelSource>& sources, int v, int u) const;
  PinholeFaces part(int first_row, int end_row) const;

  Intrinsics lens_;
  PinholeFaces whole_;
  std::vector<std::vector<Span>> rows_of_;  // of each face, for each row of the picture
  cv::Mat depth_per_face_depth_;            // empty where they are the same
};

}  // namespace panoptes::sim
