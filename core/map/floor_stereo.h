// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/camera/rig.h"
#include "core/map/floor_projection.h"
#include "core/map/second_view.h"
#include "core/map/upright_points.h"

namespace panoptes {

/// Tells what stands up and has a floor's colour by a second camera that sees the same floor from
/// another height at the same instant. For each block of what looks like floor the heights are
/// tried at which the two pictures would agree (plane sweep, Collins 1996). A turn on the spot
/// shows it, of which FloorParallax knows nothing. What has no texture says nothing, nor does what
/// agrees at several heights. How the second camera is tilted, and how high it stands, is known as
/// well as the rig file says, and is learned from the floor.
class FloorStereo {
 public:
  /// Empty where the second camera shares too little floor with the floor camera of this lens, or
  /// stands so near to it that heights are not told.
  static std::optional<FloorStereo> of(std::shared_ptr<const FloorProjection> projection,
                                       const Intrinsics& floor_lens,
                                       const RigCamera& second_camera);

  /// A scan of the floor camera's picture.
  struct Scan {
    const cv::Mat& bgr;
    const std::vector<std::int8_t>& floor;   ///< of each sample, above 0 where it looks like floor
    const std::vector<std::int16_t>& first;  ///< the first obstacle's row along each ray
  };

  /// The feet of what stands up, in the frame of `T_odom_view`. `second_bgr`: what the second
  /// camera shows at that instant, and `levels` by which the floor camera would show it. Both
  /// pictures are 8-bit BGR of the size that the rig says.
  std::vector<UprightPoint> find(const Scan& scan, const cv::Mat& second_bgr, const Levels& levels,
                                 const Pose2& T_odom_view);

 private:
  struct Cell {
    std::int32_t sample = 0;  // of the scan
    std::int32_t pixel = 0;   // of the floor camera's picture
    Vec2 p_view = Vec2::Zero();
    std::size_t seen = 0;  // where its places in the second picture begin in seen_px_
  };
  struct Block {
    std::vector<Cell> cells;
    double cell_height_m = 0;      // that shifts what the second camera sees by a cell
    Vec3 by_error = Vec3::Zero();  // how much higher it looks by the second camera's error
  };
  struct Pair {  // what the floor camera shows of a cell
    float grey = 0;
    std::size_t seen = 0;
  };
  struct Seen {  // of a block
    const Block* block = nullptr;
    std::vector<Pair> pairs;
    Vec2 sight_view = Vec2::Zero();  // from the floor camera's foot, of what looks like floor
    double variance = 0;
    bool is_floor = false;            // no obstacle before it
    double flat = 0;                  // mean squared difference on the floor
    std::vector<double> misfit = {};  // at each height; empty: has not been asked
    std::size_t best = 0;
  };

  void add_block(const RigCamera& second_camera, int row0, int column0);
  bool choose_heights(double second_m);
  void find_in_second(const RigCamera& second_camera);
  double step_m() const { return heights_m_[1] - heights_m_[0]; }
  double mounting_sigma_m(const Block& block) const;
  std::vector<Seen> look(const Scan& scan) const;
  double misfit(const Seen& seen, std::ptrdiff_t height) const;
  double flat_of(const Seen& seen) const;
  void sweep(Seen& seen) const;
  bool agrees_once(const Seen& seen) const;
  void learn_mounting(const std::vector<Seen>& all);
  void learn_noise(const std::vector<Seen>& all);
  double noise(const Seen& seen) const;
  std::optional<UprightPoint> upright(const Seen& seen) const;

  std::shared_ptr<const FloorProjection> projection_;
  cv::Size floor_px_;
  cv::Size second_px_;
  std::vector<double> heights_m_;  // of even steps
  std::ptrdiff_t flat_ = 0;        // of them
  std::vector<Block> blocks_;
  std::vector<cv::Point2f> seen_px_;  // of each cell at each height; negative: not seen
  cv::Mat second_grey_;               // float, of this instant
  int instant_ = 0;
  // Of the second camera: by what its ranges look shorter, see SecondView::range_error().
  Vec3 error_ = Vec3::Zero();
  Mat3 error_covariance_ = Mat3::Zero();
  std::optional<double> floor_share_;  // of a floor's variance, that its two pictures differ by
};

}  // namespace panoptes
