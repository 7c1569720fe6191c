// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <malloc.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/rng.h"
#include "core/graph/pose_graph.h"
#include "core/graph/robust_relax.h"
#include "core/graph/tree_descent.h"
#include "core/loops/loop_closer.h"
#include "core/motion/relative_motion.h"
#include "core/vision/local_features.h"
#include "core/vision/place_signature.h"
#include "core/vision/word_index.h"
#include "tests/core/vision/synthetic_places.h"

namespace panoptes {
namespace {

// Blotches under the noise of a camera: corners everywhere.
cv::Mat busy_picture(Rng rng) {
  cv::Mat blotches(60, 80, CV_8UC3);
  for (int row = 0; row < blotches.rows; ++row) {
    for (int column = 0; column < 3 * blotches.cols; ++column) {
      blotches.ptr<std::uint8_t>(row)[column] = static_cast<std::uint8_t>(60 + rng.index(100));
    }
  }
  cv::Mat picture;
  cv::resize(blotches, picture, cv::Size(320, 240), 0, 0, cv::INTER_CUBIC);
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < 3 * picture.cols; ++column) {
      auto& pixel = picture.ptr<std::uint8_t>(row)[column];
      pixel = cv::saturate_cast<std::uint8_t>(pixel + rng.normal(0, 2));
    }
  }
  return picture;
}

void extract_features(benchmark::State& state) {
  cv::setNumThreads(1);
  const cv::Mat picture = busy_picture(Rng(1));
  for (auto _ : state) {
    benchmark::DoNotOptimize(local_features({}, picture));
  }
}
BENCHMARK(extract_features)->Unit(benchmark::kMillisecond);

void match_two_places(benchmark::State& state) {
  const LoopCameras cameras = testing::front_and_back();
  const testing::SyntheticRoom room(3000, 4, Rng(1));
  const PlaceFeatures a = room.seen_from(cameras, {0, 0, 0}, 0.7, 0.2, Rng(2));
  const PlaceFeatures b = room.seen_from(cameras, {0.2, 0.1, 0.1}, 0.7, 0.2, Rng(3));
  for (auto _ : state) {
    benchmark::DoNotOptimize(match_places({}, a, b, same_facing(cameras)));
  }
  state.counters["points"] = static_cast<double>(a[0].px.size() + a[1].px.size());
}
BENCHMARK(match_two_places)->Unit(benchmark::kMillisecond);

void motion_with_search(benchmark::State& state) {
  const LoopCameras cameras = testing::front_and_back();
  const testing::SyntheticRoom room(2500, 4, Rng(1));
  const PlaceFeatures a = room.seen_from(cameras, {0, 0, 0}, 0.7, 0.3, Rng(2));
  const PlaceFeatures b =
      room.seen_from(cameras, {0.2, 0.1, std::numbers::pi - 0.1}, 0.7, 0.3, Rng(3));
  const auto matches = match_places({}, a, b, facings(cameras)[1]);
  const MotionPrior prior{{0, 0, std::numbers::pi}, Vec3(0.09, 0.09, 0.04).asDiagonal()};
  const PlaceDepths unknown;
  for (auto _ : state) {
    Rng search(4);
    benchmark::DoNotOptimize(motion_by_features({}, {cameras, a, unknown}, {cameras, b, unknown},
                                                matches, prior, &search));
  }
  state.counters["matches"] = static_cast<double>(matches.size());
}
BENCHMARK(motion_with_search)->Unit(benchmark::kMillisecond);

void signature_shortlist(benchmark::State& state) {
  const Facing opposite = facings(testing::front_and_back())[1];
  std::vector<PlaceSignature> places;
  Rng rng(1);
  for (int i = 0; i < state.range(0); ++i) {
    PlaceSignature place;
    place.grid = true;
    place.cumulative.resize(signature_shares(true, 2));
    for (float& share : place.cumulative) {
      share = static_cast<float>(rng.uniform());
    }
    places.push_back(place);
  }
  for (auto _ : state) {
    double nearest = 1e9;
    for (const PlaceSignature& place : places) {
      if (&place != &places[0]) {
        nearest =
            std::min({nearest, emd_grey(place, places[0]), emd_grey(place, places[0], opposite)});
      }
    }
    benchmark::DoNotOptimize(nearest);
  }
}
BENCHMARK(signature_shortlist)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

// A robot that has driven far and then once round a room, and now goes round again, either way.
// Places far away look like any others by their signatures, and the graph has drifted enough that
// many of them might be where it stands.
struct SecondLap {
  LoopCameras cameras = testing::front_and_back();
  testing::SyntheticRoom room{880, 4, Rng(1)};  // 400 points a picture: as many as are kept
  LoopCloser closer{{}, cameras, Rng(2)};
  SharedGraph graph;
  Pose2 T_map_true;
  int keyframes = 0;

  static PlaceSignature signature_at(const Pose2& T_map_body) {
    PlaceSignature signature;
    signature.grid = true;
    signature.cumulative.resize(signature_shares(true, 2));
    for (int i = 0; i < 256; ++i) {
      const double middle = 8 + std::sin(2 * T_map_body.x_m + i / 16) + std::cos(T_map_body.y_m);
      signature.cumulative[i] = static_cast<float>(1 / (1 + std::exp((middle - i % 16) / 2)));
    }
    return signature;
  }

  LoopPlace place(bool seen) const {
    LoopPlace place{signature_at(T_map_true), {}, {}};
    if (seen) {
      place.features =
          room.seen_from(cameras, T_map_true, 0.7, 0.2, Rng(keyframes).fork("features"));
    } else {
      for (LocalFeatures& none : place.features) {
        none.descriptors.create(0, 32, CV_8U);
      }
    }
    return place;
  }

  // The next keyframe's node and edge; its place is still to be taken.
  void drive(const Pose2& step) {
    if (keyframes > 0) {
      T_map_true = T_map_true * step;
      const Mat3 information = Vec3(1 / 9e-6, 1 / 9e-6, 1 / 1e-6).asDiagonal();
      graph.edges.push_back({{keyframes - 1, keyframes, step, information, false}, {}, {}});
      graph.T_map_node.push_back(graph.T_map_node.back() * step);
    } else {
      graph.T_map_node.push_back(T_map_true);
    }
    ++keyframes;
  }

  bool take(LoopPlace place) {
    closer.add(std::move(place), graph);
    const std::vector<ClosureReport> reports = closer.close(graph, {});
    return std::any_of(reports.begin(), reports.end(),
                       [](const ClosureReport& report) { return report.accepted; });
  }

  // `before` keyframes on the way to and fro beside the room, then a lap of 64.
  SecondLap(int before, bool opposite) {
    graph.state = RigState::Zero(rig_states(cameras.size()));
    const RigState sigma = RigState::Constant(graph.state.size(), 0.003);
    graph.prior_information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    T_map_true = {-1.25 - 25 * 0.25, -1.25, 0};
    const auto go = [&](const Pose2& step, bool seen) {
      drive(step);
      take(place(seen));
    };
    for (int i = 0; i < before; ++i) {
      const bool turns = i % 50 >= 44;
      go(turns ? Pose2{0, 0, std::numbers::pi / 6} : Pose2{0.25, 0, 0}, false);
    }
    const auto lap = [&](int steps, double corner) {
      for (int i = 0; i < steps; ++i) {
        const bool turns = i % 16 >= 10;
        go(turns ? Pose2{0, 0, corner * std::numbers::pi / 12} : Pose2{0.25, 0, 0}, true);
      }
    };
    T_map_true = {-1.25, -1.25, 0};
    lap(64, 1);
    if (opposite) {
      for (int i = 0; i < 18; ++i) {
        go({0, 0, std::numbers::pi / 12}, true);
      }
    }
    // on, until the next keyframe would close a loop
    for (int i = 0; !closes_next; ++i) {
      const bool turns = i % 16 >= 10;
      const double corner = opposite ? -1 : 1;
      drive(turns ? Pose2{0, 0, corner * std::numbers::pi / 12} : Pose2{0.25, 0, 0});
      next = place(true);
      const LoopCloser before_it = closer;
      const SharedGraph graph_before_it = graph;
      if (take(next)) {
        closer = before_it;
        graph = graph_before_it;
        closes_next = true;
      }
    }
  }

  LoopPlace next;
  bool closes_next = false;
};

// One keyframe of a revisit: shortlist, matched features and their geometry, the graph tried.
void query_that_closes(benchmark::State& state) {
  const SecondLap lap(static_cast<int>(state.range(0)), state.range(1) != 0);
  std::size_t tried = 0;
  for (auto _ : state) {
    state.PauseTiming();
    LoopCloser closer = lap.closer;
    SharedGraph graph = lap.graph;
    LoopPlace now = lap.next;
    state.ResumeTiming();
    closer.add(std::move(now), graph);
    tried = closer.close(graph, {}).size();
  }
  state.counters["pairs"] = static_cast<double>(tried);
}
BENCHMARK(query_that_closes)
    ->ArgNames({"places", "opposite"})
    ->ArgsProduct({{0, 1000, 10000}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

// A lattice of streets walked to and fro, each crossing closed with its neighbour in the next
// street.
PoseGraph streets(int nodes, Rng rng) {
  constexpr int kLength = 25;
  constexpr double kStep_m = 0.25;
  std::vector<Pose2> truth;
  PoseGraph graph;
  const Mat3 information = Vec3(1e5, 1e5, 1e5).asDiagonal();
  const auto add = [&](int from, int to, bool closure) {
    const Pose2 T = truth[from].inverse() * truth[to];
    graph.edges.push_back({from,
                           to,
                           {T.x_m + rng.normal(0, 0.003), T.y_m + rng.normal(0, 0.003),
                            wrap_angle(T.theta_rad + rng.normal(0, 0.003))},
                           information,
                           closure});
  };
  for (int i = 0; i < nodes; ++i) {
    const int street = i / kLength;
    const int along = street % 2 == 0 ? i % kLength : kLength - 1 - i % kLength;
    truth.push_back({along * kStep_m, street * kStep_m, street % 2 == 0 ? 0 : std::numbers::pi});
    if (i > 0) {
      add(i - 1, i, false);
      graph.T_map_node.push_back(graph.T_map_node.back() * graph.edges.back().T_from_to);
    } else {
      graph.T_map_node.push_back(truth[0]);
    }
    if (street > 0 && along % 6 == 3) {
      const int earlier =
          (street - 1) * kLength + ((street - 1) % 2 == 0 ? along : kLength - 1 - along);
      add(earlier, i, true);
    }
  }
  return graph;
}

void relax_from_scratch(benchmark::State& state) {
  const PoseGraph graph = streets(static_cast<int>(state.range(0)), Rng(1));
  for (auto _ : state) {
    PoseGraph copy = graph;
    benchmark::DoNotOptimize(relax(copy));
  }
}
BENCHMARK(relax_from_scratch)->Arg(1000)->Arg(3500)->Arg(10000)->Unit(benchmark::kMillisecond);

void descend_by_tree(benchmark::State& state) {
  const PoseGraph graph = streets(static_cast<int>(state.range(0)), Rng(1));
  for (auto _ : state) {
    PoseGraph copy = graph;
    benchmark::DoNotOptimize(relax_by_tree(copy));
  }
}
BENCHMARK(descend_by_tree)->Arg(1000)->Arg(3500)->Arg(10000)->Unit(benchmark::kMillisecond);

// As many false closures as true ones.
void relax_robustly_among_false(benchmark::State& state) {
  PoseGraph graph = streets(static_cast<int>(state.range(0)), Rng(1));
  Rng rng(2);
  const std::size_t edges = graph.edges.size();
  const int nodes = static_cast<int>(graph.T_map_node.size());
  for (std::size_t e = 0; e < edges; ++e) {
    if (graph.edges[e].closure) {
      GraphEdge lie = graph.edges[e];
      lie.from = rng.index(nodes);
      lie.to = (lie.from + 1 + rng.index(nodes - 1)) % nodes;
      lie.T_from_to = {rng.uniform(-6, 6), rng.uniform(-6, 6),
                       rng.uniform(-std::numbers::pi, std::numbers::pi)};
      graph.edges.push_back(lie);
    }
  }
  for (auto _ : state) {
    PoseGraph copy = graph;
    benchmark::DoNotOptimize(relax_robustly(copy));
  }
}
BENCHMARK(relax_robustly_among_false)
    ->Arg(1000)
    ->Arg(3500)
    ->Arg(10000)
    ->Unit(benchmark::kMillisecond);

void relax_after_one_more_closure(benchmark::State& state) {
  PoseGraph graph = streets(static_cast<int>(state.range(0)), Rng(1));
  GraphEdge last = graph.edges.back();
  graph.edges.pop_back();
  relax(graph);
  graph.edges.push_back(last);
  for (auto _ : state) {
    PoseGraph copy = graph;
    benchmark::DoNotOptimize(relax(copy, RelaxStart::kCurrent));
  }
}
BENCHMARK(relax_after_one_more_closure)->Arg(1000)->Arg(1500)->Unit(benchmark::kMillisecond);

void covariance_of_one_pair(benchmark::State& state) {
  PoseGraph graph = streets(1000, Rng(1));
  relax(graph);
  for (auto _ : state) {
    benchmark::DoNotOptimize(relative_covariance(graph, 40, 990));
  }
}
BENCHMARK(covariance_of_one_pair)->Unit(benchmark::kMillisecond);

void covariance_of_all_paths(benchmark::State& state) {
  PoseGraph graph = streets(static_cast<int>(state.range(0)), Rng(1));
  relax(graph);
  for (auto _ : state) {
    benchmark::DoNotOptimize(path_covariances(graph, static_cast<int>(state.range(0)) - 1));
  }
}
BENCHMARK(covariance_of_all_paths)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

// 400 points a picture and 3000 things to be seen, a third of which change from place to place.
PlaceFeatures words_seen(Rng rng) {
  PlaceFeatures features(2);
  for (LocalFeatures& picture : features) {
    picture.px.resize(400);
    picture.descriptors.create(400, 32, CV_8U);
    for (int row = 0; row < picture.descriptors.rows; ++row) {
      const int thing = rng.index(3000);
      Rng drawn = thing < 1000 ? rng.fork(std::to_string(row)) : Rng(thing);
      std::generate_n(picture.descriptors.ptr(row), picture.descriptors.cols,
                      [&] { return static_cast<std::uint8_t>(drawn.next()); });
    }
  }
  return features;
}

WordIndex index_of(int places) {
  WordIndex index(1000, 2, Rng(1));
  for (int place = 0; place < places; ++place) {
    index.add(words_seen(Rng(place)));
  }
  return index;
}

void words_shortlist(benchmark::State& state) {
  const int places = static_cast<int>(state.range(0));
  const std::size_t before = mallinfo2().uordblks;
  const WordIndex index = index_of(places);
  const std::size_t descriptors = static_cast<std::size_t>(places) * 2 * 400 * 32;
  state.counters["kB_a_place"] =
      static_cast<double>(mallinfo2().uordblks - before - descriptors) / 1000 / places;
  for (auto _ : state) {
    benchmark::DoNotOptimize(index.shared(places / 2, places, facings(testing::front_and_back())));
  }
}
BENCHMARK(words_shortlist)->Arg(1000)->Arg(10000)->Iterations(20)->Unit(benchmark::kMillisecond);

void words_of_one_more_place(benchmark::State& state) {
  const WordIndex index = index_of(1500);
  const PlaceFeatures place = words_seen(Rng(1500));
  for (auto _ : state) {
    state.PauseTiming();
    WordIndex copy = index;
    state.ResumeTiming();
    copy.add(place);
  }
}
BENCHMARK(words_of_one_more_place)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace panoptes

BENCHMARK_MAIN();
