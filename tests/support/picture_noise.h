// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/rng.h"

namespace panoptes {

/// Normal numbers, for every pixel of a picture: out of a table, by 16 random bits each.
class PictureNoise {
 public:
  explicit PictureNoise(Rng& rng) : rng_(&rng) {}

  double normal() {
    if (left_ == 0) {
      bits_ = rng_->next();
      left_ = 4;
    }
    const double drawn = table()[bits_ & 0xffff];
    bits_ >>= 16;
    --left_;
    return drawn;
  }

 private:
  using Table = std::array<double, 0x10000>;
  static const Table& table() {
    static const Table drawn = [] {
      Table table{};
      Rng rng(1);
      for (double& number : table) {
        number = rng.normal();
      }
      return table;
    }();
    return drawn;
  }

  Rng* rng_;
  std::uint64_t bits_ = 0;
  int left_ = 0;
};

}  // namespace panoptes
