// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/rng.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(Rng, RepeatsFromItsSeed) {
  Rng a(42);
  Rng b(42);
  Rng other(43);
  bool differs = false;
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t drawn = a.next();
    EXPECT_EQ(drawn, b.next());
    differs = differs || drawn != other.next();
  }
  EXPECT_TRUE(differs);
}

TEST(Rng, AForkDoesNotDependOnWhatWasDrawn) {
  Rng fresh(1);
  Rng used(1);
  used.next();
  EXPECT_EQ(fresh.fork("wheel-slip").next(), used.fork("wheel-slip").next());
  EXPECT_NE(fresh.fork("wheel-slip").next(), fresh.fork("noise").next());
  EXPECT_NE(fresh.fork("a").fork("b").next(), fresh.fork("b").fork("a").next());
  EXPECT_NE(fresh.fork("a").next(), Rng(1).next());
}

TEST(Rng, DrawsWhatItPromises) {
  Rng rng(7);
  constexpr int kDraws = 100000;
  double sum = 0;
  double square = 0;
  std::array<int, 5> count{};
  for (int i = 0; i < kDraws; ++i) {
    const double u = rng.uniform(2, 4);
    ASSERT_GE(u, 2);
    ASSERT_LT(u, 4);
    const double n = rng.normal();
    sum += n;
    square += n * n;
    ++count[static_cast<std::size_t>(rng.index(5))];
  }
  const double three_sigma = 3 / std::sqrt(kDraws);
  EXPECT_NEAR(sum / kDraws, 0, three_sigma);
  EXPECT_NEAR(square / kDraws, 1, three_sigma * std::sqrt(2.0));
  for (const int c : count) {
    EXPECT_NEAR(c, kDraws / 5.0, 3.5 * std::sqrt(kDraws * 0.2 * 0.8));  // five of them
  }
}

}  // namespace
}  // namespace panoptes
