// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/word_index.h"

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/vision/synthetic_places.h"

namespace panoptes {
namespace {

constexpr int kWords = 250;
const std::vector<Facing> kBothWays = facings(testing::front_and_back());
constexpr double kRoundoff = 1e-12;

const std::vector<Pose2>& standpoints() {
  static const std::vector<Pose2> grid = [] {
    std::vector<Pose2> poses;
    for (int i = 0; i < 48; ++i) {
      poses.push_back({-1.75 + i % 8 * 0.5, -1.25 + i / 8 * 0.5, i % 3 * 0.7});
    }
    return poses;
  }();
  return grid;
}

const testing::SyntheticRoom& room() {
  static const testing::SyntheticRoom room(400, 4, Rng(1));
  return room;
}

// A share of the descriptors is of what is seen only now.
PlaceFeatures seen_at(const Pose2& pose, double clutter, const Rng& rng) {
  PlaceFeatures features =
      room().seen_from(testing::front_and_back(), pose, 0.7, 0, rng.fork("room"));
  Rng drawn = rng.fork("clutter");
  for (LocalFeatures& picture : features) {
    for (int row = 0; row < picture.descriptors.rows; ++row) {
      if (drawn.uniform() < clutter) {
        std::generate_n(picture.descriptors.ptr(row), picture.descriptors.cols,
                        [&] { return static_cast<std::uint8_t>(drawn.next()); });
      }
    }
  }
  return features;
}

WordIndex index_of_all(double clutter = 0.2) {
  WordIndex index(kWords, 2, Rng(2));
  for (const Pose2& pose : standpoints()) {
    index.add(seen_at(pose, clutter, Rng(3).fork(std::to_string(index.size()))));
  }
  return index;
}

struct Best {
  int place = 0;
  bool exchanged = false;
};

Best best_of(const std::vector<std::vector<double>>& shared) {
  Best best;
  for (int place = 0; place < static_cast<int>(shared.size()); ++place) {
    for (const bool exchanged : {false, true}) {
      if (shared[place][exchanged] > shared[best.place][best.exchanged]) {
        best = {place, exchanged};
      }
    }
  }
  return best;
}

TEST(WordIndex, APlaceSharesEverythingWithItselfAndLessWithAllOthers) {
  const WordIndex index = index_of_all();
  for (int place = 0; place < index.size(); ++place) {
    const std::vector<std::vector<double>> shared = index.shared(place, index.size(), kBothWays);
    EXPECT_NEAR(shared[place][0], 1, kRoundoff);
    for (int other = 0; other < index.size(); ++other) {
      for (const bool exchanged : {false, true}) {
        EXPECT_GE(shared[other][exchanged], 0);
        if (other != place || exchanged) {
          EXPECT_LT(shared[other][exchanged], 1);
        }
      }
    }
  }
}

TEST(WordIndex, ExchangedCamerasFindThePlaceTurnedRound) {
  WordIndex index = index_of_all();
  const int places = index.size();
  for (int place = 0; place < places; ++place) {
    PlaceFeatures turned = seen_at(standpoints()[place], 0.2, Rng(3).fork(std::to_string(place)));
    std::swap(turned[0], turned[1]);
    index.add(turned);
    const std::vector<std::vector<double>> shared =
        index.shared(index.size() - 1, places, kBothWays);
    EXPECT_NEAR(shared[place][1], 1, kRoundoff);
    EXPECT_EQ(best_of(shared).place, place);
    EXPECT_TRUE(best_of(shared).exchanged);
  }
}

// A third of the descriptors of both visits is of nothing that is seen again, the others differ by
// up to 20 bits, and the robot stands a little beside.
TEST(WordIndex, HasThePlaceAmongItsFirstInNoiseAndClutter) {
  constexpr double kClutter = 0.33;
  constexpr int kFirst = 5;
  WordIndex index = index_of_all(kClutter);
  const int places = index.size();
  Rng rng(4);
  int found = 0;
  for (int place = 0; place < places; ++place) {
    const bool opposite = place % 2 == 1;
    const Pose2 beside{rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1),
                       (opposite ? std::numbers::pi : 0) + rng.uniform(-0.1, 0.1)};
    index.add(
        seen_at(standpoints()[place] * beside, kClutter, rng.fork(std::to_string(index.size()))));
    const std::vector<std::vector<double>> shared =
        index.shared(index.size() - 1, places, kBothWays);
    int better = 0;
    for (const std::vector<double>& share : shared) {
      better += share[0] > shared[place][opposite] ? 1 : 0;
      better += share[1] > shared[place][opposite] ? 1 : 0;
    }
    found += shared[place][opposite] > 0 && better < kFirst ? 1 : 0;
  }
  EXPECT_GE(found, 0.9 * places);
}

TEST(WordIndex, SaysNothingBeforeItHasLearned) {
  WordIndex index(kWords, 2, Rng(2));
  index.add(seen_at({}, 0, Rng(3)));
  index.add(seen_at({}, 0, Rng(3)));
  EXPECT_EQ(index.shared(1, 2, kBothWays), (std::vector<std::vector<double>>(2, {0, 0})));
}

TEST(WordIndex, PlacesWithoutFeaturesShareNothing) {
  WordIndex index = index_of_all();
  index.add(PlaceFeatures(2));
  const int blind = index.size() - 1;
  for (const std::vector<double>& share : index.shared(blind, index.size(), kBothWays)) {
    EXPECT_EQ(share, (std::vector<double>{0, 0}));
  }
  EXPECT_EQ(index.shared(0, index.size(), kBothWays)[blind], (std::vector<double>{0, 0}));
  EXPECT_TRUE(index.shared(0, 0, kBothWays).empty());
}

TEST(WordIndex, GivesTheSameBitsAgainAndLooksOnlyBackward) {
  const WordIndex once = index_of_all();
  const WordIndex again = index_of_all();
  const int last = once.size() - 1;
  std::vector<std::vector<double>> all = once.shared(last, last, kBothWays);
  EXPECT_EQ(all, again.shared(last, last, kBothWays));
  EXPECT_GT(all[best_of(all).place][best_of(all).exchanged], 0);
  all.resize(10);
  EXPECT_EQ(all, once.shared(last, 10, kBothWays));
}

}  // namespace
}  // namespace panoptes
