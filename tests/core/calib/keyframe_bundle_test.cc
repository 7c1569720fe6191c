// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/keyframe_bundle.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

const Intrinsics kLens = lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});
constexpr double kNoise_px = 0.1;

/// A camera 0.2 m before the axis that it turns about, a little more than once, in 60 pictures, and
/// points on walls about it: as a filter may leave them, somewhat off.
struct Room {
  MonoMap map;
  std::vector<Pose3> true_T_map_camera;
  int false_seen = 0;
};

Room room(double off, double false_share, Rng rng) {
  Room out;
  out.map.lens = kLens;
  constexpr int kFrames = 60;
  for (int i = 0; i < kFrames; ++i) {
    const double angle_rad = i * 2.2 * std::numbers::pi / kFrames;
    const Eigen::Quaterniond turn = turned_by(Vec3(0, angle_rad, 0));
    const double out_m = i % 6 == 3 ? 0.5 : 0.2;
    out.true_T_map_camera.push_back({turn, turn * Vec3(0, 0, out_m)});
  }
  const Pose3 T_start = out.true_T_map_camera.front().inverse();
  for (Pose3& T : out.true_T_map_camera) {
    T = T_start * T;
    Pose3 believed = T;
    if (!out.map.frames.empty()) {
      believed.rotation =
          T.rotation * turned_by(off * 0.01 * Vec3(rng.normal(), rng.normal(), rng.normal()));
      believed.translation += off * 0.02 * Vec3(rng.normal(), rng.normal(), rng.normal());
    }
    out.map.frames.push_back(
        {time_at(static_cast<double>(out.map.frames.size())), believed, false});
  }
  for (int number = 0; number < 120; ++number) {
    const double angle_rad = rng.uniform(0, 2 * std::numbers::pi);
    const double far_m = rng.uniform(1.5, 3);
    const Vec3 p(far_m * std::sin(angle_rad), rng.uniform(-1, 1), far_m * std::cos(angle_rad));
    MonoMap::Point point;
    point.number = number;
    point.p_map = p + off * 0.05 * Vec3(rng.normal(), rng.normal(), rng.normal());
    for (std::size_t i = 0; i < out.true_T_map_camera.size(); ++i) {
      const Vec3 p_camera = out.true_T_map_camera[i].inverse() * p;
      if (kLens.sees(p_camera)) {
        Vec2 px = kLens.project(p_camera) + kNoise_px * Vec2(rng.normal(), rng.normal());
        if (rng.uniform() < false_share) {
          px += Vec2(15, -8);
          ++out.false_seen;
        }
        point.seen.push_back({static_cast<int>(i), px});
      }
    }
    out.map.points.push_back(point);
  }
  return out;
}

KeyframeBundleOptions every_picture() {
  KeyframeBundleOptions options;
  options.keyframes.every = 1;
  return options;
}

/// As boards leave a lens.
CameraSigmas well_known() {
  CameraSigmas sigma;
  sigma.focal_ratio = 0.001;
  sigma.centre_px = 0.3;
  return sigma;
}

double worst_turn_deg(const Room& r, const AdjustedMap& adjusted) {
  double worst = 0;
  for (std::size_t i = 0; i < adjusted.keyframes.size(); ++i) {
    const auto frame = static_cast<std::size_t>(adjusted.keyframes[i]);
    worst = std::max(worst, rad_to_deg(adjusted.T_map_camera[i].rotation.angularDistance(
                                r.true_T_map_camera[frame].rotation)));
  }
  return worst;
}

TEST(KeyframeBundle, FindsWhatWasThere) {
  const Room r = room(1, 0, Rng(1));
  const AdjustedMap adjusted = adjust_map(every_picture(), kLens, well_known(), r.map);
  EXPECT_TRUE(adjusted.converged);
  EXPECT_GT(adjusted.rms_before_px, 5);
  const auto told = static_cast<double>(6 * adjusted.keyframes.size() + 3 * adjusted.points.size());
  const double left = std::sqrt(1 - told / (2.0 * adjusted.observations));
  EXPECT_NEAR(adjusted.rms_after_px / (std::sqrt(2.0) * kNoise_px * left), 1, 0.05);
  EXPECT_LT(adjusted.left_out, 0.05 * adjusted.observations);
  constexpr double kWorst_deg = 0.1;  // half a pixel
  EXPECT_LT(worst_turn_deg(r, adjusted), kWorst_deg);
}

TEST(KeyframeBundle, FalseObservationsAreLeftOut) {
  const Room r = room(0.2, 0.05, Rng(2));
  const AdjustedMap adjusted = adjust_map(every_picture(), kLens, well_known(), r.map);
  ASSERT_GT(r.false_seen, 40);
  EXPECT_GE(adjusted.left_out, r.false_seen);
  EXPECT_LT(adjusted.left_out, r.false_seen + 0.05 * adjusted.observations);
  EXPECT_LT(worst_turn_deg(r, adjusted), 0.1);
}

TEST(KeyframeBundle, AWholeTurnTellsTheFocalLength) {
  Room r = room(0.2, 0, Rng(3));
  Intrinsics wrong = kLens;
  wrong.fx_px *= 1.004;
  wrong.fy_px *= 1.004;
  r.map.lens = wrong;
  const AdjustedMap adjusted = adjust_map(every_picture(), wrong, {}, r.map);
  EXPECT_NEAR(adjusted.lens.fx_px / kLens.fx_px, 1, 0.0005);
  // nor where it is told to leave it, or that it is known exactly
  KeyframeBundleOptions held = every_picture();
  held.adjust_lens = false;
  EXPECT_EQ(adjust_map(held, wrong, {}, r.map).lens.fx_px, wrong.fx_px);
  CameraSigmas exact;
  exact.focal_ratio = 0;
  const AdjustedMap by_exact = adjust_map(every_picture(), wrong, exact, r.map);
  EXPECT_TRUE(by_exact.converged);
  EXPECT_EQ(by_exact.lens.fx_px, wrong.fx_px);
}

// A wrong distortion that nothing can mend is taken for a wrong focal length.
TEST(KeyframeBundle, AWholeTurnTellsTheDistortion) {
  Room r = room(0.2, 0, Rng(6));
  Intrinsics wrong = kLens;
  std::get<BrownConrady>(wrong.distortion).k1 += 0.002;
  r.map.lens = wrong;
  CameraSigmas known = well_known();
  known.focal_ratio = 0.002;
  const AdjustedMap adjusted = adjust_map(every_picture(), wrong, known, r.map);
  EXPECT_NEAR(adjusted.lens.fx_px / kLens.fx_px, 1, 0.0003);
  for (const double x : {0.2, 0.4, 0.6}) {  // along the picture, within 0.1 px
    const Vec3 p(x, x / 2, 1);
    EXPECT_LT((adjusted.lens.project(p) - kLens.project(p)).norm(), 0.1);
  }
}

TEST(KeyframeBundle, APictureThatAgreesWithNothingIsLeftOut) {
  Room r = room(0.2, 0, Rng(7));
  for (MonoMap::Point& point : r.map.points) {
    for (MonoMap::Seen& seen : point.seen) {
      seen.px +=
          seen.frame == 0 ? Vec2(20.0 * (point.number % 3), 10.0 * (point.number % 5)) : Vec2(0, 0);
    }
  }
  const AdjustedMap adjusted = adjust_map(every_picture(), kLens, well_known(), r.map);
  ASSERT_FALSE(adjusted.keyframes.empty());
  EXPECT_EQ(adjusted.keyframes.front(), 1);
  EXPECT_EQ(adjusted.keyframes.size(), 59U);
  EXPECT_EQ(adjusted.T_map_camera.size(), 59U);
}

TEST(KeyframeBundle, KeepsTheMapsScale) {
  const Room r = room(0.2, 0, Rng(8));
  const AdjustedMap adjusted = adjust_map(every_picture(), kLens, well_known(), r.map);
  double farthest_m = 0;
  double before_m = 0;
  for (std::size_t i = 0; i < adjusted.keyframes.size(); ++i) {
    const auto frame = static_cast<std::size_t>(adjusted.keyframes[i]);
    const double was_m = r.map.frames[frame].T_map_camera.translation.norm();
    if (was_m > before_m) {
      before_m = was_m;
      farthest_m = adjusted.T_map_camera[i].translation.norm();
    }
  }
  EXPECT_NEAR(farthest_m / before_m, 1, 1e-3);
}

TEST(KeyframeBundle, TheFirstPoseStays) {
  const Room r = room(1, 0, Rng(4));
  const AdjustedMap adjusted = adjust_map(every_picture(), kLens, well_known(), r.map);
  EXPECT_LT(adjusted.T_map_camera.front().translation.norm(), 1e-12);
}

TEST(Keyframes, AreEveryNthOrWhereThingsHaveMoved) {
  const Room r = room(0, 0, Rng(5));
  KeyframeChoice options;
  options.every = 20;
  EXPECT_EQ(keyframes(options, r.map), (std::vector<int>{0, 20, 40}));
  const std::vector<int> by_parallax = keyframes({}, r.map);
  EXPECT_EQ(by_parallax.front(), 0);
  EXPECT_GT(by_parallax.size(), 20U);  // 13 degrees of turn are 80 px
  options = {};
  options.most = 10;
  EXPECT_EQ(keyframes(options, r.map).size(), 10U);
  options = {};
  options.parallax_px = 200;
  options.shared = 0.2;
  EXPECT_LT(keyframes(options, r.map).size(), by_parallax.size() / 2);
}

TEST(KeyframeBundle, OfNothingIsNothing) {
  const AdjustedMap adjusted = adjust_map({}, kLens, {}, {});
  EXPECT_TRUE(adjusted.T_map_camera.empty());
  EXPECT_FALSE(adjusted.converged);
}

}  // namespace
}  // namespace panoptes
