// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_parallax.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include <Eigen/Dense>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr float kUnseen = -1;

// Where a pixel covers more of the floor, its texture is not seen well enough to tell how it moves:
// with 320 pixels from 1.2 m on for a lens of 110 degrees half a metre high, from 1.8 m for one
// of 80.
constexpr double kPixelMost_cells = 1.5;

constexpr int kColours = 3;              // Gaussians for what proved to be flat in one picture
constexpr std::size_t kBlockStride = 4;  // of a block's colours, those that are compared
constexpr double kAlike = 11.3;          // chi-square of three degrees, one in a hundred

// A block of one colour still has the camera's noise.
const Mat3 kNoise = 4 * Mat3::Identity();

// Residuals of neighbouring cells share their cause, so of a block's cells about a quarter are
// independent, and no block alone may decide.
constexpr double kIndependentShare = 0.25;
constexpr double kBlockLogOddsMax = 6;

// A texture's own interpolation error, as a share of its variance, where pictures are half a cell
// apart.
constexpr double kTextureError = 0.1;

// Alternatives nearer to the floor than this are not told from it.
constexpr double kApart_cells = 1.5;

// What has a floor's colour and slides stands up: by so many nats rather than lies flat, and at
// least so much better than at any other slide.
constexpr double kUprightLogOdds = 6;
constexpr double kSlideSigma_cells = 0.25;
constexpr double kSlideMost = 1.5;  // of the motion: things up to 0.6 of the camera's height

}  // namespace

void bind(Fields& f, FloorParallaxOptions& o) {
  f("cell_m", o.cell_m, between(0.005, 0.1));
  f("range_m", o.range_m, between(0.2, 5));
  f("step_m", o.step_m, between(0.01, 1));
  f("baseline_m", o.baseline_m, between(0.02, 1));
  f.angle("turn_max", o.turn_max_rad, between(0, 3));
  f("block", o.block, between(3, 32));
  f("fit_max", o.fit_max, between(1, 10));
  f("log_odds_floor", o.log_odds_floor, positive);
  f("group_min", o.group_min, at_least(1));
  f("pairs_min", o.pairs_min, at_least(1));
  f("upright_share_max", o.upright_share_max, between(0, 1));
  f("memory", o.memory, between(0, 1));
  f.renamed("reach_m", "range_m");
}

FloorParallax::FloorParallax(const FloorParallaxOptions& options,
                             std::shared_ptr<const FloorProjection> projection)
    : options_(options), projection_(std::move(projection)) {
  const FloorProjection& p = *projection_;
  origin_view_ = p.origin_view;
  columns_ =
      static_cast<int>(std::min(options_.range_m, p.cell_columns * p.cell_m) / options_.cell_m);
  rows_ = static_cast<int>(p.cell_rows * p.cell_m / options_.cell_m);
  const auto cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  sample_.assign(cells, -1);
  std::vector<int> pixels_in(cells, 0);
  // a cell that no sample of the scan falls into takes the one under it
  const auto width_rays = static_cast<std::size_t>(p.rays);
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const Vec2 at = options_.cell_m * Vec2(column + 0.5, row + 0.5) / p.cell_m;
      const auto c = static_cast<int>(at.x());
      const auto r = static_cast<int>(at.y());
      if (c < p.cell_columns && r < p.cell_rows) {
        const std::int32_t s =
            p.sample[static_cast<std::size_t>(r) * static_cast<std::size_t>(p.cell_columns) +
                     static_cast<std::size_t>(c)];
        if (s >= 0 &&
            p.depth_m[static_cast<std::size_t>(s)] <= kPixelMost_cells * options_.cell_m) {
          sample_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)] = s;
        }
      }
    }
  }
  std::vector<std::uint8_t> used(width_rays * static_cast<std::size_t>(p.rows), 0);
  for (int r = 0; r < p.cell_rows; ++r) {
    for (int c = 0; c < p.cell_columns; ++c) {
      const std::int32_t s =
          p.sample[static_cast<std::size_t>(r) * static_cast<std::size_t>(p.cell_columns) +
                   static_cast<std::size_t>(c)];
      const auto row = static_cast<int>((r + 0.5) * p.cell_m / options_.cell_m);
      const auto column = static_cast<int>((c + 0.5) * p.cell_m / options_.cell_m);
      if (s < 0 || column >= columns_ || row >= rows_) {
        continue;
      }
      const std::size_t cell = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                               static_cast<std::size_t>(column);
      if (sample_[cell] < 0) {
        continue;
      }
      pixel_.push_back(p.pixel[static_cast<std::size_t>(s)]);
      cell_.push_back(static_cast<std::int32_t>(cell));
      ++pixels_in[cell];
    }
  }
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (pixels_in[cell] == 0 && sample_[cell] >= 0) {
      pixel_.push_back(p.pixel[static_cast<std::size_t>(sample_[cell])]);
      cell_.push_back(static_cast<std::int32_t>(cell));
    }
  }
}

std::vector<float> FloorParallax::rectify(const cv::Mat& bgr) const {
  const auto cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  std::vector<float> sum(cells, 0);
  std::vector<std::int16_t> count(cells, 0);
  for (std::size_t i = 0; i < pixel_.size(); ++i) {
    const auto cell = static_cast<std::size_t>(cell_[i]);
    const std::uint8_t* p = bgr.data + 3 * static_cast<std::ptrdiff_t>(pixel_[i]);
    sum[cell] += static_cast<float>(p[0] + 2 * p[1] + p[2]);
    ++count[cell];
  }
  for (std::size_t cell = 0; cell < cells; ++cell) {
    sum[cell] = count[cell] > 0 ? sum[cell] / (4.0F * static_cast<float>(count[cell])) : kUnseen;
  }
  return sum;
}

struct FloorParallax::SeenCell {
  Vec2 p_before;  // in view of the earlier picture
  double grey;
  std::size_t sample;
};

struct FloorParallax::Earlier {
  const FloorParallax& parallax;
  const Rectified& before;
  Pose2 T_before_now;
  double baseline_m;  // driven by the camera since
  Vec2 slide;         // a cell along it

  Earlier(const FloorParallax& parallax_now, const Rectified& rectified, const Pose2& T_odom_view)
      : parallax(parallax_now),
        before(rectified),
        T_before_now(before.T_odom_view.inverse() * T_odom_view) {
    const Vec2 foot_before = T_before_now.inverse() * parallax.projection_->foot_view;
    const Vec2 baseline = parallax.projection_->foot_view - foot_before;  // in view now
    baseline_m = baseline.norm();
    slide = T_before_now.rotation() * baseline / baseline_m * parallax.options_.cell_m;
  }

  // The grey at a point; negative where nothing was seen.
  double grey(const Vec2& p_before) const {
    const int columns = parallax.columns_;
    const Vec2 at = (p_before - parallax.origin_view_) / parallax.options_.cell_m - Vec2(0.5, 0.5);
    const double column = std::floor(at.x());
    const double row = std::floor(at.y());
    if (!(column >= 0 && row >= 0 && column + 1 < columns && row + 1 < parallax.rows_)) {
      return kUnseen;
    }
    const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                          static_cast<std::size_t>(column);
    const float a = before.grey[i];
    const float b = before.grey[i + 1];
    const float c = before.grey[i + static_cast<std::size_t>(columns)];
    const float d = before.grey[i + static_cast<std::size_t>(columns) + 1];
    if (a < 0 || b < 0 || c < 0 || d < 0) {
      return kUnseen;
    }
    const double fx = at.x() - column;
    const double fy = at.y() - row;
    return (1 - fy) * ((1 - fx) * a + fx * b) + fy * ((1 - fx) * c + fx * d);
  }

  // Mean squared difference of cells from what was seen before so many cells farther along the
  // motion, their mean difference taken out.
  std::optional<double> mean_square(const std::vector<SeenCell>& cells, double shift_cells) const {
    double sum = 0;
    double square = 0;
    int count = 0;
    for (const SeenCell& cell : cells) {
      const double was = grey(cell.p_before + shift_cells * slide);
      if (was < 0) {
        continue;
      }
      const double d = cell.grey - was;
      sum += d;
      square += d * d;
      ++count;
    }
    if (count * 4 < static_cast<int>(cells.size()) * 3) {
      return std::nullopt;
    }
    return square / count - (sum / count) * (sum / count);
  }
};

struct FloorParallax::SeenBlock {
  std::vector<SeenCell> cells;
  Vec2 middle_view = Vec2::Zero();
  double flat = 0;  // mean squared difference as floor
};

struct FloorParallax::UnknownBlock {
  std::vector<SeenCell> cells;
  int row = 0;
  int column = 0;
  double lift_cells = 0;  // how far an upright object that begins at the first obstacle slides
};

struct FloorParallax::Sorted {
  std::vector<UnknownBlock> unknown;
  std::vector<SeenBlock> all;
  std::vector<double> floor;  // mean squared differences of blocks of a floor's colour
};

FloorParallax::Sorted FloorParallax::sort_blocks(const std::vector<float>& now,
                                                 const Earlier& earlier,
                                                 const std::vector<std::int8_t>& known,
                                                 const std::vector<std::int16_t>& first) const {
  const FloorProjection& p = *projection_;
  Sorted sorted;
  const int block = options_.block;
  for (int row0 = 0; row0 + block <= rows_; row0 += block) {
    for (int column0 = 0; column0 + block <= columns_; column0 += block) {
      SeenBlock alike;    // cells of a floor's colour, or
      SeenBlock strange;  // of none
      std::vector<SeenCell> floor;
      UnknownBlock unknown;
      double lift = 0;
      int others = 0;  // cells of no known colour
      for (int row = row0; row < row0 + block; ++row) {
        for (int column = column0; column < column0 + block; ++column) {
          const std::size_t cell =
              static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
              static_cast<std::size_t>(column);
          const std::int32_t s = sample_[cell];
          if (s < 0 || now[cell] < 0) {
            continue;
          }
          const auto i = static_cast<std::size_t>(s);
          const auto ray = i % static_cast<std::size_t>(p.rays);
          const auto sample_row = i / static_cast<std::size_t>(p.rays);
          const Vec2 at = origin_view_ + options_.cell_m * Vec2(column + 0.5, row + 0.5);
          const SeenCell here{earlier.T_before_now * at, now[cell], i};
          SeenBlock& side = known[i] > 0 ? alike : strange;
          side.cells.push_back(here);
          side.middle_view += at;
          if (static_cast<int>(sample_row) < first[ray]) {
            if (known[i] > 0) {
              floor.push_back(here);
            }
          } else {
            others += known[i] <= 0 ? 1 : 0;
            const double foot_range = static_cast<double>(
                p.range_m[static_cast<std::size_t>(first[ray]) * static_cast<std::size_t>(p.rays)]);
            lift += static_cast<double>(p.range_m[i]) / foot_range - 1;
            unknown.cells.push_back(here);
          }
        }
      }
      const auto enough = static_cast<std::size_t>(3 * block * block / 4);
      if (floor.size() >= enough) {
        if (const std::optional<double> flat = earlier.mean_square(floor, 0)) {
          sorted.floor.push_back(*flat);
        }
      }
      // what is partly floor shows two motions: the other part alone tells where it stands
      SeenBlock& side = alike.cells.size() >= enough ? alike : strange;
      if (side.cells.size() >= enough / 2) {
        if (const std::optional<double> flat = earlier.mean_square(side.cells, 0)) {
          side.flat = *flat;
          side.middle_view /= static_cast<double>(side.cells.size());
          sorted.all.push_back(std::move(side));
        }
      }
      if (unknown.cells.size() >= enough && 4 * others >= block * block) {
        unknown.lift_cells =
            lift / static_cast<double>(unknown.cells.size()) * earlier.baseline_m / options_.cell_m;
        if (unknown.lift_cells >= kApart_cells) {
          unknown.row = row0 / block;
          unknown.column = column0 / block;
          sorted.unknown.push_back(std::move(unknown));
        }
      }
    }
  }
  return sorted;
}

double FloorParallax::variance_of(const std::vector<SeenCell>& cells) {
  double sum = 0;
  double square = 0;
  for (const SeenCell& cell : cells) {
    sum += cell.grey;
    square += cell.grey * cell.grey;
  }
  const auto n = static_cast<double>(cells.size());
  return square / n - (sum / n) * (sum / n);
}

// The foot of what a block shows, where that stands up for certain.
std::optional<UprightPoint> FloorParallax::upright_at(const Earlier& earlier,
                                                      const SeenBlock& block,
                                                      const Pose2& T_odom_view) const {
  const double noise = std::max(*known_median_square_, kTextureError * variance_of(block.cells));
  const double fits = options_.fit_max * options_.fit_max * noise;
  const auto n = static_cast<double>(block.cells.size());
  const double enough = kUprightLogOdds * 2 * noise / (kIndependentShare * n);
  if (block.flat <= fits || block.flat <= enough) {
    return std::nullopt;
  }
  constexpr double kStep_cells = 0.5;
  const double most = kSlideMost * earlier.baseline_m / options_.cell_m;
  const int steps = static_cast<int>(std::floor(2 * most / kStep_cells));
  std::vector<double> misfit(static_cast<std::size_t>(steps) + 1, 1e12);
  std::size_t best = 0;
  for (std::size_t k = 0; k < misfit.size(); ++k) {
    const double shift = static_cast<double>(k) * kStep_cells - most;
    misfit[k] = earlier.mean_square(block.cells, shift).value_or(1e12);
    best = misfit[k] < misfit[best] ? k : best;
  }
  if (best == 0 || best + 1 == misfit.size() || misfit[best - 1] > 1e11 ||
      misfit[best + 1] > 1e11 || misfit[best] > fits || block.flat - misfit[best] < enough) {
    return std::nullopt;
  }
  // the least of a parabola through the best three
  const double below = misfit[best - 1] - misfit[best];
  const double above = misfit[best + 1] - misfit[best];
  const double between = below + above > 0 ? 0.5 * (below - above) / (below + above) : 0.0;
  const double slide_cells = (static_cast<double>(best) + between) * kStep_cells - most;
  if (slide_cells < kApart_cells) {
    return std::nullopt;
  }
  // a pattern that repeats itself, and what has none along the motion, fit elsewhere as well
  const auto apart = static_cast<std::size_t>(std::ceil(kApart_cells / kStep_cells));
  for (std::size_t k = 0; k < misfit.size(); ++k) {
    if ((k + apart < best || k > best + apart) && misfit[k] - misfit[best] < enough) {
      return std::nullopt;
    }
  }
  const double slide = slide_cells * options_.cell_m / earlier.baseline_m;
  const double share = 1 / (1 + slide);  // of the way from the camera to the floor
  const Vec2 sight = block.middle_view - projection_->foot_view;
  const double along_m =
      sight.norm() * share * share * kSlideSigma_cells * options_.cell_m / earlier.baseline_m;
  return UprightPoint{T_odom_view * (projection_->foot_view + share * sight),
                      projection_->height_m * (1 - share), std::hypot(along_m, options_.cell_m)};
}

// That a block is floor; 0 where nothing can be said.
double FloorParallax::log_odds_of(const Earlier& earlier, const UnknownBlock& unknown) const {
  const std::optional<double> flat = earlier.mean_square(unknown.cells, 0);
  const std::optional<double> back = earlier.mean_square(unknown.cells, -kApart_cells);
  if (!flat || !back) {
    return 0;
  }
  double upright = 1e12;
  const double highest = std::min(1.5 * unknown.lift_cells, 16.0);
  for (double shift = kApart_cells; shift <= highest; shift += shift < 4 ? 0.5 : 1.0) {
    if (const std::optional<double> m = earlier.mean_square(unknown.cells, shift)) {
      upright = std::min(upright, *m);
    }
  }
  if (upright > 1e11) {
    return 0;
  }
  const auto n = static_cast<double>(unknown.cells.size());
  const double noise = std::max(*known_mean_square_, kTextureError * variance_of(unknown.cells));
  double log_odds = kIndependentShare * n * (upright - *flat) / (2 * noise);
  if (log_odds > 0) {
    const double fit_max = options_.fit_max * options_.fit_max;
    const double worse_back = kIndependentShare * n * (*back - *flat) / (2 * noise);
    // the floor must also fit by itself, and better than what lies under it
    log_odds = *flat <= fit_max * noise ? std::min(log_odds, std::max(worse_back, 0.0)) : 0;
  }
  return std::clamp(log_odds, -kBlockLogOddsMax, kBlockLogOddsMax);
}

std::vector<FloorParallax::Block> FloorParallax::judge(
    const cv::Mat& bgr, const std::vector<float>& now, const Rectified& before,
    const Pose2& T_odom_view, const std::vector<std::int8_t>& known,
    const std::vector<std::int16_t>& first, std::vector<UprightPoint>& upright) {
  const Earlier earlier(*this, before, T_odom_view);
  Sorted sorted = sort_blocks(now, earlier, known, first);
  if (sorted.floor.size() >= 3) {
    const double sum = std::accumulate(sorted.floor.begin(), sorted.floor.end(), 0.0);
    known_mean_square_ = std::max(sum / static_cast<double>(sorted.floor.size()), 1.0);
    const auto middle = sorted.floor.begin() + static_cast<std::ptrdiff_t>(sorted.floor.size() / 2);
    std::nth_element(sorted.floor.begin(), middle, sorted.floor.end());
    known_median_square_ = std::max(*middle, 1.0);
  }
  std::vector<Block> blocks;
  if (!known_mean_square_) {
    return blocks;  // nothing has said yet how well the floor itself agrees
  }
  for (const SeenBlock& block : sorted.all) {
    if (const std::optional<UprightPoint> point = upright_at(earlier, block, T_odom_view)) {
      upright.push_back(*point);
    }
  }
  for (const UnknownBlock& unknown : sorted.unknown) {
    const double log_odds = log_odds_of(earlier, unknown);
    if (log_odds == 0) {
      continue;
    }
    std::vector<Bgr> colours;
    for (const SeenCell& cell : unknown.cells) {
      const std::uint8_t* c =
          bgr.data + 3 * static_cast<std::ptrdiff_t>(projection_->pixel[cell.sample]);
      colours.push_back({c[0], c[1], c[2]});
    }
    blocks.push_back({unknown.row, unknown.column, log_odds, std::move(colours)});
  }
  return blocks;
}

FloorParallax::Learned FloorParallax::learn(const cv::Mat& bgr, const Pose2& T_odom_view,
                                            const std::vector<std::int8_t>& known,
                                            const std::vector<std::int16_t>& first) {
  if (!past_.empty()) {
    const Vec2 moved = T_odom_view.position() - past_.back().T_odom_view.position();
    if (moved.norm() < options_.step_m) {
      return {};
    }
  }
  Rectified now{T_odom_view, rectify(bgr)};
  const Rectified* before = nullptr;
  double best = 0.5 * options_.baseline_m;  // how far from the wanted baseline it may be
  for (const Rectified& r : past_) {
    const Pose2 T_then_now = r.T_odom_view.inverse() * T_odom_view;
    const double off = std::abs(T_then_now.position().norm() - options_.baseline_m);
    if (off <= best && std::abs(T_then_now.theta_rad) <= options_.turn_max_rad) {
      best = off;
      before = &r;
    }
  }
  Learned learned;
  std::vector<Block> blocks;
  if (before != nullptr) {
    blocks = judge(bgr, now.grey, *before, T_odom_view, known, first, learned.upright);
  }
  past_.push_back(std::move(now));
  while (past_.size() > 12) {
    past_.pop_front();
  }

  drop_scattered(blocks);
  learned.floors = weigh(blocks);
  return learned;
}

void FloorParallax::drop_scattered(std::vector<Block>& blocks) const {
  // A floor is flat over a wide place; here and there a block of an object looks flat by chance.
  const int columns = columns_ / options_.block + 1;
  const int rows = rows_ / options_.block + 1;
  std::vector<int> group(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), -1);
  const auto at = [&](int row, int column) -> int& {
    return group[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                 static_cast<std::size_t>(column)];
  };
  constexpr int kFlat = 0;  // not yet in a group
  for (const Block& block : blocks) {
    at(block.row, block.column) = block.floor_log_odds > 0 ? kFlat : -1;
  }
  std::vector<int> sizes{0};
  std::vector<std::pair<int, int>> open;
  for (const Block& block : blocks) {
    if (at(block.row, block.column) != kFlat) {
      continue;
    }
    const auto number = static_cast<int>(sizes.size());
    sizes.push_back(0);
    const auto visit = [&](int row, int column) {
      if (row >= 0 && column >= 0 && row < rows && column < columns && at(row, column) == kFlat) {
        at(row, column) = number;
        ++sizes.back();
        open.emplace_back(row, column);
      }
    };
    visit(block.row, block.column);
    while (!open.empty()) {
      const auto [row, column] = open.back();
      open.pop_back();
      visit(row + 1, column);
      visit(row - 1, column);
      visit(row, column + 1);
      visit(row, column - 1);
    }
  }
  std::erase_if(blocks, [&](const Block& block) {
    return block.floor_log_odds > 0 &&
           sizes[static_cast<std::size_t>(at(block.row, block.column))] < options_.group_min;
  });
}

std::vector<ColourGaussian> FloorParallax::weigh(const std::vector<Block>& blocks) {
  if (blocks.empty()) {
    return {};
  }
  // the colours of what lies on the floor here
  std::vector<Bgr> flat;
  for (const Block& block : blocks) {
    if (block.floor_log_odds > 1) {
      flat.insert(flat.end(), block.colours.begin(), block.colours.end());
    }
  }
  std::vector<std::uint8_t> spoke(candidates_.size(), 0);
  for (const ColourGaussian& g : fit_colours(flat, kColours)) {
    std::size_t nearest = candidates_.size();
    double least = 1;  // Eq. 6.4
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const ColourGaussian& c = candidates_[i].colour;
      const Vec3 d = c.mean - g.mean;
      const double distance = d.dot((c.covariance + g.covariance + kNoise).ldlt().solve(d));
      if (distance <= least) {
        least = distance;
        nearest = i;
      }
    }
    if (nearest == candidates_.size()) {
      candidates_.push_back({g, 0, 0, 0});
      spoke.push_back(1);
    } else {
      ColourGaussian& c = candidates_[nearest].colour;  // Eq. 6.5
      const double sum = c.mass + g.mass;
      c.mean = (c.mass * c.mean + g.mass * g.mean) / sum;
      c.covariance = (c.mass * c.covariance + g.mass * g.covariance) / sum;
      c.mass = sum;
      spoke[nearest] = 1;
    }
  }
  // Every block speaks for or against a colour by the share of it that has the colour. What was
  // said fades, for furniture of a floor's colour elsewhere says nothing of the floor here.
  std::vector<ColourGaussian> proved;
  std::vector<Candidate> kept;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    Candidate& c = candidates_[i];
    c.floor_log_odds *= options_.memory;
    c.upright_log_odds *= options_.memory;
    c.colour.mass *= options_.memory;
    const Mat3 information = (c.colour.covariance + kNoise).inverse();
    for (const Block& block : blocks) {
      int alike = 0;
      int asked = 0;
      for (std::size_t k = 0; k < block.colours.size(); k += kBlockStride) {
        const Bgr& colour = block.colours[k];
        const Vec3 d = Vec3(colour[0], colour[1], colour[2]) - c.colour.mean;
        alike += d.dot(information * d) < kAlike ? 1 : 0;
        ++asked;
      }
      (block.floor_log_odds > 0 ? c.floor_log_odds : c.upright_log_odds) +=
          std::abs(block.floor_log_odds) * alike / asked;
    }
    c.pairs += spoke[i];
    const double all = c.floor_log_odds + c.upright_log_odds;
    if (c.floor_log_odds >= options_.log_odds_floor && c.pairs >= options_.pairs_min &&
        c.upright_log_odds <= options_.upright_share_max * all) {
      proved.push_back(c.colour);
    } else if (c.floor_log_odds > 1) {
      kept.push_back(std::move(c));
    }
  }
  candidates_ = std::move(kept);
  return proved;
}

}  // namespace panoptes
