// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/gaps.h"

#include <gmock/gmock.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

using std::chrono::milliseconds;
using testing::IsEmpty;
using testing::SizeIs;

constexpr Duration kPeriod = milliseconds(66);
constexpr int kPictures = 600;

// `kept(i)` of the pictures come, each a few ms early or late.
template <class Kept>
std::vector<Time> stamps_of(const Kept& kept) {
  Rng rng(3);
  std::vector<Time> stamps;
  for (int i = 0; i < kPictures; ++i) {
    const Duration jitter = milliseconds(static_cast<int>(rng.index(9)) - 4);
    if (kept(i)) {
      stamps.push_back(Time(kPeriod * i + jitter));
    }
  }
  return stamps;
}

Regularity found(const std::vector<Time>& stamps) {
  return regularity(stamps, Time(), Time(kPeriod * (kPictures - 1)));
}

TEST(Gaps, ThereAreNoneWhereNothingIsMissing) {
  const Regularity all = found(stamps_of([](int) { return true; }));
  EXPECT_NEAR(all.rate_hz(), 1000 / 66.0, 0.3);
  EXPECT_EQ(all.missing, 0U);
  EXPECT_THAT(all.gaps, IsEmpty());
}

TEST(Gaps, ARunThatChanceDoesNotExplainIsOne) {
  const Regularity one = found(stamps_of([](int i) { return i < 100 || i >= 115; }));
  EXPECT_EQ(one.missing, 15U);
  ASSERT_THAT(one.gaps, SizeIs(1));
  EXPECT_EQ(one.gaps[0].missing, 15U);
  EXPECT_EQ(one.gaps[0].next, 100U);
  EXPECT_NEAR(to_seconds(one.gaps[0].to - one.gaps[0].from), 16 * 0.066, 0.01);
  EXPECT_EQ(spelt({Time(milliseconds(6534)), Time(milliseconds(7590)), 15, 100}, one, "picture")
                .substr(0, 72),
            "no picture for 1.06 s, from 6.53 to 7.59 s: 15 missing, at 15.2 a second");
}

TEST(Gaps, SinglePicturesLostByChanceAreNone) {
  for (const double share : {0.01, 0.05, 0.2}) {
    Rng rng(5);
    const Regularity some = found(stamps_of([&](int) { return rng.uniform() >= share; }));
    EXPECT_GT(some.missing, 0U);
    EXPECT_THAT(some.gaps, IsEmpty()) << share;
  }
}

TEST(Gaps, BeginningLateAndEndingEarlyAreToo) {
  const Regularity late = found(stamps_of([](int i) { return i >= 30; }));
  ASSERT_THAT(late.gaps, SizeIs(1));
  EXPECT_EQ(late.gaps[0].missing, 30U);
  EXPECT_EQ(late.gaps[0].next, 0U);
  EXPECT_EQ(late.gaps[0].from, Time());
  const Regularity early = found(stamps_of([](int i) { return i < kPictures - 30; }));
  ASSERT_THAT(early.gaps, SizeIs(1));
  EXPECT_EQ(early.gaps[0].missing, 30U);
  EXPECT_EQ(early.gaps[0].next, static_cast<std::size_t>(kPictures - 30));
}

TEST(Gaps, OfOneStampNothingIsKnown) {
  EXPECT_EQ(found({Time(kPeriod)}).rate_hz(), 0);
  EXPECT_THAT(found({}).gaps, IsEmpty());
}

}  // namespace
}  // namespace panoptes
