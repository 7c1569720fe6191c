// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/rng.h"

#include <bit>
#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace panoptes {
namespace {

std::uint64_t splitmix64(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15ULL;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

Rng::Rng(std::uint64_t seed) : seed_(seed), state_{} {
  std::uint64_t s = seed;
  for (std::uint64_t& word : state_) {
    word = splitmix64(s);
  }
}

Rng Rng::fork(std::string_view name) const {
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a
  for (const char c : name) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  std::uint64_t mixed = seed_ ^ std::rotl(hash, 32);
  const std::uint64_t forked = splitmix64(mixed) ^ hash;
  return Rng(forked);
}

std::uint64_t Rng::next() {
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t t = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double Rng::uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }

double Rng::uniform(double low, double high) { return low + (high - low) * uniform(); }

int Rng::index(int count) {
  PANOPTES_CHECK(count > 0, "an index is drawn from at least one");
  return static_cast<int>(next() % static_cast<std::uint64_t>(count));
}

double Rng::normal() {  // Box and Muller 1958; the sine is dropped so that no state is kept
  const double u = 1.0 - uniform();
  const double v = uniform();
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

double Rng::normal(double mean, double sigma) { return mean + sigma * normal(); }

}  // namespace panoptes
