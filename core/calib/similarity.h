// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/rng.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// A similarity of space (thesis 4.4), as it lies between maps that have no metre:
/// `S_a_b * p_b = p_a = scale * (rotation * p_b) + translation`.
struct Similarity {
  double scale = 1;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Vec3 translation = Vec3::Zero();

  Similarity inverse() const;
};

Similarity operator*(const Similarity& S_a_b, const Similarity& S_b_c);
Vec3 operator*(const Similarity& S_a_b, const Vec3& p_b);
/// A camera of map b as map a has it.
Pose3 operator*(const Similarity& S_a_b, const Pose3& T_b_camera);

/// How a similarity is off: a small turn (rad), a shift (in units of a) and the logarithm of a
/// factor, all about the origin of the frame that it takes points to.
using SimilarityOffset = Eigen::Matrix<double, 7, 1>;
using SimilarityCovariance = Eigen::Matrix<double, 7, 7>;

/// The similarity that is off by so much.
Similarity moved(const Similarity& S_a_b, const SimilarityOffset& by);
/// By how much it is off the identity.
SimilarityOffset offset_of(const Similarity& S);
/// How an offset in b looks in a.
SimilarityCovariance adjoint(const Similarity& S_a_b);

/// The similarity that takes points of b to those of a by least squares (Horn 1987, Umeyama 1991).
/// Empty where they lie on a line, or in one place.
std::optional<Similarity> fitted_similarity(const std::vector<Vec3>& in_a,
                                            const std::vector<Vec3>& in_b);

/// A point in two maps, and how well each knows it.
struct PointPair {
  Vec3 in_a = Vec3::Zero();
  Vec3 in_b = Vec3::Zero();
  Mat3 covariance_a = Mat3::Zero();
  Mat3 covariance_b = Mat3::Zero();
};

struct SimilarityOptions {
  int draws = 20000;
  /// Squared sigmas by which a true pair may be off: 99 % of them are less, by chi-squared of 3.
  double gate = 11.345;
  std::size_t fewest = 8;  ///< pairs that agree on one
  int shuffles = 3;        ///< of partners, to see how many agree by chance
  double by_chance = 1.5;  ///< so many times as many must agree
};

/// Which similarity most pairs agree on.
struct AgreedSimilarity {
  Similarity S_a_b;
  SimilarityCovariance covariance = SimilarityCovariance::Zero();  ///< of its offset in a
  std::vector<std::size_t> agree;  ///< the pairs that it takes to one another, in order
  std::size_t by_chance = 0;       ///< so many agree where partners are shuffled
  double sigmas = 0;               ///< rms by which these pairs are off, each way
  std::string fault;               ///< why it is not to be trusted, in words; empty where it is
};

/// RANSAC (Fischler and Bolles 1981; thesis 4.3.5): three pairs drawn at random tell a similarity,
/// the one that most pairs agree with is adjusted by all of these. How far a pair may be off is
/// what its points are known to. The same search among shuffled partners tells how many false pairs
/// agree by chance: what agrees no better is no similarity.
AgreedSimilarity agreed_similarity(const SimilarityOptions& options,
                                   const std::vector<PointPair>& pairs, Rng rng);

}  // namespace panoptes
