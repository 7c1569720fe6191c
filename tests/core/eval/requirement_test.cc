// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/requirement.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace panoptes {
namespace {

std::string message_of(const char* text) {
  try {
    parse_requirement(text);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Requirement, ComparesNumbers) {
  EXPECT_EQ(parse_requirement(" map.coverage  >= 0.85 ").figure, "map.coverage");
  EXPECT_TRUE(holds(parse_requirement("map.coverage >= 0.85"), 0.85));
  EXPECT_FALSE(holds(parse_requirement("map.coverage > 0.85"), 0.85));
  EXPECT_TRUE(holds(parse_requirement("collisions==0"), 0.0));
  EXPECT_TRUE(holds(parse_requirement("collisions != 1"), 0.0));
  EXPECT_TRUE(holds(parse_requirement("a < 1e-3"), 0.0));
  EXPECT_FALSE(holds(parse_requirement("a <= -2"), 0.0));
}

TEST(Requirement, ComparesWords) {
  EXPECT_TRUE(holds(parse_requirement("outcome == completed"), "completed"));
  EXPECT_FALSE(holds(parse_requirement("outcome == completed"), "stuck"));
  EXPECT_TRUE(holds(parse_requirement("outcome != stuck"), "completed"));
}

TEST(Requirement, IsBrokenByAnotherKindOfFigure) {
  EXPECT_FALSE(holds(parse_requirement("outcome == completed"), 1.0));
  EXPECT_FALSE(holds(parse_requirement("collisions != 1"), "none"));
  EXPECT_FALSE(holds(parse_requirement("a != 1"), std::numeric_limits<double>::quiet_NaN()));
}

TEST(Requirement, RefusesWhatItCannotJudge) {
  const std::string shape = "must be a figure, one of == != < <= > >=, and a value";
  EXPECT_EQ(message_of("collisions"), "requirement 'collisions': " + shape);
  EXPECT_EQ(message_of("collisions = 0"), "requirement 'collisions = 0': " + shape);
  EXPECT_EQ(message_of("== 0"), "requirement '== 0': " + shape);
  EXPECT_EQ(message_of("a b == 0"), "requirement 'a b == 0': " + shape);
  EXPECT_EQ(message_of("a == "), "requirement 'a == ': the value must be a number or a word");
  EXPECT_EQ(message_of("a > high"),
            "requirement 'a > high': a word can only be compared by == or !=");
}

}  // namespace
}  // namespace panoptes
