// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/saddle.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace panoptes {
namespace {

constexpr int kNumbers = 13;
using Numbers = Eigen::Matrix<double, kNumbers, 1>;

/// What the numbers are. Lengths in pixels, light in grey levels.
enum Number {
  kX,
  kY,
  kAngleA,  // of an edge
  kAngleB,
  kCurveA,  // of an edge, 1 / px
  kCurveB,
  kBlurA,  // standard deviation across an edge
  kBlurB,
  kMean,    // of black and white
  kHalf,    // of what lies between them, of the quarter left of both edges
  kSlopeX,  // of the light, as a share of it
  kSlopeY,
  kTwist,  // of the light along both: a share
};

struct Edge {
  double step = 0;  // -1 to 1 across it
  double by_across = 0;
  double across_px = 0;
  double along_px = 0;
  double blur_px = 1;
};

Edge edge_at(const Vec2& d, double angle_rad, double curve_per_px, double blur_px) {
  Edge edge;
  const Vec2 along(std::cos(angle_rad), std::sin(angle_rad));
  edge.along_px = along.dot(d);
  const double straight_px = along.x() * d.y() - along.y() * d.x();
  edge.across_px = straight_px - 0.5 * curve_per_px * edge.along_px * edge.along_px;
  edge.blur_px = blur_px;
  const double u = edge.across_px / (std::numbers::sqrt2 * blur_px);
  edge.step = std::erf(u);
  edge.by_across =
      std::exp(-u * u) * 2 * std::numbers::inv_sqrtpi / (std::numbers::sqrt2 * blur_px);
  return edge;
}

/// How the edge's step changes with its angle, curve, blur and with where it passes.
struct EdgeSlopes {
  double angle = 0;
  double curve = 0;
  double blur = 0;
  Vec2 place = Vec2::Zero();
};

EdgeSlopes slopes_of(const Edge& edge, double angle_rad, double curve_per_px) {
  const Vec2 along(std::cos(angle_rad), std::sin(angle_rad));
  const Vec2 across(-along.y(), along.x());
  const double straight_px = edge.across_px + 0.5 * curve_per_px * edge.along_px * edge.along_px;
  const Vec2 by_d = across - curve_per_px * edge.along_px * along;
  return {edge.by_across * (-edge.along_px - curve_per_px * edge.along_px * straight_px),
          edge.by_across * -0.5 * edge.along_px * edge.along_px,
          edge.by_across * -edge.across_px / edge.blur_px, -edge.by_across * by_d};
}

struct Pixel {
  Vec2 px;
  double grey = 0;
};

std::vector<Pixel> pixels_about(const cv::Mat& grey, const Vec2& centre_px, double radius_px) {
  std::vector<Pixel> pixels;
  const int low_x = std::max(0, static_cast<int>(std::ceil(centre_px.x() - radius_px)));
  const int low_y = std::max(0, static_cast<int>(std::ceil(centre_px.y() - radius_px)));
  const int high_x =
      std::min(grey.cols - 1, static_cast<int>(std::floor(centre_px.x() + radius_px)));
  const int high_y =
      std::min(grey.rows - 1, static_cast<int>(std::floor(centre_px.y() + radius_px)));
  for (int y = low_y; y <= high_y; ++y) {
    const std::uint8_t* row = grey.ptr<std::uint8_t>(y);
    for (int x = low_x; x <= high_x; ++x) {
      if ((Vec2(x, y) - centre_px).squaredNorm() <= radius_px * radius_px) {
        pixels.push_back({Vec2(x, y), static_cast<double>(row[x])});
      }
    }
  }
  return pixels;
}

/// Sum of squares, and where it is asked for the normal equations.
double misfit(const std::vector<Pixel>& pixels, const Vec2& middle_px, const Numbers& n,
              Eigen::Matrix<double, kNumbers, kNumbers>* A, Numbers* g) {
  double sum = 0;
  for (const Pixel& pixel : pixels) {
    const Vec2 d = pixel.px - Vec2(n[kX], n[kY]);
    const Edge a = edge_at(d, n[kAngleA], n[kCurveA], n[kBlurA]);
    const Edge b = edge_at(d, n[kAngleB], n[kCurveB], n[kBlurB]);
    const Vec2 off = pixel.px - middle_px;
    const double light =
        1 + n[kSlopeX] * off.x() + n[kSlopeY] * off.y() + n[kTwist] * off.x() * off.y();
    const double shade = n[kMean] + n[kHalf] * a.step * b.step;
    const double residual = shade * light - pixel.grey;
    sum += residual * residual;
    if (A == nullptr) {
      continue;
    }
    const EdgeSlopes by_a = slopes_of(a, n[kAngleA], n[kCurveA]);
    const EdgeSlopes by_b = slopes_of(b, n[kAngleB], n[kCurveB]);
    const double of_a = light * n[kHalf] * b.step;
    const double of_b = light * n[kHalf] * a.step;
    Numbers J;
    J << of_a * by_a.place.x() + of_b * by_b.place.x(),
        of_a * by_a.place.y() + of_b * by_b.place.y(), of_a * by_a.angle, of_b * by_b.angle,
        of_a * by_a.curve, of_b * by_b.curve, of_a * by_a.blur, of_b * by_b.blur, light,
        light * a.step * b.step, shade * off.x(), shade * off.y(), shade * off.x() * off.y();
    A->noalias() += J * J.transpose();
    g->noalias() += residual * J;
  }
  return sum;
}

}  // namespace

std::optional<Vec2> fit_saddle(const cv::Mat& grey, const Vec2& guess_px, const Vec2& a_px,
                               const Vec2& b_px, double radius_px, double farthest_px) {
  constexpr double kFirstBlur_px = 0.8;
  constexpr double kSharpest_px = 0.2;
  constexpr double kMostCurved_per_px = 0.05;
  constexpr int kMostSteps = 20;
  constexpr double kStill_px = 1e-4;
  constexpr int kFewestPixels = 2 * kNumbers;
  const std::vector<Pixel> pixels = pixels_about(grey, guess_px, radius_px);
  if (static_cast<int>(pixels.size()) < kFewestPixels) {
    return std::nullopt;
  }
  Numbers n;
  n << guess_px.x(), guess_px.y(), std::atan2(a_px.y(), a_px.x()), std::atan2(b_px.y(), b_px.x()),
      0, 0, kFirstBlur_px, kFirstBlur_px, 0, 0, 0, 0, 0;
  // black and white by the pixels themselves
  double sum = 0;
  double signed_sum = 0;
  for (const Pixel& pixel : pixels) {
    const Vec2 d = pixel.px - guess_px;
    sum += pixel.grey;
    signed_sum += pixel.grey * edge_at(d, n[kAngleA], 0, kFirstBlur_px).step *
                  edge_at(d, n[kAngleB], 0, kFirstBlur_px).step;
  }
  n[kMean] = sum / static_cast<double>(pixels.size());
  n[kHalf] = signed_sum / static_cast<double>(pixels.size());
  double cost = misfit(pixels, guess_px, n, nullptr, nullptr);
  double damping = 1e-3;
  bool converged = false;
  for (int step = 0; step < kMostSteps && !converged; ++step) {
    Eigen::Matrix<double, kNumbers, kNumbers> A = Eigen::Matrix<double, kNumbers, kNumbers>::Zero();
    Numbers g = Numbers::Zero();
    misfit(pixels, guess_px, n, &A, &g);
    bool better = false;
    for (int tries = 0; tries < 6 && !better; ++tries) {
      Eigen::Matrix<double, kNumbers, kNumbers> damped = A;
      damped.diagonal() *= 1 + damping;
      const Numbers move = damped.ldlt().solve(-g);
      const Numbers there = n + move;
      if (!there.allFinite() || there[kBlurA] < kSharpest_px || there[kBlurB] < kSharpest_px) {
        damping *= 10;
        continue;
      }
      const double cost_there = misfit(pixels, guess_px, there, nullptr, nullptr);
      if (cost_there <= cost) {
        better = true;
        converged = move.head<2>().norm() < kStill_px;
        n = there;
        cost = cost_there;
        damping = std::max(1e-9, damping / 10);
      } else {
        damping *= 10;
      }
    }
    if (!better) {
      converged = true;  // no smaller step helps: it is there
    }
  }
  const Vec2 found(n[kX], n[kY]);
  // what is left must be noise against what lies between black and white
  constexpr double kMostLeft = 0.15;
  const double left = std::sqrt(cost / static_cast<double>(pixels.size()));
  const bool crossing = left < kMostLeft * std::abs(n[kHalf]) && n[kBlurA] < 0.5 * radius_px &&
                        n[kBlurB] < 0.5 * radius_px && std::abs(n[kCurveA]) < kMostCurved_per_px &&
                        std::abs(n[kCurveB]) < kMostCurved_per_px;
  return crossing && (found - guess_px).norm() <= farthest_px ? std::optional(found) : std::nullopt;
}

}  // namespace panoptes
