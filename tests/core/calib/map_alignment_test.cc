// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/map_alignment.h"

#include <gmock/gmock.h>

#include "tests/support/mapped_rig.h"

namespace panoptes {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

DescribedPoint looking(const std::vector<float>& look) {
  DescribedPoint point;
  point.descriptor = cv::Mat(look, true).reshape(1, 1);
  return point;
}

TEST(AlikePoints, AreThoseThatLookLikeNoOther) {
  const std::vector<DescribedPoint> a{looking({1, 0, 0}), looking({0, 1, 0}), looking({0, 0, 1})};
  std::vector<DescribedPoint> b{looking({0, 0.1F, 0.99F}), looking({0.98F, 0.1F, 0}),
                                looking({0.5F, 0.5F, 0.7F})};
  LooksOptions options;
  options.most_apart = 0.5;
  EXPECT_THAT(alike_points(options, a, b), ElementsAre(Pair(0, 1), Pair(2, 0)));
  options.most_apart = 0.101;  // between those of the two
  EXPECT_THAT(alike_points(options, a, b), ElementsAre(Pair(2, 0)));
  // Another one that looks nearly the same: which of them it is, is not told.
  options.most_apart = 0.5;
  b.push_back(looking({0.98F, 0, 0.11F}));
  EXPECT_THAT(alike_points(options, a, b), ElementsAre(Pair(2, 0)));
}

TEST(AlikePoints, AreTakenOnce) {
  const std::vector<DescribedPoint> a{looking({1, 0.2F}), looking({1, 0.1F})};
  const std::vector<DescribedPoint> b{looking({1, 0}), looking({-1, 0})};
  LooksOptions options;
  options.most_apart = 0.5;
  EXPECT_THAT(alike_points(options, a, b), ElementsAre(Pair(1, 0)));
  EXPECT_THAT(alike_points(options, a, {looking({1, 0})}), IsEmpty())
      << "with no second closest nothing is told";
  EXPECT_THAT(alike_points(options, {}, b), IsEmpty());
}

TEST(AlikePoints, OfBitsAreToldByThoseThatDiffer) {
  const auto bits = [](uchar first) {
    DescribedPoint point;
    point.descriptor = cv::Mat::zeros(1, 32, CV_8U);
    point.descriptor.at<uchar>(0) = first;
    return point;
  };
  EXPECT_THAT(alike_points(LooksOptions::of(FeatureMethod::kOrb), {bits(0b1)},
                           {bits(0b11111111), bits(0b11)}),
              ElementsAre(Pair(0, 1)));
}

class MapsInCommon : public ::testing::Test {
 protected:
  static std::vector<std::vector<DescribedPoint>> described(const MappedScene& scene) {
    std::vector<std::vector<DescribedPoint>> maps;
    KeyframeBundleOptions every;
    every.keyframes.every = 10;
    every.adjust_lens = false;
    for (const MappedCamera& camera : mapped_cameras(cameras_about(2), scene, Rng(5))) {
      const AdjustedMap adjusted =
          adjust_map(every, camera.map.lens, camera.believed.sigma, camera.map);
      maps.push_back(
          described_points(FeatureMethod::kSift, camera.map, adjusted, [](int) -> cv::Mat {
            ADD_FAILURE() << "a point that has its descriptor needs no picture";
            return {};
          }));
    }
    return maps;
  }
};

TEST_F(MapsInCommon, AreAligned) {
  MappedScene scene;
  scene.scale = {1, 3};
  scene.false_looks = 0.4;  // of each: two of three alike points are false
  const auto maps = described(scene);
  EXPECT_GT(maps[0].size(), 100);
  for (const DescribedPoint& point : maps[0]) {
    const double sigma = std::sqrt(point.covariance.trace() / 3);
    EXPECT_GT(sigma, 0.009 * 1.2);  // a hundredth of how far it is
    EXPECT_LT(sigma, 0.2);
  }
  const MapAlignment found =
      align_maps(LooksOptions::of(FeatureMethod::kSift), {}, 0, 1, maps, Rng(1));
  ASSERT_TRUE(found.is_found()) << found.agreed.fault;
  EXPECT_GT(found.alike.size(), 2 * found.agreed.agree.size());
  EXPECT_NEAR(found.agreed.S_a_b.scale * 3, 1, 0.03);
  EXPECT_NEAR(found.far, 2.2, 0.6);
  for (const std::size_t i : found.agreed.agree) {
    const auto& [a, b] = found.alike[i];
    for (int k = 0; k < maps[0][a].descriptor.cols; ++k) {
      EXPECT_EQ(maps[0][a].descriptor.at<float>(k), maps[1][b].descriptor.at<float>(k));
    }
  }
}

TEST_F(MapsInCommon, ThatHaveNothingAreNot) {
  MappedScene scene;
  scene.common = false;
  const MapAlignment found =
      align_maps(LooksOptions::of(FeatureMethod::kSift), {}, 0, 1, described(scene), Rng(1));
  EXPECT_FALSE(found.is_found());
  EXPECT_THAT(found.agreed.fault, ::testing::HasSubstr("look alike in both"));
}

}  // namespace
}  // namespace panoptes
