// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/config/fields.h"
#include "core/geometry/pose2.h"

namespace panoptes {

struct FloorColourOptions {
  int learned_max = 8;  ///< Gaussians kept
  int trained = 3;      ///< Gaussians fitted to the trusted pixels of one picture
  double shade = 0.15;  ///< relative standard deviation of brightness that shading is granted
  double sigma_min_grey = 2.0;   ///< floor of every standard deviation: the camera's own noise
  double prior_log_odds = -3.0;  ///< ln P(free)/P(occupied) before looking
  double mass_max = 50000;  ///< pixels; a Gaussian heavier than this could not follow the light
  double mass_half_life_s = 277.1895517283;  ///< of all masses: 0.9995 an update, of 0.2 s
  double vote_share = 0.02;                  ///< of the largest mass that a Gaussian needs to vote
};
void bind(Fields& f, FloorColourOptions& o);

/// One kind of floor: BGR mean, covariance and mass in pixels.
struct ColourGaussian {
  Vec3 mean = Vec3::Zero();
  Mat3 covariance = Mat3::Identity();
  double mass = 0;
};

using Bgr = std::array<std::uint8_t, 3>;

/// The covariance of a floor that is shaded here and there: shading scales a colour and keeps its
/// chromaticity, so it is widened along its own mean.
Mat3 shaded(const ColourGaussian& floor, double shade);

/// Gaussians fitted to colours by k-means; deterministic. Those holding under 2 % are dropped.
std::vector<ColourGaussian> fit_colours(std::span<const Bgr> colours, int clusters);

/// The floor's colours as a mixture of Gaussians (thesis Eqs 6.2-6.5; Dahlkamp et al. 2006).
/// Shading scales a colour and keeps its chromaticity, so each Gaussian is widened along its own
/// mean.
class FloorColour {
 public:
  /// `learn_every_s` lies between two updates.
  explicit FloorColour(const FloorColourOptions& options, double learn_every_s = 0.2);

  /// Merges by Eqs 6.4 and 6.5 what overlaps a learned Gaussian; the rest replaces the lightest.
  void learn(const std::vector<ColourGaussian>& trained);

  /// Takes a floor that proved to be one by other means, heavy enough to count like those known.
  void adopt(ColourGaussian floor);

  /// ln P(free)/P(occupied) of a colour against a uniform obstacle (Eq. 6.2), nats.
  double log_ratio(const Vec3& bgr) const;

  /// The same from a table, in eighths of a nat within +-kClip.
  std::int8_t quick(const std::uint8_t* bgr) {
    const std::size_t i = (static_cast<std::size_t>(bgr[0] >> 2) << 12) |
                          (static_cast<std::size_t>(bgr[1] >> 2) << 6) |
                          static_cast<std::size_t>(bgr[2] >> 2);
    const std::int8_t v = table_[i];
    return v != kEmpty ? v : fill(i);
  }

  const std::vector<ColourGaussian>& learned() const { return learned_; }
  int voting() const { return static_cast<int>(votes_.size()); }

  static constexpr int kClip = 32;

 private:
  struct Vote {
    Vec3 mean;
    Mat3 information;
    double log_weight;  // of the normalised density
  };
  std::int8_t fill(std::size_t index);
  void refresh();

  static constexpr std::int8_t kEmpty = -128;
  FloorColourOptions options_;
  double mass_decay_;  // of an update
  std::vector<ColourGaussian> learned_;
  std::vector<Vote> votes_;
  std::vector<ColourGaussian> voted_with_;  // what the table was made from
  std::vector<std::int8_t> table_;
};

}  // namespace panoptes
