// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study/limit.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace panoptes {
namespace {

std::string fault(const std::string& text) {
  try {
    parse_limit(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(Limit, ComparesAFigure) {
  const Limit limit = parse_limit(" loops.false == 0 ");
  EXPECT_EQ(limit.text, "loops.false == 0");
  EXPECT_EQ(broken_by(limit, {{"loops.false", 0}}), "");
  EXPECT_EQ(broken_by(limit, {{"loops.false", 2}}), "loops.false == 0, it is 2");
}

TEST(Limit, ComparesAFigureWithAnother) {
  const Limit limit = parse_limit("trajectory.ate_rmse_m / trajectory.odometry_ate_rmse_m <= 1");
  const auto broken = [&](double error_m, double by_wheels_m) {
    return broken_by(limit, {{"trajectory.ate_rmse_m", error_m},
                             {"trajectory.odometry_ate_rmse_m", by_wheels_m}});
  };
  EXPECT_EQ(broken(0.25, 0.5), "");
  EXPECT_EQ(broken(0.5, 0.5), "");
  EXPECT_EQ(broken(1, 0.5), limit.text + ", it is 2");
  EXPECT_EQ(broken(1, 0), limit.text + ", it is inf");
  EXPECT_EQ(broken(0, 0).find(limit.text), 0U) << "nothing against nothing is no proof";
}

TEST(Limit, OfADifferenceIsABound) {
  EXPECT_EQ(parse_comparison("map.coverage >= -0.01").figure, "map.coverage");
  for (const char* bad : {"loops.false == 0", "map.coverage / loops.false >= 1"}) {
    EXPECT_THROW(parse_comparison(bad), ConfigError) << bad;
  }
}

TEST(Limit, IsBrokenByAnAbsentFigure) {
  EXPECT_EQ(broken_by(parse_limit("loops.recall_same >= 0.9"), {}),
            "loops.recall_same >= 0.9, no such figure");
  const Limit quotient = parse_limit("loops.false / loops.accepted < 0.5");
  EXPECT_EQ(broken_by(quotient, {{"loops.false", 0}}), quotient.text + ", no such figure");
  EXPECT_EQ(broken_by(quotient, {{"loops.accepted", 4}}), quotient.text + ", no such figure");
}

TEST(Limit, RefusesWhatNoRunCanHold) {
  const std::string form =
      "must be a figure, or a figure / another one, one of == != < <= > >=, and a number";
  for (const char* text : {"", "loops.false", "loops.false = 0", "/ loops.false < 1",
                           "loops.false / < 1", "loops.false / loops.accepted / keyframes < 1"}) {
    EXPECT_EQ(fault(text), std::string("limit '") + text + "': " + form);
  }
  EXPECT_EQ(fault("loops.fals == 0"),
            "limit 'loops.fals == 0': no run has a figure 'loops.fals'; did you mean loops.false?");
  EXPECT_EQ(fault("loops.false / loops.acepted < 1"),
            "limit 'loops.false / loops.acepted < 1': no run has a figure 'loops.acepted'; did you "
            "mean loops.accepted?");
  EXPECT_EQ(fault("outcome == completed"),
            "limit 'outcome == completed': must be compared with a number");
}

}  // namespace
}  // namespace panoptes
