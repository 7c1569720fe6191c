// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/config/fields.h"
#include "core/map/floor_colour.h"
#include "core/map/floor_projection.h"
#include "core/map/upright_points.h"

namespace panoptes {

struct FloorParallaxOptions {
  double cell_m = 0.02;  ///< of the rectified pictures that are compared
  double range_m = 1.6;  ///< from the nearest mapped floor, and no farther than pixels are small
  double step_m = 0.04;  ///< a rectified picture is kept this often
  double baseline_m = 0.16;        ///< pictures this far apart are compared
  double turn_max_rad = 0.5;       ///< and turned by no more than this
  int block = 6;                   ///< cells to a side that are judged together
  double fit_max = 2.0;            ///< rms difference allowed, in those of known floor
  double log_odds_floor = 60;      ///< summed ln P(floor)/P(upright) that makes a colour a floor
  int group_min = 6;               ///< blocks that must lie together to be floor
  int pairs_min = 3;               ///< pictures that must have said so
  double upright_share_max = 0.3;  ///< of the votes that may have spoken against
  double memory = 0.9;             ///< of the votes that is kept from one picture to the next
};
void bind(Fields& f, FloorParallaxOptions& o);

/// Tells floors and upright objects of the same colour by how their texture moves: seen from two
/// places, the floor's points keep their place on the floor, while those of an object at height z
/// slide along the motion by z / (height - z) of it. So other floors are learned, and things of a
/// known floor's colour found. What has no texture along the motion, and a turn on the spot, say
/// nothing.
class FloorParallax {
 public:
  FloorParallax(const FloorParallaxOptions& options,
                std::shared_ptr<const FloorProjection> projection);

  struct Learned {
    std::vector<ColourGaussian> floors;  ///< colours that have proved to be floor
    std::vector<UprightPoint> upright;   ///< feet of what this picture shows
  };

  /// `known`: the scan's smoothed colour ratio; `first`: the first obstacle's row along each ray.
  Learned learn(const cv::Mat& bgr, const Pose2& T_odom_view, const std::vector<std::int8_t>& known,
                const std::vector<std::int16_t>& first);

 private:
  struct Rectified {
    Pose2 T_odom_view;
    std::vector<float> grey;  // negative where nothing is seen
  };
  struct Block {
    int row = 0;  // in blocks
    int column = 0;
    double floor_log_odds = 0;  // negative: upright
    std::vector<Bgr> colours;
  };
  struct Candidate {
    ColourGaussian colour;
    double floor_log_odds = 0;  // what the last half metre said of this colour
    double upright_log_odds = 0;
    int pairs = 0;
  };

  std::vector<float> rectify(const cv::Mat& bgr) const;
  void drop_scattered(std::vector<Block>& blocks) const;
  std::vector<ColourGaussian> weigh(const std::vector<Block>& blocks);
  std::vector<Block> judge(const cv::Mat& bgr, const std::vector<float>& now,
                           const Rectified& before, const Pose2& T_odom_view,
                           const std::vector<std::int8_t>& known,
                           const std::vector<std::int16_t>& first,
                           std::vector<UprightPoint>& upright);

  struct SeenCell;      // of now
  struct Earlier;       // the picture that is compared with
  struct SeenBlock;     // of any colour
  struct UnknownBlock;  // may be floor or not
  struct Sorted;        // blocks
  std::optional<UprightPoint> upright_at(const Earlier& earlier, const SeenBlock& block,
                                         const Pose2& T_odom_view) const;
  Sorted sort_blocks(const std::vector<float>& now, const Earlier& earlier,
                     const std::vector<std::int8_t>& known,
                     const std::vector<std::int16_t>& first) const;
  static double variance_of(const std::vector<SeenCell>& cells);  // of their grey
  double log_odds_of(const Earlier& earlier, const UnknownBlock& unknown) const;

  FloorParallaxOptions options_;
  std::shared_ptr<const FloorProjection> projection_;
  int columns_ = 0;
  int rows_ = 0;
  Vec2 origin_view_ = Vec2::Zero();
  std::vector<std::int32_t> pixel_;   // mapped pixels and
  std::vector<std::int32_t> cell_;    // the cell each falls into
  std::vector<std::int32_t> sample_;  // the scan's sample at each cell's centre, -1 outside
  // Mean squared differences of blocks of known floor, as last seen: their mean, and their median,
  // which things of its colour do not change.
  std::optional<double> known_mean_square_;
  std::optional<double> known_median_square_;
  std::deque<Rectified> past_;
  std::vector<Candidate> candidates_;
};

}  // namespace panoptes
