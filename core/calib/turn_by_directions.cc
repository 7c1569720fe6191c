// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/turn_by_directions.h"

#include <algorithm>
#include <utility>

#include <Eigen/SVD>

namespace panoptes {
namespace {

constexpr int kDraws = 500;
constexpr int kRounds = 5;  // of least squares by those that agree

Eigen::Quaterniond fitted(const std::vector<DirectionPair>& pairs,
                          const std::vector<std::size_t>& by) {
  Mat3 sum = Mat3::Zero();
  for (const std::size_t i : by) {
    sum += pairs[i].in_a * pairs[i].in_b.transpose();
  }
  const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return Eigen::Quaterniond(
      Mat3(svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose()));
}

bool agrees(const DirectionPair& pair, const Eigen::Quaterniond& R_a_b) {
  return (R_a_b * pair.in_b - pair.in_a).norm() < pair.tolerance_rad;
}

std::vector<std::size_t> agreeing(const std::vector<DirectionPair>& pairs,
                                  const Eigen::Quaterniond& R_a_b) {
  std::vector<std::size_t> agree;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (agrees(pairs[i], R_a_b)) {
      agree.push_back(i);
    }
  }
  return agree;
}

}  // namespace

std::optional<TurnByDirections> turn_by_directions(const std::vector<DirectionPair>& pairs,
                                                   std::size_t fewest, Rng rng) {
  if (pairs.size() < std::max<std::size_t>(2, fewest)) {
    return std::nullopt;
  }
  TurnByDirections best;
  const int count = static_cast<int>(pairs.size());
  for (int draw = 0; draw < kDraws; ++draw) {
    const std::vector<std::size_t> two{static_cast<std::size_t>(rng.index(count)),
                                       static_cast<std::size_t>(rng.index(count))};
    const Eigen::Quaterniond R_a_b = fitted(pairs, two);
    // Two that contradict one another, or are the same, tell no turn.
    if (two[0] == two[1] || !agrees(pairs[two[0]], R_a_b) || !agrees(pairs[two[1]], R_a_b)) {
      continue;
    }
    std::vector<std::size_t> agree = agreeing(pairs, R_a_b);
    if (agree.size() > best.agree.size()) {
      best = {R_a_b, std::move(agree)};
    }
  }
  for (int round = 0; round < kRounds && best.agree.size() >= 2; ++round) {
    best.R_a_b = fitted(pairs, best.agree);
    best.agree = agreeing(pairs, best.R_a_b);
  }
  return best.agree.size() >= std::max<std::size_t>(2, fewest)
             ? std::optional<TurnByDirections>(std::move(best))
             : std::nullopt;
}

}  // namespace panoptes
