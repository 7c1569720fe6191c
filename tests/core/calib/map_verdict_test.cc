// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/map_verdict.h"

#include <gmock/gmock.h>

#include "tests/support/good_map.h"

namespace panoptes {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct Case {
  MonoMap map;
  AdjustedMap adjusted;
  RigCamera believed;
};

Case good() {
  Case c;
  c.believed.intrinsics = pinhole(640, 480, deg_to_rad(80));
  c.map = good_map();
  c.adjusted = good_keyframes(c.believed);
  return c;
}

Judged judged(const Case& c) { return judge_map(c.map, c.adjusted, c.believed); }

TEST(MapVerdict, IsGoodWhereNothingIsWrong) {
  EXPECT_EQ(judged(good()).verdict, Verdict::kGood);
  EXPECT_THAT(judged(good()).reasons, IsEmpty());
}

TEST(MapVerdict, AnotherLensIsTold) {
  Case c = good();
  c.adjusted.lens.fx_px *= 1.03;
  EXPECT_EQ(judged(c).verdict, Verdict::kPoor);
  EXPECT_THAT(judged(c).reasons, ElementsAre(HasSubstr("another lens: focal length +3.00 %")));
  c.believed.sigma.focal_ratio = 0.02;  // it is said to be known no better
  EXPECT_EQ(judged(c).verdict, Verdict::kGood);
}

TEST(MapVerdict, WhatContradictsItselfIsPoor) {
  Case c = good();
  c.adjusted.observations = 600;
  c.adjusted.left_out = 400;
  EXPECT_EQ(judged(c).verdict, Verdict::kPoor);
  EXPECT_THAT(judged(c).reasons.at(0), HasSubstr("400 of 1000 observations"));
}

TEST(MapVerdict, WhereNoKeyframesHoldTogetherThereIsNoMap) {
  Case c = good();
  c.adjusted = {};
  EXPECT_EQ(judged(c).verdict, Verdict::kFailed);
  EXPECT_THAT(judged(c).reasons, ElementsAre(HasSubstr("no keyframes hold together")));
}

TEST(MapVerdict, AStartThatNothingIsKnownOfIsPoorUntilTheTurnCloses) {
  Case c = good();
  c.map.start_is_known = false;
  EXPECT_EQ(judged(c).verdict, Verdict::kGood);
  c.map.closed.reset();
  EXPECT_THAT(judged(c).reasons.at(0), HasSubstr("how far things are"));
}

void lose(MonoMap& map, std::size_t from, std::size_t to) {
  for (std::size_t i = from; i < to; ++i) {
    map.frames[i].lost = true;
    map.lost_s += 0.1;
  }
}

TEST(MapVerdict, WhatWasLostIsPoorAndSaysWhen) {
  Case c = good();
  c.map.begins_s = 1;
  lose(c.map, 20, 30);
  EXPECT_EQ(judged(c).verdict, Verdict::kPoor);
  EXPECT_THAT(judged(c).reasons, ElementsAre("it was lost for 1.0 s: from 2.9 to 3.9 s"));
  lose(c.map, 50, 70);
  EXPECT_THAT(judged(c).reasons,
              ElementsAre("it was lost for 3.0 s, 2 times, longest from 5.9 to 7.9 s"));
}

TEST(MapVerdict, WhatIsLostAtTheEndIsNone) {
  Case c = good();
  lose(c.map, 95, 100);
  EXPECT_EQ(judged(c).verdict, Verdict::kFailed);
  EXPECT_THAT(judged(c).reasons, ElementsAre("it is lost at the end, from 9.4 s on; 0.5 s in all"));
}

TEST(MapVerdict, TooLittleToSeeIsNone) {
  Case c = good();
  c.map.points.resize(5);
  EXPECT_EQ(judged(c).verdict, Verdict::kFailed);
}

TEST(MapVerdict, WhatDoesNotCloseOrAgreeIsPoor) {
  Case c = good();
  c.map.closed.reset();
  c.adjusted.rms_after_px = 1;
  EXPECT_EQ(judged(c).verdict, Verdict::kPoor);
  EXPECT_THAT(judged(c).reasons, ElementsAre(HasSubstr("1.00 px of reprojection"),
                                             HasSubstr("more than 360 degrees")));
}

}  // namespace
}  // namespace panoptes
