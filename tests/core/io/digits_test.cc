// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/digits.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

TEST(Digits, AreTheFewestThatReadBack) {
  EXPECT_EQ(shortest(0.1), "0.1");
  EXPECT_EQ(shortest(1.0 / 3), "0.3333333333333333");
  EXPECT_EQ(shortest(3), "3");
  EXPECT_EQ(shortest(-0.0), "0");
  EXPECT_EQ(shortest(1e-7), "1e-07");
}

TEST(Digits, ReadBackToTheSameDouble) {
  Rng rng(1);
  for (int i = 0; i < 1000; ++i) {
    const double value = rng.normal() * std::pow(10.0, rng.index(20) - 10);
    EXPECT_EQ(parse_number(shortest(value)), value);
  }
}

TEST(Digits, RefuseWhatIsNoFiniteNumber) {
  for (const char* text : {"", "1.5x", "nan", "inf", "-inf", " 1", "1,5", "--1"}) {
    EXPECT_FALSE(parse_number(text)) << text;
  }
}

TEST(Seconds, AreExactToTheNanosecond) {
  EXPECT_EQ(seconds(Time(Duration(0))), "0");
  EXPECT_EQ(seconds(Time(Duration(66'666'667))), "0.066666667");
  EXPECT_EQ(seconds(Time(Duration(-1'500'000'000))), "-1.5");
  Rng rng(2);
  for (int i = 0; i < 1000; ++i) {
    const Time stamp(Duration(static_cast<std::int64_t>(rng.next() >> 4)));
    EXPECT_EQ(parse_seconds(seconds(stamp)), stamp);
  }
}

TEST(Seconds, RoundWhatIsFinerThanANanosecond) {
  EXPECT_EQ(parse_seconds("0.0000000015"), Time(Duration(2)));
  EXPECT_EQ(parse_seconds("1e-3"), Time(Duration(1'000'000)));
  EXPECT_FALSE(parse_seconds("1e30"));
  EXPECT_FALSE(parse_seconds("soon"));
}

}  // namespace
}  // namespace panoptes
