// SPDX-License-Identifier: BSD-3-Clause
#include "core/loops/loop_closer.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "core/motion/local_bundle.h"
#include "core/odometry/wheel_odometry.h"
#include "tests/core/vision/synthetic_places.h"

namespace panoptes {
namespace {

using testing::front_and_back;
using testing::SyntheticRoom;

constexpr double kPi = std::numbers::pi;
constexpr double kBase_m = 0.33;

// The grey of a place changes smoothly with where one stands, and looks alike in many places.
PlaceSignature signature_at(const Pose2& T_map_body) {
  PlaceSignature signature;
  signature.cumulative.resize(signature_shares(false, 2));
  const double middle = 128 + 12 * std::sin(2 * T_map_body.x_m) + 9 * std::cos(3 * T_map_body.y_m);
  for (int grey = 0; grey < 256; ++grey) {
    signature.cumulative[grey] = static_cast<float>(1 / (1 + std::exp((middle - grey) / 20)));
  }
  return signature;
}

struct Drive {
  SharedGraph graph;
  std::vector<Pose2> truth;
  std::vector<ClosureReport> reports;
};

/// What is otherwise than it should be.
struct Otherwise {
  Pose2 T_true_back = {};  // from half the way on the back camera shows what it would from there,
  Pose2 T_carried = {};  // and the robot has been carried so far, which its wheels know nothing of
  std::vector<GraphEdge> besides = {};  // of the graph
  /// Of a keyframe at a pose: the free space around it.
  std::function<std::vector<Vec2>(int keyframe, const Pose2& T_map_body)> contour = {};
  bool looks_first = false;  // by itself, before it closes
};

// The motion from one keyframe to the next, by wheels and pictures.
GraphEdge step_edge(const LoopCameras& cameras, int now, const PlaceFeatures& before,
                    const PlaceFeatures& here, const Pose2& T_wheels, const Mat3& covariance) {
  std::vector<Track> tracks;
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    for (const FeatureMatch& match : match_features({}, before[camera], here[camera])) {
      tracks.push_back({static_cast<int>(camera),
                        {{0, match.a, before[camera].px[match.a].cast<double>()},
                         {1, match.b, here[camera].px[match.b].cast<double>()}}});
    }
  }
  std::vector<BundleFrame> frames(2);
  for (BundleFrame& frame : frames) {
    frame.taken.late_s.assign(cameras.size(), 0);
  }
  frames[1].T_before_here = T_wheels;
  frames[1].covariance = covariance;
  const RigState exact = RigState::Zero(rig_states(cameras.size()));
  const BundleSolution found =
      adjust_bundle({}, cameras, {exact, {}}, frames, tracks, {Pose2{}, T_wheels});
  const Mat3 information = found.information.topLeftCorner<3, 3>();
  return {now - 1, now, found.T_first_frame[1], 0.5 * (information + information.transpose()),
          false};
}

// Round and round a square of 2.5 m in a room of 8 m, every second time the same or the opposite
// way.
Drive around(int rounds, const LoopOptions& options, bool opposite, const SyntheticRoom& first_room,
             const SyntheticRoom& second_room, Rng rng, const Otherwise& otherwise = {}) {
  const LoopCameras cameras = front_and_back();
  const WheelNoise noise;
  LoopCloser closer(options, cameras, rng.fork("closer"));
  Drive drive;
  drive.graph.state = RigState::Zero(rig_states(cameras.size()));
  constexpr double kExact = 1e12;
  drive.graph.prior_information =
      kExact * Eigen::MatrixXd::Identity(drive.graph.state.size(), drive.graph.state.size());
  PlaceFeatures before;
  std::vector<Pose2> steps;
  for (int side = 0; side < 4 * rounds; ++side) {
    const bool back = opposite && side / 4 % 2 == 1;
    if (opposite && side > 0 && side % 4 == 0) {
      for (int turn = 0; turn < 12; ++turn) {
        steps.push_back({0, 0, kPi / 12});  // turns round, so that the other way begins
      }
      for (int turn = 0; turn < 6; ++turn) {
        steps.push_back({0, 0, back ? -kPi / 12 : kPi / 12});
      }
    }
    const double corner = back ? -1 : 1;
    for (int step = 0; step < 10; ++step) {
      steps.push_back({0.25, 0, 0});
    }
    for (int turn = 0; turn < 6; ++turn) {
      steps.push_back({0, 0, corner * kPi / 12});
    }
  }
  drive.truth.push_back({-1.25, -1.25, 0});
  drive.graph.T_map_node.push_back(drive.truth[0]);
  for (std::size_t k = 0; k <= steps.size(); ++k) {
    const SyntheticRoom& room = k < steps.size() / 2 ? first_room : second_room;
    LoopPlace place{signature_at(drive.truth.back()),
                    room.seen_from(cameras, drive.truth.back(), 0.7, 0.2,
                                   rng.fork("sees " + std::to_string(k)))};
    if (k >= steps.size() / 2) {
      place.features[1] = room.seen_from(cameras, drive.truth.back() * otherwise.T_true_back, 0.7,
                                         0.2, rng.fork("sees " + std::to_string(k)))[1];
    }
    if (k > 0) {
      const int now = static_cast<int>(k);
      const Pose2 T_wheels =
          drive.graph.T_map_node[now - 1].inverse() * drive.graph.T_map_node[now];
      const Mat3 covariance = wheel_covariance(noise, kBase_m, T_wheels);
      const GraphEdge edge = step_edge(cameras, now, before, place.features, T_wheels, covariance);
      drive.graph.T_map_node[now] = drive.graph.T_map_node[now - 1] * edge.T_from_to;
      drive.graph.edges.push_back({edge, {}, {}});
      for (const GraphEdge& other : otherwise.besides) {
        if (other.to == now) {
          drive.graph.edges.push_back({other, {}, {}});
        }
      }
    }
    before = place.features;
    const auto contour = [&](int keyframe) {
      return otherwise.contour(keyframe, drive.truth[static_cast<std::size_t>(keyframe)]);
    };
    closer.add(std::move(place), drive.graph);
    const auto contours = otherwise.contour ? ContourSource(contour) : ContourSource();
    if (otherwise.looks_first) {
      closer.look(drive.graph, contours);
    }
    const std::vector<ClosureReport> reports = closer.close(drive.graph, contours);
    drive.reports.insert(drive.reports.end(), reports.begin(), reports.end());
    if (k < steps.size()) {
      const Pose2& step = steps[k];
      const Mat3 root = wheel_covariance(noise, kBase_m, step).llt().matrixL();
      const Vec3 slip = root * Vec3(rng.normal(), rng.normal(), rng.normal());
      drive.truth.push_back(drive.truth.back() * step);
      if (k == steps.size() / 2) {
        drive.truth.back() = drive.truth.back() * otherwise.T_carried;
      }
      drive.graph.T_map_node.push_back(
          drive.graph.T_map_node.back() *
          Pose2{step.x_m + slip.x(), step.y_m + slip.y(), step.theta_rad + slip.z()});
    }
  }
  return drive;
}

Drive twice_round(const LoopOptions& options, bool opposite, const SyntheticRoom& first_room,
                  const SyntheticRoom& second_room, const Rng& rng) {
  return around(2, options, opposite, first_room, second_room, rng);
}

int count_accepted(const Drive& drive) {
  return static_cast<int>(std::count_if(drive.reports.begin(), drive.reports.end(),
                                        [](const ClosureReport& r) { return r.accepted; }));
}

bool is_true(const Drive& drive, const ClosureReport& report) {
  const Pose2 T = drive.truth[report.earlier].inverse() * drive.truth[report.recent];
  return T.position().norm() <= 0.7 &&
         (T.position() - report.T_earlier_recent.position()).norm() < 0.1 &&
         std::abs(wrap_angle(T.theta_rad - report.T_earlier_recent.theta_rad)) < deg_to_rad(1);
}

double worst_m(const Drive& drive) {
  double worst = 0;
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    worst =
        std::max(worst, (drive.truth[i].position() - drive.graph.T_map_node[i].position()).norm());
  }
  return worst;
}

void expect_closed(const Drive& drive, Heading heading) {
  EXPECT_GE(
      std::count_if(drive.reports.begin(), drive.reports.end(),
                    [&](const ClosureReport& r) { return r.accepted && r.heading == heading; }),
      5);
  for (const ClosureReport& report : drive.reports) {
    if (report.accepted) {
      EXPECT_TRUE(is_true(drive, report)) << report.earlier << " " << report.recent;
      const Pose2 T = drive.truth[report.earlier].inverse() * drive.truth[report.recent];
      EXPECT_EQ(report.heading == Heading::kOpposite, std::abs(T.theta_rad) > kPi / 2);
      EXPECT_EQ(report.verdict, "accepted");
    }
  }
  EXPECT_LT(worst_m(drive), 0.1);
}

class SecondRound : public ::testing::TestWithParam<bool> {};

TEST_P(SecondRound, ClosesWhereTheRobotComesBack) {
  const SyntheticRoom room(600, 4, Rng(1));
  expect_closed(twice_round({}, GetParam(), room, room, Rng(2)),
                GetParam() ? Heading::kOpposite : Heading::kSame);
}

TEST_P(SecondRound, ClosesByWords) {
  LoopOptions options;
  options.shortlist = Shortlist::kWords;
  const SyntheticRoom room(600, 4, Rng(1));
  expect_closed(twice_round(options, GetParam(), room, room, Rng(2)),
                GetParam() ? Heading::kOpposite : Heading::kSame);
}

INSTANTIATE_TEST_SUITE_P(SameAndOpposite, SecondRound, ::testing::Values(false, true));

TEST(LoopCloser, ClosesBothHeadingsWhereBothWereDriven) {
  const SyntheticRoom room(600, 4, Rng(1));
  const LoopOptions options;
  const Drive drive = around(3, options, true, room, room, Rng(2));
  const int third_round = static_cast<int>(drive.truth.size()) * 2 / 3;
  const auto closed = [&](Heading heading) {
    return std::count_if(drive.reports.begin(), drive.reports.end(), [&](const ClosureReport& r) {
      return r.accepted && r.heading == heading && r.recent > third_round;
    });
  };
  // 10 m: neither heading keeps the other from what its own spacing allows
  const auto most = static_cast<long>(10 / options.spacing_m);
  EXPECT_GT(closed(Heading::kSame), most / 2);
  EXPECT_GT(closed(Heading::kOpposite), most / 2);
}

TEST(LoopCloser, RefusesAPlaceThatOnlyLooksAlikeAtAGlance) {
  // the second round meets the same greys in another room
  const Drive drive =
      twice_round({}, false, SyntheticRoom(600, 4, Rng(1)), SyntheticRoom(600, 4, Rng(3)), Rng(2));
  EXPECT_FALSE(drive.reports.empty());
  EXPECT_EQ(count_accepted(drive), 0);
}

TEST(LoopCloser, RefusesWhereFrontAndBackContradictEachOther) {
  const SyntheticRoom room(600, 4, Rng(1));
  const Drive drive = around(2, {}, false, room, room, Rng(2), {.T_true_back = {0.2, -0.2, 0.06}});
  EXPECT_EQ(count_accepted(drive), 0);
  EXPECT_TRUE(std::any_of(drive.reports.begin(), drive.reports.end(), [](const ClosureReport& r) {
    return r.verdict.starts_with("cameras: front and back are ");
  }));
}

int refused(const Drive& drive, const std::string& by) {
  return static_cast<int>(std::count_if(
      drive.reports.begin(), drive.reports.end(),
      [&](const ClosureReport& r) { return !r.accepted && r.verdict.starts_with(by); }));
}

// Carried to where the graph is sure that it is not.
TEST(LoopCloser, RefusesAPlaceWhereTheGraphDoesNotExpectIt) {
  const SyntheticRoom room(600, 4, Rng(1));
  const Drive drive = around(2, {}, false, room, room, Rng(2), {.T_carried = {-0.3, 0.45, 0}});
  EXPECT_EQ(count_accepted(drive), 0);
  EXPECT_GT(refused(drive, "gate: "), 5);
  for (const ClosureReport& report : drive.reports) {
    EXPECT_FALSE(report.verdict.starts_with("gate: ") &&
                 report.gate_sigma * report.gate_sigma < 14.15)
        << report.verdict;
  }
}

// What is seen tens of metres away is seen the same from beside.
TEST(LoopCloser, RefusesAPoseThatIsKnownTooVaguely) {
  VerifiedMethod strict;
  strict.max_sigma_m = 0.005;
  LoopOptions options;
  options.method = strict;
  for (const double half_side_m : {3.0, 60.0}) {
    const SyntheticRoom room(600, half_side_m, Rng(1));
    const Drive drive = around(2, options, false, room, room, Rng(2));
    EXPECT_EQ(count_accepted(drive) > 0, half_side_m < 10) << half_side_m;
    EXPECT_EQ(refused(drive, "features: pose known to ") > 5, half_side_m > 10) << half_side_m;
  }
}

// The closure's own three sigma must keep to the limit, near which one place may be two.
TEST(LoopCloser, RefusesWhatMayBeFartherApartThanOnePlace) {
  VerifiedMethod narrow;
  narrow.tolerance_m = 0.1;
  const SyntheticRoom room(600, 4, Rng(1));
  for (const double sigma_m : {0.01, 0.04}) {
    narrow.min_sigma_m = sigma_m;
    LoopOptions options;
    options.method = narrow;
    const Drive drive = around(2, options, false, room, room, Rng(2));
    const bool surely = 3 * sigma_m < narrow.tolerance_m;
    EXPECT_EQ(count_accepted(drive) > 3, surely) << sigma_m;
    EXPECT_EQ(refused(drive, "place: 0.0") > 3, !surely) << sigma_m;
  }
}

// By how much a graph's chi2 grows with a true closure is itself a chi-square of three degrees of
// freedom: with half of its probability half of the closures go.
TEST(LoopCloser, RefusesWhatMakesTheGraphWorseThanItMay) {
  VerifiedMethod strict;
  strict.chi2_probability = 0.5;
  LoopOptions options;
  options.method = strict;
  options.spacing_m = 0.25;
  const SyntheticRoom room(1200, 4, Rng(1));
  const Drive drive = around(2, options, false, room, room, Rng(2));
  EXPECT_GT(refused(drive, "chi2: grows by "), 3);
  EXPECT_GT(count_accepted(drive), 3);
  for (const ClosureReport& report : drive.reports) {
    EXPECT_EQ(report.verdict.starts_with("chi2: "), report.chi2_growth > 2.366) << report.verdict;
  }
}

// An L of free floor, which is half a metre farther on at the second visit, though the pictures say
// that it is the same place.
TEST(LoopCloser, RefusesWhereTheFreeSpaceContradicts) {
  const SyntheticRoom room(600, 4, Rng(1));
  const std::vector<Vec2> corners{{-2.2, -2.1}, {2.3, -2.1}, {2.3, 0.4},
                                  {0.9, 0.4},   {0.9, 2.2},  {-2.2, 2.2}};
  const auto outline = [&corners](const Pose2& T_map_body, const Vec2& off) {
    constexpr double kEvery_m = 0.02;
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2& from = corners[i];
      const Vec2 along = corners[(i + 1) % corners.size()] - from;
      for (double along_m = 0; along_m < along.norm(); along_m += kEvery_m) {
        points.push_back(T_map_body.inverse() * Vec2(from + off + along_m * along.normalized()));
      }
    }
    return points;
  };
  for (const double off_m : {0.0, 0.5}) {
    const auto contour = [&](int keyframe, const Pose2& T_map_body) {
      return outline(T_map_body, keyframe > 64 ? Vec2(off_m, 0.6 * off_m) : Vec2::Zero());
    };
    const Drive drive = around(2, {}, false, room, room, Rng(2), {.contour = contour});
    EXPECT_EQ(count_accepted(drive) > 0, off_m == 0) << off_m;
    EXPECT_EQ(refused(drive, "contours: fit ") > 5, off_m > 0) << off_m;
  }
}

TEST(LoopCloser, ClosesNothingByAGraphThatKnowsNoNumbers) {
  const SyntheticRoom room(600, 4, Rng(1));
  for (const double broken :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    // the pictures agree, but how far off the graph may be there nobody can tell
    GraphEdge edge{4, 5, {0.25, 0, 0}, Mat3::Identity() * broken, false};
    const Drive drive = around(2, {}, false, room, room, Rng(2), {.besides = {edge}});
    EXPECT_EQ(count_accepted(drive), 0);
  }
}

TEST(LoopCloser, TheThesisRuleIsFooledByGreys) {
  LoopOptions options;
  options.method = HistogramMethod{};
  const Drive drive = twice_round(options, false, SyntheticRoom(600, 4, Rng(1)),
                                  SyntheticRoom(600, 4, Rng(3)), Rng(2));
  EXPECT_GE(count_accepted(drive), 1);
}

// By such a threshold either diagonal would do.
TEST(LoopCloser, TheThesisRuleTakesTheDiagonalThatIsMostAlike) {
  LoopOptions options;
  options.method = HistogramMethod{.threshold_grey = 100};
  const SyntheticRoom room(600, 4, Rng(1));
  const Drive drive = twice_round(options, false, room, room, Rng(2));
  EXPECT_GT(count_accepted(drive), 5);
  for (const ClosureReport& report : drive.reports) {
    EXPECT_LE(report.diagonal_max_grey, diagonal_max_grey(report.matrix, Heading::kSame));
    EXPECT_LE(report.diagonal_max_grey, diagonal_max_grey(report.matrix, Heading::kOpposite));
  }
}

TEST(LoopCloser, GivesTheSameBitsAgain) {
  const SyntheticRoom room(600, 4, Rng(1));
  const Drive a = twice_round({}, true, room, room, Rng(5));
  const Drive b = twice_round({}, true, room, room, Rng(5));
  EXPECT_EQ(a.graph.T_map_node, b.graph.T_map_node);
  ASSERT_EQ(a.reports.size(), b.reports.size());
  for (std::size_t i = 0; i < a.reports.size(); ++i) {
    EXPECT_EQ(a.reports[i].verdict, b.reports[i].verdict);
  }
}

TEST(LoopCloser, LooksAndClosesAsItDoesAtOnce) {
  const SyntheticRoom room(900, 3, Rng(1));
  Otherwise first;
  first.looks_first = true;
  const Drive at_once = around(2, {}, false, room, room, Rng(2));
  const Drive in_two = around(2, {}, false, room, room, Rng(2), first);
  EXPECT_GE(count_accepted(at_once), 1);
  EXPECT_EQ(at_once.graph.T_map_node, in_two.graph.T_map_node);
  EXPECT_EQ(at_once.reports.size(), in_two.reports.size());
}

TEST(DiagonalMax, FollowsTheDiagonalOfItsClass) {
  DistanceMatrix matrix;
  for (auto& row : matrix) {
    row.fill(9);
  }
  for (int k = 0; k < 7; ++k) {
    matrix[k][6 - k] = static_cast<float>(k);
  }
  EXPECT_EQ(diagonal_max_grey(matrix, Heading::kOpposite), 6);
  EXPECT_EQ(diagonal_max_grey(matrix, Heading::kSame), 9);
}

}  // namespace
}  // namespace panoptes
