// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/similarity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <fmt/format.h>

#include "core/camera/mounting.h"
#include "core/geometry/cross_matrix.h"

namespace panoptes {
namespace {

constexpr int kRounds = 10;  // of least squares by those that agree
// Three points tell a similarity as far as they lie apart.
constexpr double kApartSigmas = 3;
constexpr double kMostStretch = 1.5;  // of one side of a triangle against another
constexpr double kMissed = 1e-4;      // the share of searches that may miss the best

using Triple = std::array<std::size_t, 3>;

/// How far off a pair is, in a, and how well that is known.
Vec3 off(const Similarity& S_a_b, const PointPair& pair) { return pair.in_a - S_a_b * pair.in_b; }

Mat3 off_covariance(const Similarity& S_a_b, const PointPair& pair) {
  const Mat3 by_b = S_a_b.scale * S_a_b.rotation.toRotationMatrix();
  return pair.covariance_a + by_b * pair.covariance_b * by_b.transpose();
}

double off_squared_sigmas(const Similarity& S_a_b, const PointPair& pair) {
  const Vec3 e = off(S_a_b, pair);
  return e.dot(off_covariance(S_a_b, pair).ldlt().solve(e));
}

double sigma(const Mat3& covariance) { return std::sqrt(covariance.trace() / 3); }

/// Twice the area over the longest side: the least that three points lie apart by.
double least_width(const Vec3& p, const Vec3& q, const Vec3& r) {
  const double longest = std::max({(q - p).norm(), (r - q).norm(), (p - r).norm()});
  return longest > 0 ? (q - p).cross(r - p).norm() / longest : 0;
}

/// The search among one set of pairs.
class Search {
 public:
  Search(const SimilarityOptions& options, const std::vector<PointPair>& pairs)
      : options_(options), pairs_(pairs) {
    for (const PointPair& pair : pairs) {
      sigma_a_.push_back(sigma(pair.covariance_a));
      sigma_b_.push_back(sigma(pair.covariance_b));
    }
  }

  AgreedSimilarity run(Rng rng) const {
    AgreedSimilarity best;
    const int count = static_cast<int>(pairs_.size());
    int draws = options_.draws;
    for (int draw = 0; draw < draws; ++draw) {
      const Triple three{static_cast<std::size_t>(rng.index(count)),
                         static_cast<std::size_t>(rng.index(count)),
                         static_cast<std::size_t>(rng.index(count))};
      const std::optional<Similarity> S_a_b = told_by(three);
      if (!S_a_b) {
        continue;
      }
      std::vector<std::size_t> agree = agreeing(*S_a_b);
      if (agree.size() > best.agree.size()) {
        best.S_a_b = *S_a_b;
        best.agree = std::move(agree);
        draws = std::min(draws, needed(best.agree.size()));
      }
    }
    return best;
  }

  /// By all that agree, each by how well it is known.
  void adjust(AgreedSimilarity& best) const {
    for (int round = 0; round < kRounds && best.agree.size() >= 3; ++round) {
      SimilarityCovariance information = SimilarityCovariance::Zero();
      SimilarityOffset gradient = SimilarityOffset::Zero();
      double squared = 0;
      for (const std::size_t i : best.agree) {
        const Vec3 q = best.S_a_b * pairs_[i].in_b;
        Eigen::Matrix<double, 3, 7> J;
        J << -cross_matrix(q), Mat3::Identity(), q;
        const Eigen::LDLT<Mat3> C(off_covariance(best.S_a_b, pairs_[i]));
        const Vec3 e = off(best.S_a_b, pairs_[i]);
        information += J.transpose() * C.solve(J);
        gradient += J.transpose() * C.solve(e);
        squared += e.dot(C.solve(e));
      }
      const Eigen::LDLT<SimilarityCovariance> solver(information);
      best.S_a_b = moved(best.S_a_b, solver.solve(gradient));
      const double left = static_cast<double>(3 * best.agree.size()) - 7;
      best.sigmas = std::sqrt(squared / static_cast<double>(3 * best.agree.size()));
      // Points of a map are off together: what is left tells more than each for itself.
      best.covariance = solver.solve(SimilarityCovariance::Identity()) *
                        std::max(1.0, left > 0 ? squared / left : 1.0);
      std::vector<std::size_t> agree = agreeing(best.S_a_b);
      if (agree.size() < best.agree.size() && round > kRounds / 2) {
        break;  // to and fro about a pair
      }
      best.agree = std::move(agree);
    }
  }

 private:
  std::optional<Similarity> told_by(const Triple& t) const {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      return std::nullopt;
    }
    const PointPair& p = pairs_[t[0]];
    const PointPair& q = pairs_[t[1]];
    const PointPair& r = pairs_[t[2]];
    const std::array<double, 3> stretch{(q.in_a - p.in_a).norm() / (q.in_b - p.in_b).norm(),
                                        (r.in_a - q.in_a).norm() / (r.in_b - q.in_b).norm(),
                                        (p.in_a - r.in_a).norm() / (p.in_b - r.in_b).norm()};
    const auto [least, most] = std::minmax_element(stretch.begin(), stretch.end());
    const auto largest = [&t](const std::vector<double>& sigmas) {
      return std::max({sigmas[t[0]], sigmas[t[1]], sigmas[t[2]]});
    };
    if (!(*most < kMostStretch * *least) ||
        least_width(p.in_a, q.in_a, r.in_a) < kApartSigmas * largest(sigma_a_) ||
        least_width(p.in_b, q.in_b, r.in_b) < kApartSigmas * largest(sigma_b_)) {
      return std::nullopt;
    }
    std::optional<Similarity> S_a_b =
        fitted_similarity({p.in_a, q.in_a, r.in_a}, {p.in_b, q.in_b, r.in_b});
    const bool agree = S_a_b && std::all_of(t.begin(), t.end(), [&](std::size_t i) {
                         return off_squared_sigmas(*S_a_b, pairs_[i]) < options_.gate;
                       });
    return agree ? S_a_b : std::nullopt;
  }

  std::vector<std::size_t> agreeing(const Similarity& S_a_b) const {
    std::vector<std::size_t> agree;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (off_squared_sigmas(S_a_b, pairs_[i]) < options_.gate) {
        agree.push_back(i);
      }
    }
    return agree;
  }

  /// Draws after which three of so many that agree were drawn together, most likely.
  int needed(std::size_t agree) const {
    const double share = static_cast<double>(agree) / static_cast<double>(pairs_.size());
    const double missed = 1 - share * share * share;
    return missed <= 0
               ? 1
               : static_cast<int>(std::min(static_cast<double>(options_.draws),
                                           std::ceil(std::log(kMissed) / std::log(missed))));
  }

  const SimilarityOptions& options_;
  const std::vector<PointPair>& pairs_;
  std::vector<double> sigma_a_;
  std::vector<double> sigma_b_;
};

std::vector<PointPair> shuffled(std::vector<PointPair> pairs, Rng rng) {
  for (std::size_t i = pairs.size() - 1; i > 0; --i) {
    // Not with itself: none keeps its partner (Sattolo 1986).
    PointPair& other = pairs[static_cast<std::size_t>(rng.index(static_cast<int>(i)))];
    std::swap(pairs[i].in_b, other.in_b);
    std::swap(pairs[i].covariance_b, other.covariance_b);
  }
  return pairs;
}

}  // namespace

Similarity Similarity::inverse() const {
  const Eigen::Quaterniond back = rotation.conjugate();
  return {1 / scale, back, back * translation / -scale};
}

Similarity operator*(const Similarity& S_a_b, const Similarity& S_b_c) {
  return {S_a_b.scale * S_b_c.scale, (S_a_b.rotation * S_b_c.rotation).normalized(),
          S_a_b * S_b_c.translation};
}

Vec3 operator*(const Similarity& S_a_b, const Vec3& p_b) {
  return S_a_b.scale * (S_a_b.rotation * p_b) + S_a_b.translation;
}

Pose3 operator*(const Similarity& S_a_b, const Pose3& T_b_camera) {
  return {(S_a_b.rotation * T_b_camera.rotation).normalized(), S_a_b * T_b_camera.translation};
}

Similarity moved(const Similarity& S_a_b, const SimilarityOffset& by) {
  return Similarity{std::exp(by[6]), turned_by(by.head<3>()), by.segment<3>(3)} * S_a_b;
}

SimilarityOffset offset_of(const Similarity& S) {
  const Eigen::AngleAxisd turn(S.rotation);
  SimilarityOffset offset;
  offset << turn.angle() * turn.axis(), S.translation, std::log(S.scale);
  return offset;
}

SimilarityCovariance adjoint(const Similarity& S_a_b) {
  const Mat3 R = S_a_b.rotation.toRotationMatrix();
  SimilarityCovariance by = SimilarityCovariance::Zero();
  by.topLeftCorner<3, 3>() = R;
  by.block<3, 3>(3, 0) = cross_matrix(S_a_b.translation) * R;
  by.block<3, 3>(3, 3) = S_a_b.scale * R;
  by.block<3, 1>(3, 6) = -S_a_b.translation;
  by(6, 6) = 1;
  return by;
}

std::optional<Similarity> fitted_similarity(const std::vector<Vec3>& in_a,
                                            const std::vector<Vec3>& in_b) {
  const auto count = static_cast<double>(in_a.size());
  Vec3 middle_a = Vec3::Zero();
  Vec3 middle_b = Vec3::Zero();
  for (std::size_t i = 0; i < in_a.size(); ++i) {
    middle_a += in_a[i] / count;
    middle_b += in_b[i] / count;
  }
  Mat3 sum = Mat3::Zero();
  double spread_b = 0;
  for (std::size_t i = 0; i < in_a.size(); ++i) {
    sum += (in_a[i] - middle_a) * (in_b[i] - middle_b).transpose();
    spread_b += (in_b[i] - middle_b).squaredNorm();
  }
  constexpr double kLine = 1e-9;
  const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vec3 D = svd.singularValues();
  if (in_a.size() < 3 || !(D[1] > kLine * D[0])) {
    return std::nullopt;
  }
  const Vec3 signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  Similarity S_a_b;
  S_a_b.rotation =
      Eigen::Quaterniond(Mat3(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose()));
  S_a_b.scale = D.dot(signs) / spread_b;
  S_a_b.translation = middle_a - S_a_b.scale * (S_a_b.rotation * middle_b);
  return S_a_b;
}

AgreedSimilarity agreed_similarity(const SimilarityOptions& options,
                                   const std::vector<PointPair>& pairs, Rng rng) {
  if (pairs.size() < std::max<std::size_t>(3, options.fewest)) {
    AgreedSimilarity none;
    none.fault = fmt::format("{} points look alike in both, fewer than the {} that must agree",
                             pairs.size(), options.fewest);
    return none;
  }
  const Search search(options, pairs);
  AgreedSimilarity best = search.run(rng.fork("draws"));
  search.adjust(best);
  for (int i = 0; i < options.shuffles; ++i) {
    const Rng of_shuffle = rng.fork("shuffle " + std::to_string(i));
    const std::vector<PointPair> false_pairs = shuffled(pairs, of_shuffle.fork("partners"));
    best.by_chance = std::max(
        best.by_chance, Search(options, false_pairs).run(of_shuffle.fork("draws")).agree.size());
  }
  if (best.agree.size() < options.fewest ||
      static_cast<double>(best.agree.size()) <
          options.by_chance * static_cast<double>(best.by_chance)) {
    best.fault = fmt::format(
        "of {} points that look alike in both {} agree on how the maps lie, where at least {} must "
        "and {} do by chance",
        pairs.size(), best.agree.size(), options.fewest, best.by_chance);
  }
  return best;
}

}  // namespace panoptes
