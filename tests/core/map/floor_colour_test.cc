// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_colour.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

std::vector<Bgr> colours_of(const Vec3& mean, double sigma, int count, Rng& rng) {
  std::vector<Bgr> out;
  for (int i = 0; i < count; ++i) {
    Bgr c{};
    for (int a = 0; a < 3; ++a) {
      c[static_cast<std::size_t>(a)] = static_cast<std::uint8_t>(
          std::clamp(std::lround(mean(a) + rng.normal(0, sigma)), 0L, 255L));
    }
    out.push_back(c);
  }
  return out;
}

TEST(FloorColour, FindsTwoColoursAndTheirShares) {
  Rng rng(1);
  std::vector<Bgr> colours = colours_of(Vec3(60, 80, 100), 4, 3000, rng);
  const std::vector<Bgr> other = colours_of(Vec3(160, 120, 90), 4, 1000, rng);
  colours.insert(colours.end(), other.begin(), other.end());
  const std::vector<ColourGaussian> found = fit_colours(colours, 2);
  ASSERT_EQ(found.size(), 2U);
  // three sigma of the mean of the draws, and a sixteenth of a level's rounding
  EXPECT_NEAR((found[0].mean - Vec3(60, 80, 100)).norm(), 0, 3 * 4 / std::sqrt(1000.0));
  EXPECT_NEAR((found[1].mean - Vec3(160, 120, 90)).norm(), 0, 3 * 4 / std::sqrt(300.0));
  EXPECT_EQ(found[0].mass, 3000);
  EXPECT_EQ(found[1].mass, 1000);
}

TEST(FloorColour, TellsWhatItLearnedFromAnythingElse) {
  Rng rng(2);
  FloorColour colour({});
  EXPECT_LT(colour.log_ratio(Vec3(60, 80, 100)), 0);
  colour.learn(fit_colours(colours_of(Vec3(60, 80, 100), 6, 2000, rng), 2));
  EXPECT_GT(colour.log_ratio(Vec3(60, 80, 100)), 2);
  EXPECT_LT(colour.log_ratio(Vec3(160, 120, 90)), -4);
}

TEST(FloorColour, GrantsShadingButNotAnotherHue) {
  Rng rng(3);
  FloorColour colour({});
  colour.learn(fit_colours(colours_of(Vec3(60, 80, 120), 4, 2000, rng), 1));
  EXPECT_GT(colour.log_ratio(0.7 * Vec3(60, 80, 120)), 0);
  const double as_far = 0.3 * Vec3(60, 80, 120).norm();
  EXPECT_LT(colour.log_ratio(Vec3(60, 80, 120) + as_far * Vec3(1, 0, -0.5).normalized()), -4);
}

TEST(FloorColour, TheTableAgreesWithTheFormula) {
  Rng rng(4);
  FloorColour colour({});
  colour.learn(fit_colours(colours_of(Vec3(61.5, 81.5, 101.5), 6, 2000, rng), 1));
  for (int i = 0; i < 1000; ++i) {
    // at the middle of a bin the table holds the formula to half of its eighth of a nat
    const std::array<std::uint8_t, 3> c{static_cast<std::uint8_t>(4 * (10 + rng.index(12)) + 1),
                                        static_cast<std::uint8_t>(4 * (15 + rng.index(12)) + 1),
                                        static_cast<std::uint8_t>(4 * (20 + rng.index(12)) + 1)};
    const double exact =
        std::clamp(colour.log_ratio(Vec3(c[0] + 0.5, c[1] + 0.5, c[2] + 0.5)), -4.0, 4.0);
    EXPECT_NEAR(colour.quick(c.data()) / 8.0, exact, 0.0626);
  }
}

TEST(FloorColour, MergesWhatOverlapsByMass) {
  FloorColour colour({});
  ColourGaussian g{Vec3(100, 100, 100), 25 * Mat3::Identity(), 100};
  colour.learn({g});
  g.mean = Vec3(104, 100, 100);
  g.mass = 300;
  colour.learn({g});
  ASSERT_EQ(colour.learned().size(), 1U);
  const double kept = 100 * std::exp2(-0.2 / FloorColourOptions{}.mass_half_life_s);
  EXPECT_NEAR(colour.learned()[0].mean.x(), (kept * 100 + 300 * 104) / (kept + 300), 1e-9);
  EXPECT_NEAR(colour.learned()[0].mass, kept + 300, 1e-9);
  g.mean = Vec3(140, 100, 100);
  colour.learn({g});
  EXPECT_EQ(colour.learned().size(), 2U);
}

TEST(FloorColour, ForgetsByHalfInItsHalfLife) {
  FloorColourOptions options;
  options.mass_half_life_s = 60;
  for (const double learn_every_s : {0.2, 1.0, 5.0}) {
    FloorColour colour(options, learn_every_s);
    colour.learn({{Vec3(100, 100, 100), 25 * Mat3::Identity(), 1000}});
    for (int i = 0; i < static_cast<int>(60 / learn_every_s); ++i) {
      colour.learn({});
    }
    EXPECT_NEAR(colour.learned()[0].mass, 500, 1e-6) << learn_every_s;
  }
  // what it was while it was a share of an update
  EXPECT_EQ(std::exp2(-0.2 / FloorColourOptions{}.mass_half_life_s), 0.9995);
}

TEST(FloorColour, NeverNarrowsBelowTheCamerasNoise) {
  FloorColour colour({});
  colour.learn({{Vec3(100, 100, 100), Mat3::Zero(), 1000}});
  EXPECT_NEAR(colour.learned()[0].covariance(0, 0), 4, 1e-9);
  EXPECT_TRUE(std::isfinite(colour.log_ratio(Vec3(100, 100, 100))));
}

TEST(FloorColour, ForgetsTheLightestWhenFull) {
  FloorColourOptions options;
  options.learned_max = 2;
  FloorColour colour(options);
  colour.learn({{Vec3(50, 50, 50), 9 * Mat3::Identity(), 100},
                {Vec3(100, 100, 100), 9 * Mat3::Identity(), 1000}});
  colour.learn({{Vec3(200, 200, 200), 9 * Mat3::Identity(), 500}});
  ASSERT_EQ(colour.learned().size(), 2U);
  EXPECT_EQ(colour.learned()[0].mean.x(), 200);
}

TEST(FloorColour, CapsTheMass) {
  FloorColourOptions options;
  options.mass_max = 1000;
  FloorColour colour(options);
  for (int i = 0; i < 10; ++i) {
    colour.learn({{Vec3(50, 50, 50), 9 * Mat3::Identity(), 600}});
  }
  EXPECT_LE(colour.learned()[0].mass, 1000);
}

}  // namespace
}  // namespace panoptes
