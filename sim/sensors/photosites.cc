// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/photosites.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

constexpr float kOne = 16384;  // of light_
constexpr float kSigma = 32;   // of bank_; it ends at 127 / 32 = 4 sigma
constexpr double kWhite = 255.0 * 255.0;
// Long enough that no two rows of a picture are likely to share a run, short enough for the cache.
constexpr std::size_t kBankStarts = std::size_t{1} << 17;

/// The noise of a light s (in squared grey levels): variance slope * s + floor.
struct Variance {
  float slope = 0;
  float floor = 0;
};

// Written for the compiler to make vectors of it: no branch, no table.
template <bool kFalls, bool kNoisy>
void expose_row(std::uint8_t* __restrict grey, std::size_t count,
                const std::uint16_t* __restrict light, const std::int8_t* __restrict noise,
                Variance variance) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto g = static_cast<float>(static_cast<int>(grey[i]));
    float s = g * g;
    if constexpr (kFalls) {
      s *= static_cast<float>(static_cast<int>(light[i])) * (1 / kOne);
    }
    if constexpr (kNoisy) {
      const float z = static_cast<float>(static_cast<int>(noise[i])) * (1 / kSigma);
      s += z * std::sqrt(s * variance.slope + variance.floor);
      s = s < 0 ? 0 : s;
    }
    s = s > static_cast<float>(kWhite) ? static_cast<float>(kWhite) : s;
    grey[i] = static_cast<std::uint8_t>(static_cast<int>(std::sqrt(s) + 0.5F));
  }
}

}  // namespace

void bind(Fields&, NoNoise&) {}

void bind(Fields& f, PhotonNoise& o) {
  f("full_well_e", o.full_well_e, between(100, 1e6));
  f("read_e", o.read_e, between(0, 1000));
}

Photosites::Photosites(const Intrinsics& lens, int channels, double vignetting,
                       const SensorNoise& noise, const Rng& rng)
    : size_(lens.width_px, lens.height_px),
      channels_(channels),
      headroom_(1 - vignetting),
      noise_(noise),
      rng_(rng) {
  if (vignetting > 0) {
    const double far_x_px = std::max(lens.cx_px, lens.width_px - 1 - lens.cx_px);
    const double far_y_px = std::max(lens.cy_px, lens.height_px - 1 - lens.cy_px);
    const double far2_px2 = far_x_px * far_x_px + far_y_px * far_y_px;
    // cos^4 = 1 / (1 + tan^2)^2
    const double tan2_per_px2 = (1 / std::sqrt(headroom_) - 1) / far2_px2;
    light_.reserve(static_cast<std::size_t>(size_.area()) * static_cast<std::size_t>(channels));
    for (int v = 0; v < lens.height_px; ++v) {
      for (int u = 0; u < lens.width_px; ++u) {
        const double x_px = u - lens.cx_px;
        const double y_px = v - lens.cy_px;
        const double root = 1 + tan2_per_px2 * (x_px * x_px + y_px * y_px);
        const double share = 1 / (root * root * headroom_);
        const auto fixed = static_cast<std::uint16_t>(std::lround(share * kOne));
        light_.insert(light_.end(), static_cast<std::size_t>(channels), fixed);
      }
    }
  }
  if (std::holds_alternative<PhotonNoise>(noise_)) {
    Rng draw = rng_.fork("bank");
    bank_.resize(kBankStarts +
                 static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(channels));
    for (std::int8_t& one : bank_) {
      const double z = std::round(draw.normal(0, static_cast<double>(kSigma)));
      one = static_cast<std::int8_t>(std::clamp(z, -127.0, 127.0));
    }
  }
}

void Photosites::expose(cv::Mat& picture, double gain, std::int64_t number, bool noisy) const {
  PANOPTES_CHECK(picture.size() == size_ && picture.type() == CV_8UC(channels_),
                 "a picture comes in the lens's size");
  noisy = noisy && !bank_.empty();
  if (light_.empty() && !noisy) {
    return;
  }
  Variance variance;
  if (const auto* photons = std::get_if<PhotonNoise>(&noise_)) {
    const double grey2_per_e = kWhite * gain / photons->full_well_e;
    variance.slope = static_cast<float>(grey2_per_e);
    variance.floor = static_cast<float>(std::pow(photons->read_e * grey2_per_e, 2));
  }
  Rng places = rng_.fork(std::to_string(number));
  const auto count = static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(channels_);
  for (int v = 0; v < size_.height; ++v) {
    auto* grey = picture.ptr<std::uint8_t>(v);
    const std::uint16_t* light =
        light_.empty() ? nullptr : light_.data() + static_cast<std::size_t>(v) * count;
    const std::int8_t* noise =
        noisy ? bank_.data() + places.index(static_cast<int>(kBankStarts)) : nullptr;
    if (light == nullptr) {
      expose_row<false, true>(grey, count, light, noise, variance);
    } else if (noisy) {
      expose_row<true, true>(grey, count, light, noise, variance);
    } else {
      expose_row<true, false>(grey, count, light, noise, variance);
    }
  }
}

}  // namespace panoptes::sim
