// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "core/base/rng.h"
#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// Pictures of a bare box of a room, 6 m long and wide and 2.6 m high around the origin (x right, y
/// down, z ahead), its walls, floor and ceiling covered with blotches that never repeat.
class RoomPainter {
 public:
  /// `contrast` of the blotches in grey levels; 0 for a room with nothing to see.
  RoomPainter(const Intrinsics& lens, double contrast, Rng rng);

  /// As its lens draws it, with a noise of 2 grey levels.
  cv::Mat draw(const Pose3& T_room_camera, Rng& rng) const;

 private:
  Intrinsics lens_;
  std::vector<cv::Mat> walls_;
  std::vector<Vec3> rays_;
};

}  // namespace panoptes
