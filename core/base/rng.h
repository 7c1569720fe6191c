// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace panoptes {

/// Seeded random numbers (xoshiro256++ of Blackman and Vigna 2019, seeded by splitmix64). A fork
/// depends on the seed and the names forked through, never on how many numbers were drawn, so that
/// adding a source of noise does not shift the others.
class Rng {
 public:
  explicit Rng(std::uint64_t seed);

  Rng fork(std::string_view name) const;

  std::uint64_t next();
  double uniform();                         ///< in [0, 1)
  double uniform(double low, double high);  ///< in [low, high)
  int index(int count);                     ///< in [0, count), count > 0
  double normal();                          ///< mean 0, standard deviation 1
  double normal(double mean, double sigma);

 private:
  std::uint64_t seed_;
  std::array<std::uint64_t, 4> state_;
};

}  // namespace panoptes
