// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_colour.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "core/base/check.h"

namespace panoptes {
namespace {

// ln of the uniform obstacle density over all colours
const double kUniform = -3 * std::log(256.0);

Mat3 with_floor(const Mat3& covariance, double sigma_min) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(covariance);
  const Vec3 values = eigen.eigenvalues().cwiseMax(sigma_min * sigma_min);
  return eigen.eigenvectors() * values.asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace

Mat3 shaded(const ColourGaussian& floor, double shade) {
  return floor.covariance + shade * shade * floor.mean * floor.mean.transpose();
}

void bind(Fields& f, FloorColourOptions& o) {
  f("learned_max", o.learned_max, between(1, 32));
  f("trained", o.trained, between(1, 16));
  f("shade", o.shade, between(0, 1));
  f("sigma_min_grey", o.sigma_min_grey, between(0.5, 50));
  f("prior_log_odds", o.prior_log_odds, between(-20, 20));
  f("mass_max", o.mass_max, at_least(100));
  f("mass_half_life_s", o.mass_half_life_s, positive);
  f.renamed("mass_decay", "mass_half_life_s");
  f("vote_share", o.vote_share, between(0, 1));
}

std::vector<ColourGaussian> fit_colours(std::span<const Bgr> colours, int clusters) {
  PANOPTES_CHECK(clusters >= 1, "colours are fitted by one Gaussian at least");
  if (colours.size() < 8) {
    return {};
  }
  // the start: means of equal shares in order of brightness
  std::vector<std::uint32_t> order(256, 0);
  for (const Bgr& c : colours) {
    ++order[(c[0] + 2U * c[1] + c[2]) / 4U];
  }
  std::vector<std::uint8_t> share_of(256);
  std::size_t below = 0;
  for (std::size_t level = 0; level < 256; ++level) {
    share_of[level] = static_cast<std::uint8_t>(std::min<std::size_t>(
        static_cast<std::size_t>(clusters) - 1,
        (below + order[level] / 2) * static_cast<std::size_t>(clusters) / colours.size()));
    below += order[level];
  }
  struct Sum {
    std::int64_t count = 0;
    std::array<std::int64_t, 3> first{};
    std::array<std::int64_t, 6> second{};
  };
  std::vector<std::array<int, 3>> mean(static_cast<std::size_t>(clusters));
  std::vector<Sum> sums;
  constexpr int kRounds = 4;  // the clusters serve a density, not a partition: they need not settle
  for (int round = 0; round <= kRounds; ++round) {
    sums.assign(static_cast<std::size_t>(clusters), {});
    for (const Bgr& c : colours) {
      std::size_t best = 0;
      if (round == 0) {
        best = share_of[(c[0] + 2U * c[1] + c[2]) / 4U];
      } else {
        int best_distance = 1 << 30;
        for (std::size_t j = 0; j < mean.size(); ++j) {
          const int b = c[0] * 16 - mean[j][0];
          const int g = c[1] * 16 - mean[j][1];
          const int r = c[2] * 16 - mean[j][2];
          const int distance = b * b + g * g + r * r;
          if (distance < best_distance) {
            best_distance = distance;
            best = j;
          }
        }
      }
      Sum& s = sums[best];
      ++s.count;
      s.first[0] += c[0];
      s.first[1] += c[1];
      s.first[2] += c[2];
      if (round == kRounds) {
        const std::int64_t blue = c[0];
        const std::int64_t green = c[1];
        const std::int64_t red = c[2];
        s.second[0] += blue * blue;
        s.second[1] += blue * green;
        s.second[2] += blue * red;
        s.second[3] += green * green;
        s.second[4] += green * red;
        s.second[5] += red * red;
      }
    }
    for (std::size_t j = 0; j < mean.size(); ++j) {
      if (sums[j].count > 0) {
        for (std::size_t a = 0; a < 3; ++a) {
          mean[j][a] = static_cast<int>(16 * sums[j].first[a] / sums[j].count);
        }
      } else {
        mean[j] = {1 << 13, 1 << 13, 1 << 13};  // out of everybody's reach
      }
    }
  }
  std::vector<ColourGaussian> out;
  for (const Sum& s : sums) {
    if (s.count < 8 || s.count * 50 < static_cast<std::int64_t>(colours.size())) {
      continue;
    }
    const auto n = static_cast<double>(s.count);
    ColourGaussian g;
    g.mass = n;
    g.mean = Vec3(static_cast<double>(s.first[0]), static_cast<double>(s.first[1]),
                  static_cast<double>(s.first[2])) /
             n;
    Mat3 m;
    m << static_cast<double>(s.second[0]), static_cast<double>(s.second[1]),
        static_cast<double>(s.second[2]), static_cast<double>(s.second[1]),
        static_cast<double>(s.second[3]), static_cast<double>(s.second[4]),
        static_cast<double>(s.second[2]), static_cast<double>(s.second[4]),
        static_cast<double>(s.second[5]);
    g.covariance = m / n - g.mean * g.mean.transpose();
    out.push_back(g);
  }
  return out;
}

FloorColour::FloorColour(const FloorColourOptions& options, double learn_every_s)
    : options_(options),
      mass_decay_(std::exp2(-learn_every_s / options.mass_half_life_s)),
      table_(std::size_t{1} << 18, kEmpty) {}

void FloorColour::learn(const std::vector<ColourGaussian>& trained) {
  for (ColourGaussian& g : learned_) {
    g.mass *= mass_decay_;
  }
  for (ColourGaussian t : trained) {
    t.covariance = with_floor(t.covariance, options_.sigma_min_grey);
    ColourGaussian* nearest = nullptr;
    double least = 1;  // Eq. 6.4
    for (ColourGaussian& g : learned_) {
      // with the grant for shading, as they vote: a carpet and its shadows are one floor
      const Vec3 d = g.mean - t.mean;
      const Mat3 spread = shaded(g, options_.shade) + shaded(t, options_.shade);
      const double distance = d.dot(spread.ldlt().solve(d));
      if (distance <= least) {
        least = distance;
        nearest = &g;
      }
    }
    if (nearest != nullptr) {
      ColourGaussian& g = *nearest;
      const double sum = g.mass + t.mass;
      g.mean = (g.mass * g.mean + t.mass * t.mean) / sum;
      g.covariance = with_floor((g.mass * g.covariance + t.mass * t.covariance) / sum,
                                options_.sigma_min_grey);
      g.mass = std::min(sum, options_.mass_max);
      continue;
    }
    if (static_cast<int>(learned_.size()) < options_.learned_max) {
      learned_.push_back(t);
      continue;
    }
    const auto lightest = std::min_element(
        learned_.begin(), learned_.end(),
        [](const ColourGaussian& a, const ColourGaussian& b) { return a.mass < b.mass; });
    if (lightest->mass < t.mass) {
      *lightest = t;
    }
  }
  refresh();
}

void FloorColour::adopt(ColourGaussian floor) {
  for (const ColourGaussian& g : learned_) {
    floor.mass = std::max(floor.mass, 0.5 * g.mass);
  }
  learn({floor});
}

void FloorColour::refresh() {
  double heaviest = 0;
  for (const ColourGaussian& g : learned_) {
    heaviest = std::max(heaviest, g.mass);
  }
  std::vector<ColourGaussian> voters;
  double total = 0;
  for (const ColourGaussian& g : learned_) {
    if (g.mass >= options_.vote_share * heaviest) {
      voters.push_back(g);
      total += g.mass;
    }
  }
  // The table is kept while no voter has changed by what a table's bin of four grey levels shows.
  bool same = voters.size() == voted_with_.size();
  for (std::size_t i = 0; same && i < voters.size(); ++i) {
    const ColourGaussian& a = voters[i];
    const ColourGaussian& b = voted_with_[i];
    same = (a.mean - b.mean).cwiseAbs().maxCoeff() < 0.5 &&
           (a.covariance - b.covariance).cwiseAbs().maxCoeff() < 0.1 * b.covariance.trace() &&
           a.mass < 2 * b.mass && b.mass < 2 * a.mass;
  }
  if (same) {
    return;
  }
  votes_.clear();
  for (const ColourGaussian& g : voters) {
    const Mat3 covariance = shaded(g, options_.shade);
    votes_.push_back({g.mean, covariance.inverse(),
                      std::log(g.mass / total) - 1.5 * std::log(2 * std::numbers::pi) -
                          0.5 * std::log(covariance.determinant())});
  }
  voted_with_ = std::move(voters);
  std::fill(table_.begin(), table_.end(), kEmpty);
}

double FloorColour::log_ratio(const Vec3& bgr) const {
  if (votes_.empty()) {
    return options_.prior_log_odds;
  }
  double most = -1e9;
  for (const Vote& vote : votes_) {
    const Vec3 d = bgr - vote.mean;
    most = std::max(most, vote.log_weight - 0.5 * d.dot(vote.information * d));
  }
  double sum = 0;
  for (const Vote& vote : votes_) {
    const Vec3 d = bgr - vote.mean;
    sum += std::exp(vote.log_weight - 0.5 * d.dot(vote.information * d) - most);
  }
  return most + std::log(sum) - kUniform + options_.prior_log_odds;
}

std::int8_t FloorColour::fill(std::size_t index) {
  // the middle of the bin
  const Vec3 bgr(4.0 * static_cast<double>(index >> 12) + 1.5,
                 4.0 * static_cast<double>((index >> 6) & 63) + 1.5,
                 4.0 * static_cast<double>(index & 63) + 1.5);
  const auto v = static_cast<std::int8_t>(std::lround(
      std::clamp(8 * log_ratio(bgr), -static_cast<double>(kClip), static_cast<double>(kClip))));
  table_[index] = v;
  return v;
}

}  // namespace panoptes
