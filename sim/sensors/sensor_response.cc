// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/sensor_response.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

constexpr double kOne = 16384;   // of light_
constexpr double kSigma = 1024;  // of bank_
constexpr double kMostSigma = 5;
constexpr double kWhite = 255.0 * 255.0;
// Long enough that no two rows of a picture are likely to share a run, short enough for the cache.
constexpr std::size_t kBankStarts = std::size_t{1} << 17;

// With twice as many numbers at once where the machine can; the values are the same. (The
// sanitizers cannot bear that choice being made while the program is loaded.)
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define PANOPTES_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define PANOPTES_WIDE
#endif

/// In units of a picture's squared grey levels times kOne: the variance of a light s is
/// slope * s + floor, for noise in units of kSigma.
struct Variance {
  float slope = 0;
  float floor = 0;
};

// Written for the compiler to make vectors of it: no branch, no table.
PANOPTES_WIDE
void expose_row(std::uint8_t* __restrict grey, std::size_t count,
                const std::uint16_t* __restrict light, const std::int16_t* __restrict noise,
                Variance variance) {
  constexpr auto kMost = static_cast<float>(kWhite * kOne);
  constexpr auto kPerOne = static_cast<float>(1 / kOne);
  for (std::size_t i = 0; i < count; ++i) {
    const auto g = static_cast<float>(static_cast<int>(grey[i]));
    float s = g * g * static_cast<float>(static_cast<int>(light[i]));
    const auto z = static_cast<float>(static_cast<int>(noise[i]));
    s += z * std::sqrt(s * variance.slope + variance.floor);
    s = s < 0 ? 0 : s;
    s = s > kMost ? kMost : s;
    const float rounded = std::sqrt(s * kPerOne) + 0.5F;
    grey[i] = static_cast<std::uint8_t>(static_cast<int>(rounded));
  }
}

}  // namespace

void bind(Fields&, NoNoise&) {}

void bind(Fields& f, PhotonNoise& o) {
  f("full_well_e", o.full_well_e, between(100, 1e6));
  f("read_e", o.read_e, between(0, 1000));
}

SensorResponse::SensorResponse(const Intrinsics& lens, int channels, double vignetting,
                               const SensorNoise& noise, const Rng& rng)
    : size_(lens.width_px, lens.height_px),
      channels_(channels),
      headroom_(1 - vignetting),
      noise_(noise),
      rng_(rng) {
  const double far_x_px = std::max(lens.cx_px, lens.width_px - 1 - lens.cx_px);
  const double far_y_px = std::max(lens.cy_px, lens.height_px - 1 - lens.cy_px);
  const double far2_px2 = std::max(far_x_px * far_x_px + far_y_px * far_y_px, 1.0);
  // cos^4 = 1 / (1 + tan^2)^2
  const double tan2_per_px2 = (1 / std::sqrt(headroom_) - 1) / far2_px2;
  light_.reserve(static_cast<std::size_t>(size_.area()) * static_cast<std::size_t>(channels));
  for (int v = 0; v < lens.height_px; ++v) {
    for (int u = 0; u < lens.width_px; ++u) {
      const double x_px = u - lens.cx_px;
      const double y_px = v - lens.cy_px;
      const double root = 1 + tan2_per_px2 * (x_px * x_px + y_px * y_px);
      const double share = 1 / (root * root * headroom_);
      light_.insert(light_.end(), static_cast<std::size_t>(channels),
                    static_cast<std::uint16_t>(std::lround(share * kOne)));
    }
  }
  bank_.resize(kBankStarts +
               static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(channels));
  if (std::holds_alternative<PhotonNoise>(noise_)) {
    Rng draw = rng_.fork("bank");
    for (std::int16_t& one : bank_) {
      const double z = std::clamp(draw.normal(), -kMostSigma, kMostSigma);
      one = static_cast<std::int16_t>(std::lround(z * kSigma));
    }
  }
}

void SensorResponse::expose(cv::Mat& picture, double gain, std::int64_t number, bool noisy) const {
  PANOPTES_CHECK(picture.size() == size_ && picture.type() == CV_8UC(channels_),
                 "a picture comes in the lens's size");
  const auto* photons = std::get_if<PhotonNoise>(&noise_);
  noisy = noisy && photons != nullptr;
  if (headroom_ == 1 && !noisy) {
    return;
  }
  Variance variance;
  if (noisy) {
    const double grey2_per_e = kWhite * gain / photons->full_well_e;
    variance.slope = static_cast<float>(grey2_per_e * kOne / (kSigma * kSigma));
    variance.floor = static_cast<float>(std::pow(photons->read_e * grey2_per_e * kOne / kSigma, 2));
  }
  Rng places = rng_.fork(std::to_string(number));
  const auto count = static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(channels_);
  for (int v = 0; v < size_.height; ++v) {
    expose_row(picture.ptr<std::uint8_t>(v), count,
               light_.data() + static_cast<std::size_t>(v) * count,
               bank_.data() + places.index(static_cast<int>(kBankStarts)), variance);
  }
}

}  // namespace panoptes::sim
