// SPDX-License-Identifier: BSD-3-Clause
#include "core/explore/revisit.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/floor_plan.h"

namespace panoptes {
namespace {

/// Along y = 1 from x = 1 to 9 m in 25 cm steps, a second each, then nothing for a while.
std::vector<VisitedPose> straight_path_east() {
  std::vector<VisitedPose> places;
  for (int i = 0; i <= 32; ++i) {
    places.push_back({{1 + 0.25 * i, 1, 0}, time_at(i), 0.1});
  }
  return places;
}

TEST(Revisit, TakesAnOldStretchInTheDirectionAtHand) {
  const OccupancyMap map = test::empty_room(10, 4, 0.01);
  // East of the way, facing west: driving it backwards costs least.
  const auto found =
      choose_revisit(RevisitOptions(), SearchOptions(), drivable_grid({}, Body(), map),
                     {9.2, 1.5, deg_to_rad(180)}, time_at(300), straight_path_east(), {}, false);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->same_heading);
  EXPECT_GE(found->places.size(), 8U);
  for (std::size_t i = 1; i < found->places.size(); ++i) {
    EXPECT_EQ(found->places[i], found->places[i - 1] - 1);
  }
}

TEST(Revisit, PrefersTheUncertain) {
  const OccupancyMap map = test::empty_room(10, 4, 0.01);
  std::vector<VisitedPose> places = straight_path_east();
  for (int i = 0; i < 12; ++i) {
    places[static_cast<std::size_t>(i)].uncertainty_m = 1.0;
  }
  const auto found =
      choose_revisit(RevisitOptions(), SearchOptions(), drivable_grid({}, Body(), map),
                     {8.5, 2, deg_to_rad(180)}, time_at(300), places, {}, false);
  ASSERT_TRUE(found);
  EXPECT_LT(found->places.back(), 12);
}

TEST(Revisit, AimsAtNoPlaceThatNobodyKnowsWhereItIs) {
  const OccupancyMap map = test::empty_room(10, 4, 0.01);
  for (const double unknown :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    std::vector<VisitedPose> places = straight_path_east();
    for (int i = 0; i < 12; ++i) {
      places[static_cast<std::size_t>(i)].uncertainty_m = unknown;
    }
    const auto found =
        choose_revisit(RevisitOptions(), SearchOptions(), drivable_grid({}, Body(), map),
                       {2, 2, deg_to_rad(180)}, time_at(300), places, {}, false);
    ASSERT_TRUE(found);
    EXPECT_GE(*std::min_element(found->places.begin(), found->places.end()), 12);
  }
}

TEST(Revisit, LeavesYoungAndTriedPlacesAlone) {
  const OccupancyMap map = test::empty_room(10, 4, 0.01);
  EXPECT_FALSE(choose_revisit(RevisitOptions(), SearchOptions(), drivable_grid({}, Body(), map),
                              {5, 2, 0}, time_at(60), straight_path_east(), {}, false));
  std::vector<Vec2> tried;
  for (const VisitedPose& place : straight_path_east()) {
    tried.push_back(place.T_map_body.position());
  }
  EXPECT_FALSE(choose_revisit(RevisitOptions(), SearchOptions(), drivable_grid({}, Body(), map),
                              {5, 2, 0}, time_at(300), straight_path_east(), tried, false));
}

/// The same path, known worse the longer ago it was driven.
std::vector<VisitedPose> drifting_path_east(double uncertainty_at_start_m) {
  std::vector<VisitedPose> places = straight_path_east();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double left = 1 - static_cast<double>(i) / static_cast<double>(places.size() - 1);
    places[i].uncertainty_m = left * uncertainty_at_start_m;
  }
  return places;
}

TEST(Revisit, AClosureIsDueWhereItWouldHalveAnOldUncertainty) {
  const RevisitOptions options;
  const std::vector<VisitedPose> places = drifting_path_east(0.2);
  EXPECT_TRUE(closure_due(options, time_at(300), places, 0, 1));
  EXPECT_FALSE(closure_due(options, time_at(30), places, 0, 1)) << "young";
  EXPECT_FALSE(closure_due(options, time_at(300), places, 30, 1)) << "known well";
  EXPECT_FALSE(closure_due(options, time_at(300), places, 0, 6))
      << "as uncertain once it has gone there";
  EXPECT_FALSE(closure_due(options, time_at(300), drifting_path_east(0.03), 0, 1));
}

TEST(Revisit, TakesOnlyWhatIsOwedAClosureWhenToldSo) {
  const OccupancyMap map = test::empty_room(10, 4, 0.01);
  const auto found = [&](double uncertainty_m, bool only_due) {
    return choose_revisit(RevisitOptions(), SearchOptions(), drivable_grid({}, Body(), map),
                          {1, 2, 0}, time_at(300), drifting_path_east(uncertainty_m), {}, only_due);
  };
  EXPECT_TRUE(found(0.3, true));
  EXPECT_FALSE(found(0.03, true));
  EXPECT_TRUE(found(0.03, false));
}

}  // namespace
}  // namespace panoptes
