// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/camera/rig.h"
#include "core/eval/truth.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"

namespace panoptes::sim {

/// What the mapped part of one floor camera's picture truly shows of the floor.
class SeenFloor {
 public:
  /// `true_camera` has its floor view.
  SeenFloor(const RigCamera& true_camera, const Body& body);

  /// Marks the cells of the floor pixels (not 0 in `floor_label`, 8 bit, one channel) that lie in
  /// the mapped part, and in each column of the picture the foot of the object that first ends the
  /// floor, going upwards. Its pixel shows the object, which may hang over the floor, or be seen
  /// above its foot: a cell of `seen` in which nothing stands, by `floor`, is not marked by it.
  void mark(const cv::Mat& floor_label, const Pose2& T_scene_body, const TruthLayer& floor,
            TruthLayer& seen) const;

 private:
  int width_px_;
  int height_px_;
  int top_px_ = 0;               // first row of the mapped part
  std::vector<float> x_body_m_;  // of the floor under each pixel, row by row; NaN out of range
  std::vector<float> y_body_m_;
};

}  // namespace panoptes::sim
