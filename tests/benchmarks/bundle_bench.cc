// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/graph/shared_graph.h"
#include "core/nav/keyframe_odometry.h"
#include "tests/core/vision/synthetic_places.h"

namespace panoptes {
namespace {

constexpr double kNoise_px = 0.5;
constexpr double kWheels_m = 0.001;
constexpr double kWheels_rad = 0.01;

// What a robot with a front and a back camera sees at keyframes of a path.
struct Walk {
  LoopCameras cameras = testing::front_and_back();
  RigPriorState rig;
  std::vector<BundleFrame> frames;
  std::vector<PlaceFeatures> features;
  double points = 0;  // in a picture

  Walk(const std::vector<Pose2>& steps, int things) {
    const testing::SyntheticRoom room(things, 4, Rng(1));
    const RigState none = RigState::Zero(rig_states(cameras.size()));
    rig = {none, 1e6 * Eigen::MatrixXd::Identity(none.size(), none.size())};
    Rng rng(2);
    Pose2 here;
    for (std::size_t k = 0; k <= steps.size(); ++k) {
      const Pose2 step = k == 0 ? Pose2{} : steps[k - 1];
      here = here * step;
      BundleFrame frame;
      frame.taken.late_s.assign(cameras.size(), 0);
      frame.T_before_here = {step.x_m + rng.normal(0, kWheels_m),
                             step.y_m + rng.normal(0, kWheels_m),
                             step.theta_rad + rng.normal(0, kWheels_rad)};
      frame.covariance = Vec3(kWheels_m, kWheels_m, kWheels_rad).cwiseAbs2().asDiagonal();
      frames.push_back(frame);
      features.push_back(
          room.seen_from(cameras, here, kNoise_px, 0.1, rng.fork("sees " + std::to_string(k))));
      points += static_cast<double>(features.back()[0].px.size() + features.back()[1].px.size()) /
                (2.0 * static_cast<double>(steps.size() + 1));
    }
  }
};

// A drive with half a turn on the spot in it.
std::vector<Pose2> drive_and_turn() {
  std::vector<Pose2> steps;
  for (int k = 0; k < 30; ++k) {
    steps.push_back(k >= 10 && k < 22 ? Pose2{0, 0, 0.26} : Pose2{0.25, 0, 0.02});
  }
  return steps;
}

void keyframe_odometry(benchmark::State& state) {
  const Walk walk(drive_and_turn(), static_cast<int>(state.range(0)));
  for (auto _ : state) {
    KeyframeOdometry odometry({}, {}, walk.cameras);
    for (std::size_t k = 0; k < walk.frames.size(); ++k) {
      benchmark::DoNotOptimize(odometry.add(walk.frames[k], walk.features[k], walk.rig));
      benchmark::DoNotOptimize(odometry.part(walk.rig));
    }
  }
  state.counters["features_a_picture"] = walk.points;
  state.counters["a_keyframe"] = benchmark::Counter(
      static_cast<double>(walk.frames.size()),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(keyframe_odometry)
    ->ArgName("things")
    ->RangeMultiplier(2)
    ->Range(256, 2048)
    ->Unit(benchmark::kMillisecond);

void turn_in_one_bundle(benchmark::State& state) {
  const Walk walk(std::vector<Pose2>(static_cast<std::size_t>(state.range(0)), Pose2{0, 0, 0.26}),
                  1000);
  const KeyframeOdometry odometry({}, {}, walk.cameras);
  JointEdge turn;
  for (std::size_t k = 1; k < walk.frames.size(); ++k) {
    const Pose2 T_first_before = k > 1 ? turn.T_first_node.back() : Pose2{};
    turn.T_first_node.push_back(T_first_before * walk.frames[k].T_before_here);
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        odometry.bundle_again(turn, walk.frames, walk.features, walk.rig, false));
  }
  state.counters["features_a_picture"] = walk.points;
}
BENCHMARK(turn_in_one_bundle)
    ->ArgName("keyframes")
    ->Arg(5)
    ->Arg(10)
    ->Arg(20)
    ->Unit(benchmark::kMillisecond);

// Streets of 25 keyframes driven to and fro, in bundles of five that all depend on the rig a
// little; every sixth keyframe closes with the street before.
SharedGraph streets(int nodes) {
  constexpr int kLength = 25;
  constexpr int kBundle = 5;
  const int states = rig_states(2);
  Rng rng(3);
  std::vector<Pose2> truth;
  for (int i = 0; i < nodes; ++i) {
    const int street = i / kLength;
    const int along = street % 2 == 0 ? i % kLength : kLength - 1 - i % kLength;
    truth.push_back({0.25 * along, 0.25 * street, street % 2 == 0 ? 0 : M_PI});
  }
  const auto measured = [&](int from, int to) {
    const Pose2 T = truth[from].inverse() * truth[to];
    return Pose2{T.x_m + rng.normal(0, 0.002), T.y_m + rng.normal(0, 0.002),
                 wrap_angle(T.theta_rad + rng.normal(0, 0.001))};
  };
  SharedGraph graph;
  graph.T_map_node = truth;
  graph.state = RigState::Zero(states);
  graph.prior_information = 1e4 * Eigen::MatrixXd::Identity(states, states);
  for (int first = 0; first + kBundle < nodes; first += kBundle) {
    JointEdge joint{first, {}, graph.state, {}, Eigen::VectorXd::Zero(3 * kBundle + states)};
    for (int k = 1; k <= kBundle; ++k) {
      joint.T_first_node.push_back(measured(first, first + k));
    }
    joint.information = 2e5 * Eigen::MatrixXd::Identity(3 * kBundle + states, 3 * kBundle + states);
    joint.information.topRightCorner(3 * kBundle, states).setConstant(1e3);
    joint.information.bottomLeftCorner(states, 3 * kBundle).setConstant(1e3);
    graph.joints.push_back(joint);
  }
  graph.T_map_node.resize(graph.joints.back().first + kBundle + 1);
  for (int i = kLength; i < static_cast<int>(graph.T_map_node.size()); ++i) {
    if (i % kLength % 6 == 3) {
      const int earlier = i / kLength * kLength - 1 - i % kLength;
      graph.edges.push_back(
          {{earlier, i, measured(earlier, i), 1e5 * Mat3::Identity(), true}, {}, {}});
    }
  }
  return graph;
}

void graphs_that_double(benchmark::internal::Benchmark* bench) {
  bench->ArgName("keyframes")->Unit(benchmark::kMillisecond);
  for (int keyframes = 300; keyframes <= 2400; keyframes *= 2) {
    bench->Arg(keyframes);
  }
}

void relax_with_one_more_closure(benchmark::State& state) {
  SharedGraph graph = streets(static_cast<int>(state.range(0)));
  const SharedEdge last = graph.edges.back();
  graph.edges.pop_back();
  relax(graph);
  graph.edges.push_back(last);
  for (auto _ : state) {
    SharedGraph copy = graph;
    benchmark::DoNotOptimize(relax(copy));
  }
}
BENCHMARK(relax_with_one_more_closure)->Apply(graphs_that_double);

void shared_uncertainty(benchmark::State& state) {
  SharedGraph graph = streets(static_cast<int>(state.range(0)));
  relax(graph);
  for (auto _ : state) {
    benchmark::DoNotOptimize(SharedUncertainty(graph));
  }
}
BENCHMARK(shared_uncertainty)->Apply(graphs_that_double);

}  // namespace
}  // namespace panoptes

BENCHMARK_MAIN();
