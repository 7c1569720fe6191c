// SPDX-License-Identifier: BSD-3-Clause
// MonoSLAM of one camera, by how many points its state holds: pictures of 640 x 480 of a room with
// blotches all over, a camera that goes to and fro and turns on. What finds new points is included,
// drawing the pictures is not.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/base/rng.h"
#include "core/calib/keyframe_bundle.h"
#include "core/calib/mono_map.h"
#include "core/calib/mono_slam.h"
#include "core/camera/mounting.h"
#include "tests/support/room_pictures.h"

namespace panoptes {
namespace {

constexpr double kRate_hz = 15;

/// Half a metre to the right and back, then on by an eighth of a turn, and so on.
Pose3 driven(double t_s) {
  constexpr double kLeg_s = 6;
  constexpr double kOut_s = 4;
  const double leg = std::floor(t_s / kLeg_s);
  const double in_s = t_s - leg * kLeg_s;
  const auto eased = [](double share) { return (1 - std::cos(share * std::numbers::pi)) / 2; };
  const double out_m = in_s < kOut_s ? 0.5 * eased(2 * in_s / kOut_s) : 0;
  const double turned = leg + (in_s < kOut_s ? 0 : eased((in_s - kOut_s) / (kLeg_s - kOut_s)));
  const Eigen::Quaterniond turn = turned_by(Vec3(0, turned * std::numbers::pi / 4, 0));
  return {turn, turn * Vec3(out_m, 0.1, 0.15)};
}

struct Painted {
  Intrinsics lens = lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});
  RoomPainter room{lens, 120, Rng(3)};
  Rng noise{4};
  std::vector<cv::Mat> pictures;

  const cv::Mat& picture(std::size_t i) {
    while (pictures.size() <= i) {
      pictures.push_back(room.draw(driven(static_cast<double>(pictures.size()) / kRate_hz), noise));
    }
    return pictures[i];
  }
};

Painted& painted() {
  static Painted all;
  return all;
}

MonoSlamOptions known_as_by_a_board() {
  MonoSlamOptions options;
  options.filter.focal_ratio = 0.001;
  options.filter.centre_px = 0.3;
  return options;
}

void one_picture(benchmark::State& state) {
  Painted& all = painted();
  MonoSlam slam(known_as_by_a_board(), all.lens);
  std::size_t next = 0;
  const auto step = [&](MonoSlam& with, std::size_t i) {
    return with.step(all.picture(i), time_at(static_cast<double>(i) / kRate_hz));
  };
  while (slam.points().size() < static_cast<std::size_t>(state.range(0))) {
    step(slam, next++);
  }
  constexpr std::size_t kPictures = 15;
  all.picture(next + kPictures);
  double points = 0;
  double measured = 0;
  for (auto _ : state) {
    state.PauseTiming();
    MonoSlam copy = slam;
    state.ResumeTiming();
    for (std::size_t i = 0; i < kPictures; ++i) {
      const MonoSlamStep told = step(copy, next + i);
      points += static_cast<double>(copy.points().size());
      measured += told.dof / 2.0;
    }
  }
  const double steps = static_cast<double>(state.iterations()) * kPictures;
  state.counters["points"] = points / steps;
  state.counters["measured"] = measured / steps;
  state.counters["pictures_per_s"] = benchmark::Counter(steps, benchmark::Counter::kIsRate);
}
BENCHMARK(one_picture)->Arg(30)->Arg(60)->Arg(100)->Arg(200)->Unit(benchmark::kMillisecond);

void adjust_keyframes(benchmark::State& state) {
  Painted& all = painted();
  MonoSlam slam(known_as_by_a_board(), all.lens);
  MonoMapBuilder builder;
  constexpr int kPictures = 800;
  for (std::size_t i = 0; i < kPictures; ++i) {
    const Time stamp = time_at(static_cast<double>(i) / kRate_hz);
    builder.add(stamp, slam.step(all.picture(i), stamp));
  }
  const MonoMap map = builder.map(slam);
  KeyframeBundleOptions options;
  options.keyframes.every = kPictures / static_cast<int>(state.range(0));
  CameraSigmas known;
  known.focal_ratio = 0.001;
  known.centre_px = 0.3;
  AdjustedMap adjusted;
  for (auto _ : state) {
    adjusted = adjust_map(options, all.lens, known, map);
  }
  state.counters["keyframes"] = static_cast<double>(adjusted.keyframes.size());
  state.counters["observations"] = adjusted.observations;
}
BENCHMARK(adjust_keyframes)->Arg(60)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace panoptes

BENCHMARK_MAIN();
