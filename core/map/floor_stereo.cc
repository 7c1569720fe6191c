// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_stereo.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/geometry/pose3.h"

namespace panoptes {
namespace {

constexpr double kCell_m = 0.02;
constexpr int kBlock = 6;                 // cells to a side
constexpr double kRange_m = 1.6;          // from the nearest mapped floor
constexpr double kPixelMost_cells = 1.5;  // a pixel covers
constexpr double kVague_m = 0.1;          // of height, that shifts the picture by a cell
constexpr std::size_t kLeastBlocks = 6;

// Heights that are tried: they shift the picture by half a cell each where that is most.
constexpr double kStep_cells = 0.5;
constexpr double kApart_cells = 1.5;  // nearer ones are not told from each other
constexpr std::size_t kLeastHeights = 8;
constexpr double kHighest = 0.7;    // of the lower camera's height
constexpr double kLowest_m = 0.03;  // under where the floor seems to be at the lowest,
constexpr double kSigmas = 2;       // by what is not known of the second camera

// Of greys, evened out over 3 x 3 pixels.
constexpr double kNoise = 2.5;   // mean squared difference of what has no texture
constexpr double kTextured = 6;  // variance, at least
constexpr double kAgree = 0.35;  // of the variance, the two pictures differ by at most
constexpr double kWorse = 2;     // times, they differ at any other height

// What a floor shows of the second camera's mounting.
constexpr double kTogether_m = 0.04;  // of the median height of all; roll tells them apart
constexpr double kGate = 9;           // three sigmas, squared
constexpr double kFlatShare = 0.7;    // of all that agree are floor, or there is none
constexpr int kTurns = 4;             // one in so many blocks is asked each time, whatever it shows

// Of a floor's variance, that its two pictures differ by: by interpolation at least; more, and
// they are not of the same.
constexpr double kFloorLeast = 0.02;
constexpr double kFloorMost = 0.2;

constexpr double kIndependentShare = 0.25;  // of neighbouring cells
constexpr double kUprightLogOdds = 6;
constexpr double kSigma_cells = 0.5;  // of what a block shows

constexpr double kUnknown = 1e12;

// As the floor camera would show it, evened out over neighbours.
cv::Mat grey_of(const cv::Mat& bgr, const Levels* levels) {
  cv::Mat grey(bgr.rows, bgr.cols, CV_32F);
  for (int y = 0; y < bgr.rows; ++y) {
    const auto* from = bgr.ptr<std::uint8_t>(y);
    auto* to = grey.ptr<float>(y);
    for (int x = 0; x < bgr.cols; ++x, from += 3) {
      to[x] = levels != nullptr
                  ? 0.25F * static_cast<float>((*levels)[0][from[0]] + 2 * (*levels)[1][from[1]] +
                                               (*levels)[2][from[2]])
                  : 0.25F * static_cast<float>(from[0] + 2 * from[1] + from[2]);
    }
  }
  cv::blur(grey, grey, {3, 3});
  return grey;
}

}  // namespace

std::optional<FloorStereo> FloorStereo::of(std::shared_ptr<const FloorProjection> projection,
                                           const Intrinsics& floor_lens,
                                           const RigCamera& second_camera) {
  FloorStereo stereo;
  stereo.projection_ = std::move(projection);
  stereo.floor_px_ = {floor_lens.width_px, floor_lens.height_px};
  stereo.second_px_ = {second_camera.intrinsics.width_px, second_camera.intrinsics.height_px};
  const FloorProjection& p = *stereo.projection_;
  const double second_m = second_camera.T_body_camera.translation.z();
  if (!(second_m > 0.05)) {
    return std::nullopt;
  }
  const double tilt_rad =
      std::max(second_camera.sigma.rotation_rad.x(), second_camera.sigma.rotation_rad.y());
  stereo.error_covariance_ = Vec3(second_camera.sigma.position_m.z() / second_m, tilt_rad, tilt_rad)
                                 .cwiseAbs2()
                                 .asDiagonal();
  const int columns = static_cast<int>(std::min(kRange_m, p.cell_columns * p.cell_m) / kCell_m);
  const int rows = static_cast<int>(p.cell_rows * p.cell_m / kCell_m);
  for (int row0 = 0; row0 + kBlock <= rows; row0 += kBlock) {
    for (int column0 = 0; column0 + kBlock <= columns; column0 += kBlock) {
      stereo.add_block(second_camera, row0, column0);
    }
  }
  if (stereo.blocks_.empty() || !stereo.choose_heights(second_m)) {
    return std::nullopt;
  }
  stereo.find_in_second(second_camera);
  if (stereo.blocks_.size() < kLeastBlocks) {
    return std::nullopt;
  }
  return stereo;
}

// A block whose height the two cameras would tell: where they stand over other places of the floor
// as well, there are some whose height changes nothing.
void FloorStereo::add_block(const RigCamera& second_camera, int row0, int column0) {
  const FloorProjection& p = *projection_;
  Block block;
  Vec2 middle_view = Vec2::Zero();
  for (int k = 0; k < kBlock * kBlock; ++k) {
    const Vec2 at = kCell_m / p.cell_m * Vec2(column0 + k % kBlock + 0.5, row0 + k / kBlock + 0.5);
    const auto column = static_cast<int>(at.x());
    const auto row = static_cast<int>(at.y());
    if (column >= p.cell_columns || row >= p.cell_rows) {
      continue;
    }
    const std::int32_t sample = p.sample[static_cast<std::size_t>(row * p.cell_columns + column)];
    const auto i = static_cast<std::size_t>(std::max(sample, 0));
    if (sample < 0 || p.pixel[i] < 0 ||
        static_cast<double>(p.depth_m[i]) > kPixelMost_cells * kCell_m) {
      continue;
    }
    const Vec3 view =
        p.H_view_px * Vec3(p.pixel[i] % floor_px_.width, p.pixel[i] / floor_px_.width, 1);
    block.cells.push_back({sample, p.pixel[i], view.hnormalized(), 0});
    middle_view += view.hnormalized();
  }
  if (block.cells.size() * 4 < static_cast<std::size_t>(kBlock * kBlock) * 3) {
    return;
  }
  middle_view /= static_cast<double>(block.cells.size());
  const Vec2 sight = middle_view - p.foot_view;
  const Vec3& second = second_camera.T_body_camera.translation;
  const Vec2 from_second = middle_view - p.T_body_view.inverse() * Vec2(second.head<2>());
  // So far does a point move over the floor in the second picture, by its height.
  const Vec2 slide = from_second / second.z() - sight / p.height_m;
  block.cell_height_m = kCell_m / slide.norm();
  if (!(block.cell_height_m < kVague_m)) {
    return;
  }
  const double range_m = from_second.norm();
  const double by_angle_m = (range_m * range_m + second.z() * second.z()) / second.z();
  block.by_error =
      -from_second.dot(slide) / (range_m * slide.squaredNorm()) *
      Vec3(range_m, by_angle_m * from_second.x() / range_m, by_angle_m * from_second.y() / range_m);
  blocks_.push_back(std::move(block));
}

// As far apart as the block shows that tells heights best.
bool FloorStereo::choose_heights(double second_m) {
  double step_m = kVague_m;
  double sigma_m = 0;
  for (const Block& block : blocks_) {
    step_m = std::min(step_m, kStep_cells * block.cell_height_m);
    sigma_m = std::max(sigma_m, mounting_sigma_m(block));
  }
  const double lowest_m = std::min(kLowest_m + kSigmas * sigma_m, 0.5 * projection_->height_m);
  const double highest_m = kHighest * std::min(projection_->height_m, second_m);
  flat_ = std::lround(lowest_m / step_m);
  for (std::ptrdiff_t k = 0; step_m * static_cast<double>(k - flat_) < highest_m; ++k) {
    heights_m_.push_back(step_m * static_cast<double>(k - flat_));
  }
  return heights_m_.size() >= kLeastHeights;
}

// Where the second camera would see each cell, along the floor camera's line of sight.
void FloorStereo::find_in_second(const RigCamera& second_camera) {
  const FloorProjection& p = *projection_;
  const Intrinsics& lens = second_camera.intrinsics;
  const Pose3 T_second_body = second_camera.T_body_camera.inverse();
  const auto in_body = [&](const Vec2& p_view, double z_m) {
    const Vec2 p_body = p.T_body_view * p_view;
    return Vec3(p_body.x(), p_body.y(), z_m);
  };
  const Vec3 floor_camera = in_body(p.foot_view, p.height_m);
  for (Block& block : blocks_) {
    std::erase_if(block.cells, [&](Cell& cell) {
      const Vec3 on_floor = in_body(cell.p_view, 0);
      cell.seen = seen_px_.size();
      bool is_seen = false;
      for (const double z_m : heights_m_) {
        const Vec3 x =
            T_second_body * Vec3(on_floor + z_m / p.height_m * (floor_camera - on_floor));
        cv::Point2f px(-1, -1);
        if (lens.sees(x)) {
          const Vec2 exact = lens.project(x);
          px = {static_cast<float>(exact.x()), static_cast<float>(exact.y())};
        }
        if (!(px.x >= 0 && px.y >= 0 && px.x < static_cast<float>(lens.width_px - 1) &&
              px.y < static_cast<float>(lens.height_px - 1))) {
          px = {-1, -1};
        }
        seen_px_.push_back(px);
        is_seen = is_seen || px.x >= 0;
      }
      if (!is_seen) {
        seen_px_.resize(cell.seen);
      }
      return !is_seen;
    });
  }
  std::erase_if(blocks_, [](const Block& block) {
    return block.cells.size() * 4 < static_cast<std::size_t>(kBlock * kBlock) * 3;
  });
}

// How high the block seems to lie, by what is not known of the second camera.
double FloorStereo::mounting_sigma_m(const Block& block) const {
  return std::sqrt(std::max(0.0, block.by_error.dot(error_covariance_ * block.by_error)));
}

// The blocks that look like floor and have a texture.
std::vector<FloorStereo::Seen> FloorStereo::look(const Scan& scan) const {
  const std::int32_t rays = projection_->rays;
  const cv::Mat floor_grey = grey_of(scan.bgr, nullptr);
  std::vector<Seen> all;
  for (const Block& block : blocks_) {
    Seen seen;
    seen.block = &block;
    seen.is_floor = true;
    double sum = 0;
    double square = 0;
    for (const Cell& cell : block.cells) {
      if (scan.floor[static_cast<std::size_t>(cell.sample)] <= 0) {
        continue;
      }
      const float grey = floor_grey.ptr<float>()[cell.pixel];
      seen.pairs.push_back({grey, cell.seen});
      seen.sight_view += cell.p_view - projection_->foot_view;
      sum += static_cast<double>(grey);
      square += static_cast<double>(grey * grey);
      seen.is_floor = seen.is_floor &&
                      cell.sample / rays < scan.first[static_cast<std::size_t>(cell.sample % rays)];
    }
    const auto n = static_cast<double>(seen.pairs.size());
    if (n * 2 < kBlock * kBlock) {
      continue;
    }
    seen.sight_view /= n;
    seen.variance = square / n - (sum / n) * (sum / n);
    if (seen.variance < kTextured) {
      continue;
    }
    seen.flat = flat_of(seen);
    if (seen.flat < kUnknown) {
      all.push_back(std::move(seen));
    }
  }
  return all;
}

// Mean squared difference of the two pictures, if what they show has this height, their mean
// difference taken out.
double FloorStereo::misfit(const Seen& seen, std::ptrdiff_t height) const {
  double sum = 0;
  double square = 0;
  int count = 0;
  for (const Pair& pair : seen.pairs) {
    const cv::Point2f& px = seen_px_[pair.seen + static_cast<std::size_t>(height)];
    if (px.x < 0) {
      continue;
    }
    const int x = static_cast<int>(px.x);
    const int y = static_cast<int>(px.y);
    const float fx = px.x - static_cast<float>(x);
    const float fy = px.y - static_cast<float>(y);
    const float* a = second_grey_.ptr<float>(y) + x;
    const float* b = second_grey_.ptr<float>(y + 1) + x;
    const auto d = static_cast<double>(pair.grey - (1 - fy) * ((1 - fx) * a[0] + fx * a[1]) -
                                       fy * ((1 - fx) * b[0] + fx * b[1]));
    sum += d;
    square += d * d;
    ++count;
  }
  return count * 4 < static_cast<int>(seen.pairs.size()) * 3
             ? kUnknown
             : square / count - (sum / count) * (sum / count);
}

double FloorStereo::flat_of(const Seen& seen) const {
  const std::ptrdiff_t k = flat_ + std::lround(seen.block->by_error.dot(error_) / step_m());
  double least = kUnknown;
  for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, k - 1);
       i <= k + 1 && i < static_cast<std::ptrdiff_t>(heights_m_.size()); ++i) {
    least = std::min(least, misfit(seen, i));
  }
  return least;
}

// From where the floor may be, at the lowest.
void FloorStereo::sweep(Seen& seen) const {
  const double lowest_m =
      seen.block->by_error.dot(error_) - kLowest_m - kSigmas * mounting_sigma_m(*seen.block);
  const auto from = std::lower_bound(heights_m_.begin(), heights_m_.end(), lowest_m);
  seen.misfit.assign(heights_m_.size(), kUnknown);
  for (auto k = static_cast<std::size_t>(from - heights_m_.begin()); k < heights_m_.size(); ++k) {
    seen.misfit[k] = misfit(seen, static_cast<std::ptrdiff_t>(k));
    seen.best = seen.misfit[k] < seen.misfit[seen.best] ? k : seen.best;
  }
}

// A pattern that repeats itself, and what has none across the heights, agree elsewhere as well.
bool FloorStereo::agrees_once(const Seen& seen) const {
  const std::vector<double>& all = seen.misfit;
  const std::size_t best = seen.best;
  if (all.empty() || best == 0 || best + 1 == all.size() || all[best - 1] >= kUnknown ||
      all[best + 1] >= kUnknown || all[best] > kNoise + kAgree * seen.variance) {
    return false;
  }
  const double apart_m = kApart_cells * seen.block->cell_height_m;
  const auto apart = static_cast<std::size_t>(std::lround(apart_m / step_m()));
  for (std::size_t k = 0; k < all.size(); ++k) {
    if ((k + apart < best || k > best + apart) && all[k] < kWorse * (all[best] + kNoise)) {
      return false;
    }
  }
  return true;
}

// By the floor, which is flat: where the two pictures agree by chance they do so at any height.
void FloorStereo::learn_mounting(const std::vector<Seen>& all) {
  const auto variance_of = [&](const Block& block) {
    return std::pow(mounting_sigma_m(block), 2) + std::pow(kSigma_cells * block.cell_height_m, 2);
  };
  const auto off_m_of = [&](const Seen& seen) {
    return heights_m_[seen.best] - seen.block->by_error.dot(error_);
  };
  std::vector<const Seen*> flat;
  std::vector<double> offs_m;
  for (const Seen& seen : all) {
    if (seen.is_floor && agrees_once(seen)) {
      flat.push_back(&seen);
      offs_m.push_back(off_m_of(seen));
    }
  }
  const std::size_t agreeing = flat.size();
  if (agreeing < kLeastBlocks) {
    return;
  }
  const auto middle = offs_m.begin() + static_cast<std::ptrdiff_t>(agreeing / 2);
  std::nth_element(offs_m.begin(), middle, offs_m.end());
  std::erase_if(flat, [&](const Seen* seen) {
    const double off_m = off_m_of(*seen);
    return std::abs(off_m - *middle) > kTogether_m ||
           off_m * off_m > kGate * variance_of(*seen->block);
  });
  if (static_cast<double>(flat.size()) < kFlatShare * static_cast<double>(agreeing)) {
    return;
  }
  for (const Seen* seen : flat) {
    const Vec3& f = seen->block->by_error;
    const double variance = variance_of(*seen->block);
    const double off_m = off_m_of(*seen);
    const Vec3 gain = error_covariance_ * f / variance;
    error_ += gain * off_m;
    error_covariance_ -= gain * (error_covariance_ * f).transpose();
  }
}

void FloorStereo::learn_noise(const std::vector<Seen>& all) {
  std::vector<double> shares;
  for (const Seen& seen : all) {
    if (seen.is_floor) {
      shares.push_back(std::max(0.0, seen.flat - kNoise) / seen.variance);
    }
  }
  if (shares.size() >= kLeastBlocks) {
    const auto middle = shares.begin() + static_cast<std::ptrdiff_t>(shares.size() / 2);
    std::nth_element(shares.begin(), middle, shares.end());
    floor_share_ = std::max(*middle, kFloorLeast);
  }
}

double FloorStereo::noise(const Seen& seen) const { return kNoise + *floor_share_ * seen.variance; }

std::optional<UprightPoint> FloorStereo::upright(const Seen& seen) const {
  const double enough = kUprightLogOdds * 2 * noise(seen) /
                        (kIndependentShare * static_cast<double>(seen.pairs.size()));
  if (!agrees_once(seen) || seen.flat - seen.misfit[seen.best] < enough) {
    return std::nullopt;
  }
  const Block& block = *seen.block;
  const double height_m = heights_m_[seen.best] - block.by_error.dot(error_);
  const double sigma_m = std::hypot(kSigma_cells * block.cell_height_m, mounting_sigma_m(block));
  if (height_m < std::max(kApart_cells * block.cell_height_m, std::sqrt(kGate) * sigma_m)) {
    return std::nullopt;
  }
  const double share = 1 - height_m / projection_->height_m;  // of the way to the floor
  const double along_m = seen.sight_view.norm() * sigma_m / projection_->height_m;
  return UprightPoint{projection_->foot_view + share * seen.sight_view, height_m,
                      std::hypot(along_m, kCell_m)};
}

std::vector<UprightPoint> FloorStereo::find(const Scan& scan, const cv::Mat& second_bgr,
                                            const Levels& levels, const Pose2& T_odom_view) {
  PANOPTES_CHECK(scan.bgr.type() == CV_8UC3 && scan.bgr.size() == floor_px_ &&
                     second_bgr.type() == CV_8UC3 && second_bgr.size() == second_px_,
                 "both pictures are 8-bit BGR of the size that the rig says");
  second_grey_ = grey_of(second_bgr, &levels);
  ++instant_;
  std::vector<Seen> all = look(scan);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool has_turn = (static_cast<int>(i) + instant_) % kTurns == 0;
    if (!floor_share_ || has_turn || all[i].flat > noise(all[i])) {
      sweep(all[i]);
    }
  }
  learn_mounting(all);
  learn_noise(all);
  const bool is_usable = floor_share_ && *floor_share_ <= kFloorMost;
  std::vector<UprightPoint> found;
  for (const Seen& seen : all) {
    if (const std::optional<UprightPoint> point = is_usable ? upright(seen) : std::nullopt) {
      found.push_back({T_odom_view * point->p_odom, point->height_m, point->sigma_m});
    }
  }
  return found;
}

}  // namespace panoptes
