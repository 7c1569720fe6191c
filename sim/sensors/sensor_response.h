// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/rng.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"

namespace panoptes::sim {

struct NoNoise {
  static constexpr std::string_view kName = "none";
};
void bind(Fields& f, NoNoise& o);

/// Photons are counted, and the count is read with an error. Grey 255 at gain 1 are `full_well_e`
/// electrons, and as grey levels are square roots of light, shot noise alone is everywhere
/// 127.5 / sqrt(full_well_e / gain) grey levels: 4064 and no reading error are 2 of them.
struct PhotonNoise {
  static constexpr std::string_view kName = "photons";
  double full_well_e = 8000;
  double read_e = 12;  ///< standard deviation
};
void bind(Fields& f, PhotonNoise& o);

using SensorNoise = std::variant<PhotonNoise, NoNoise>;

/// From the light behind the lens to grey levels: the light falls off towards the corners, is
/// counted in electrons and clipped where the sensor is full. A picture's noise is read row by row
/// from a bank drawn once, from places that `rng` and the picture's number decide.
class SensorResponse {
 public:
  /// `vignetting` is the share of the light lost at the pixel farthest from the axis; it falls as
  /// cos^4 of an angle. `channels` is 3, or 1 for a mosaic.
  SensorResponse(const Intrinsics& lens, int channels, double vignetting, const SensorNoise& noise,
                 const Rng& rng);

  /// Pictures must come so much darker (in light), that what is brighter than white in the middle
  /// can be white in the corners.
  double headroom() const { return headroom_; }

  /// In place, on a picture of the lens's size: 8-bit square roots of light, drawn darker by
  /// `headroom()`. `gain` is the amplifier's: the electrons are that much fewer. `noisy` is for
  /// looks that are no pictures.
  void expose(cv::Mat& picture, double gain, std::int64_t number, bool noisy = true) const;

 private:
  cv::Size size_;
  int channels_;
  double headroom_;
  SensorNoise noise_;
  Rng rng_;
  std::vector<std::uint16_t> light_;  // that falls on each value, in 1/16384 of what was drawn
  std::vector<std::int16_t> bank_;    // normal, in 1/1024 of the standard deviation
};

}  // namespace panoptes::sim
