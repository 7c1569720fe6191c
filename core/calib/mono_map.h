// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/time.h"
#include "core/calib/mono_slam.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// What one camera's pictures were turned into. `map` is the camera where it starts.
struct MonoMap {
  struct Frame {
    Time stamp;
    Pose3 T_map_camera;  ///< as it was believed then
    bool lost = false;
  };
  struct Seen {
    int frame = 0;
    Vec2 px = Vec2::Zero();
  };
  struct Point {
    int number = 0;
    Vec3 p_map = Vec3::Zero();
    Mat3 covariance = Mat3::Zero();
    SalientFeature feature;
    cv::Mat descriptor;
    std::vector<Seen> seen;  ///< in order of frames, from the one that it was first seen in
  };
  std::vector<Frame> frames;
  std::vector<Point> points;  ///< those of known depth
  Intrinsics lens;            ///< as it is believed in the end

  /// The innovations' squared sigmas over their number: 1 where the filter knows what it knows.
  double normalised_innovation = 0;
  double begins_s = 0;  ///< after the first picture: a start may have been given up
  double lost_s = 0;
  bool start_is_known = false;        ///< see MonoSlam
  std::optional<std::size_t> closed;  ///< the frame at which a point was first seen again all round
};

/// Seconds since the first picture.
struct LostSpan {
  double from_s = 0;  ///< of the last picture that held the camera
  double to_s = 0;    ///< of the last one that did not
};

/// When it was lost, in order.
std::vector<LostSpan> lost_spans(const MonoMap& map);

/// Collects the steps of a filter and makes a map of what it has come to.
class MonoMapBuilder {
 public:
  void add(Time stamp, const MonoSlamStep& step);
  MonoMap map(const MonoSlam& slam) const;

 private:
  std::optional<Time> first_picture_;
  std::vector<MonoMap::Frame> frames_;
  std::map<int, std::vector<MonoMap::Seen>> seen_;
  double squared_sigmas_ = 0;
  long dof_ = 0;
  std::optional<std::size_t> closed_;
};

}  // namespace panoptes
