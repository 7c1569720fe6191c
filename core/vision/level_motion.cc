// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/level_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

namespace panoptes {
namespace {

constexpr int kSample = 3;

// The matrix is (0 f0 0; f1 0 f2; 0 f3 0): a pair agrees where
//   y_a (f0 x_b + f3) + y_b (f1 x_a + f2) = 0.
Eigen::Vector4f through(const std::array<PixelPair, kSample>& pairs) {
  Eigen::Matrix<float, kSample, 4> rows;
  for (int i = 0; i < kSample; ++i) {
    const Eigen::Vector2f& a = pairs[i].a_px;
    const Eigen::Vector2f& b = pairs[i].b_px;
    rows.row(i) << a.y() * b.x(), b.y() * a.x(), b.y(), a.y();
  }
  Eigen::Vector4f f;  // across all rows, by their minors
  for (int left_out = 0; left_out < 4; ++left_out) {
    Eigen::Matrix3f minor;
    for (int column = 0, to = 0; column < 4; ++column) {
      if (column != left_out) {
        minor.col(to++) = rows.col(column);
      }
    }
    f[left_out] = (left_out % 2 == 0 ? 1.0F : -1.0F) * minor.determinant();
  }
  return f;
}

// Sampson's distance; and what is above the horizon stays there.
bool agrees(const Eigen::Vector4f& f, const PixelPair& pair, float noise_squared) {
  const Eigen::Vector2f& a = pair.a_px;
  const Eigen::Vector2f& b = pair.b_px;
  const float of_a = f[0] * b.x() + f[3];
  const float of_b = f[1] * a.x() + f[2];
  const float off = a.y() * of_a + b.y() * of_b;
  const float across_a = f[1] * b.y();
  const float across_b = f[0] * a.y();
  const float slope_squared = of_a * of_a + of_b * of_b + across_a * across_a + across_b * across_b;
  return of_a * of_b < 0 && off * off < noise_squared * slope_squared;
}

// The share of wrong matches, each point with the partner of another one, that agree as well: up to
// kOthers partners a point, so that the many cost no more than the motions that were tried.
double agreeing_by_chance(const Eigen::Vector4f& f, const std::vector<PixelPair>& pairs,
                          float noise_squared) {
  constexpr std::size_t kOthers = 20;
  const std::size_t count = pairs.size();
  const std::size_t others = std::min(kOthers, count - 1);
  std::size_t agreeing = 0;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 1; k <= others; ++k) {
      const std::size_t other = (i + k * (count - 1) / others) % count;
      agreeing += agrees(f, {pairs[i].a_px, pairs[other].b_px}, noise_squared) ? 1U : 0U;
    }
  }
  // one more than counted: nothing is known to be impossible
  return static_cast<double>(agreeing + 1) / static_cast<double>(count * others + 1);
}

double log_choose(int n, int k) {
  return std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0);
}

// Of `count` pairs `inliers` agree, one by chance with probability p: the number of sizes, of sets
// so large and of samples in them that the motion may come from, times that the others agree.
double log_false_alarms(int count, int inliers, double p) {
  return std::log(count - kSample) + log_choose(count, inliers) + log_choose(inliers, kSample) +
         (inliers - kSample) * std::log(p);
}

}  // namespace

int level_inliers(const LevelMotionOptions& options, const std::vector<PixelPair>& pairs, Rng rng) {
  return level_agreement(options, pairs, rng).inliers;
}

LevelAgreement level_agreement(const LevelMotionOptions& options,
                               const std::vector<PixelPair>& pairs, Rng rng) {
  const int count = static_cast<int>(pairs.size());
  if (count <= kSample) {
    return {};
  }
  // numbers near one, so that the minors are exact enough in single precision
  float scale = 1;
  for (const PixelPair& pair : pairs) {
    scale = std::max({scale, pair.a_px.cwiseAbs().maxCoeff(), pair.b_px.cwiseAbs().maxCoeff()});
  }
  std::vector<PixelPair> scaled;
  scaled.reserve(pairs.size());
  for (const PixelPair& pair : pairs) {
    scaled.push_back({pair.a_px / scale, pair.b_px / scale});
  }
  const float noise = static_cast<float>(options.noise_px) / scale;
  int most = 0;
  Eigen::Vector4f best = Eigen::Vector4f::Zero();
  for (int hypothesis = 0; hypothesis < options.hypotheses; ++hypothesis) {
    const std::array<int, kSample> drawn{rng.index(count), rng.index(count), rng.index(count)};
    if (drawn[0] == drawn[1] || drawn[0] == drawn[2] || drawn[1] == drawn[2]) {
      continue;
    }
    const Eigen::Vector4f f = through({scaled[drawn[0]], scaled[drawn[1]], scaled[drawn[2]]});
    const auto agreeing = std::count_if(scaled.begin(), scaled.end(), [&](const PixelPair& pair) {
      return agrees(f, pair, noise * noise);
    });
    if (agreeing > most) {
      most = static_cast<int>(agreeing);
      best = f;
    }
  }
  LevelAgreement agreement{most, 0, {}};
  for (int i = 0; i < count; ++i) {
    if (agrees(best, scaled[i], noise * noise)) {
      agreement.agreeing.push_back(i);
    }
  }
  if (most > kSample) {
    const double p = agreeing_by_chance(best, scaled, noise * noise);
    agreement.log_chance = log_false_alarms(count, most, p);
  }
  return agreement;
}

}  // namespace panoptes
