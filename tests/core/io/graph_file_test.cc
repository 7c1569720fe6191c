// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/graph_file.h"

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "core/io/file.h"
#include "core/io/g2o.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using GraphFiles = ScratchTest;
constexpr double kRoundoff = 1e-9;  // of informations up to 1e4, turned there and back

Mat3 random_information(Rng& rng) {
  Mat3 A;
  for (int i = 0; i < 9; ++i) {
    A(i / 3, i % 3) = rng.normal() * 30;
  }
  return A * A.transpose() + Mat3::Identity();
}

std::vector<std::string> faults_of(const std::string& text) {
  try {
    parse_graph("g", text);
  } catch (const ConfigError& e) {
    return e.lines();
  }
  return {};
}

TEST_F(GraphFiles, ReadBackWhatWasWritten) {
  Rng rng(3);
  PoseGraph graph;
  for (int i = 0; i < 5; ++i) {
    graph.T_map_node.push_back({rng.normal(), rng.normal(), rng.uniform(-3, 3)});
  }
  for (int i = 0; i < 4; ++i) {
    graph.edges.push_back({i,
                           i + 1,
                           {rng.normal(), rng.normal(), rng.uniform(-3, 3)},
                           random_information(rng),
                           false});
  }
  graph.edges.push_back({0, 4, {0.1, 0.2, 0.3}, random_information(rng), true});
  write_g2o(folder_ / "g.g2o", graph, {3, 5, 6, 7, 90});
  const GraphFile back = read_graph(folder_ / "g.g2o");
  EXPECT_TRUE(back.poses_given);
  EXPECT_THAT(back.warnings, IsEmpty());
  EXPECT_THAT(back.ids, ElementsAre(3, 5, 6, 7, 90));
  ASSERT_EQ(back.graph.T_map_node, graph.T_map_node);
  ASSERT_EQ(back.graph.edges.size(), graph.edges.size());
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    EXPECT_EQ(back.graph.edges[i].from, graph.edges[i].from);
    EXPECT_EQ(back.graph.edges[i].to, graph.edges[i].to);
    EXPECT_EQ(back.graph.edges[i].closure, graph.edges[i].closure);
    EXPECT_EQ(back.graph.edges[i].T_from_to, graph.edges[i].T_from_to);
    EXPECT_TRUE(back.graph.edges[i].information.isApprox(graph.edges[i].information, kRoundoff));
  }
}

TEST(ParseGraph, TurnsG2osInformationIntoTheFrameOfTheEdgesStart) {
  // `to` is turned a quarter: what g2o calls x of the error is y seen from `from`
  const GraphFile file = parse_graph("g",
                                     "VERTEX_SE2 10 0 0 0\nVERTEX_SE2 20 1 0 1.5707963267948966\n"
                                     "EDGE_SE2 10 20 1 0 1.5707963267948966 100 0 0 4 0 9\n");
  const Mat3 expected = Vec3(4, 100, 9).asDiagonal();
  EXPECT_TRUE(file.graph.edges.at(0).information.isApprox(expected, kRoundoff));
  EXPECT_EQ(file.graph.edges[0].from, 0);
  EXPECT_EQ(file.graph.edges[0].to, 1);
}

TEST(ParseGraph, OrdersTorosInformation) {
  const GraphFile file = parse_graph("g",
                                     "VERTEX2 0 0 0 0\nVERTEX2 1 1 0 1.5707963267948966\n"
                                     "EDGE2 0 1 1 0 1.5707963267948966 100 1 4 9 2 3\n");
  Mat3 expected;
  expected << 100, 1, 2, 1, 4, 3, 2, 3, 9;
  EXPECT_EQ(file.graph.edges.at(0).information, expected);
}

TEST_F(GraphFiles, OfTorosKindHaveTheSameChi2AsG2os) {
  const PoseGraph toro = parse_graph("g",
                                     "VERTEX2 0 0 0 0.2\nVERTEX2 1 1.1 0.4 2\nEQUIV 0 1\n"
                                     "EDGE2 0 1 1 0.1 1.5 100 1 4 9 2 3\n")
                             .graph;
  const Vec3 r(0, 0, 0.3);
  write_g2o(folder_ / "g.g2o", toro);
  const PoseGraph g2o = read_graph(folder_ / "g.g2o").graph;
  EXPECT_GT(chi2(toro), 9 * r.squaredNorm());
  EXPECT_NEAR(chi2(g2o), chi2(toro), kRoundoff * chi2(toro));
}

TEST(ParseGraph, DeadReckonsPosesWhereTheFileHasNone) {
  const GraphFile file = parse_graph(
      "g",
      "EDGE_SE2 0 2 7 7 0 1 0 0 1 0 1\n"
      "EDGE_SE2 0 1 1 0 1.5707963267948966 1 0 0 1 0 1\nEDGE_SE2 2 1 -1 0 0 1 0 0 1 0 1\n");
  EXPECT_FALSE(file.poses_given);
  ASSERT_EQ(file.graph.T_map_node.size(), 3U);
  EXPECT_NEAR(file.graph.T_map_node[2].x_m, 1, kRoundoff);
  EXPECT_NEAR(file.graph.T_map_node[2].y_m, 1, kRoundoff);
}

TEST(ParseGraph, TakesTheFirstEdgeBetweenNeighboursForOdometry) {
  const GraphFile file = parse_graph("g",
                                     "EDGE_SE2 4 3 1 0 0 1 0 0 1 0 1\nEDGE_SE2 3 4 9 0 0 1 0 0 1 0 "
                                     "1\nEDGE_SE2 4 5 1 0 0 1 0 0 1 0 1\n");
  EXPECT_FALSE(file.graph.edges[0].closure);
  EXPECT_TRUE(file.graph.edges[1].closure);
  EXPECT_FALSE(file.graph.edges[2].closure);
}

TEST(ParseGraph, RemarksOnWhatIsOddButNoFault) {
  const std::string edges =
      "EDGE2 0 1 1 0 0 1 0 1 1 0 0\nEDGE2 1 2 1 0 0 1 0 1 1 0 0\n"
      "EDGE2 0 2 1 0 0 1 0 1 1 0 0\n";
  EXPECT_THAT(parse_graph("g", edges).warnings, IsEmpty());
  const GraphFile file = parse_graph("g", edges + "EQUIV 0 2\nEDGE2 0 2 1 0 0 1 0 1 1 0 0\n");
  EXPECT_EQ(file.graph.edges.size(), 4U);
  EXPECT_THAT(file.warnings,
              ElementsAre("g:4: EQUIV lines are left out: no two vertices are made one",
                          "g:5: edge 0 2 is a copy of that on line 3; both count"));
  EXPECT_THAT(
      parse_graph("g", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nFIX 1\nFIX 0\n").warnings,
      ElementsAre("g:2: FIX lines are left out: relaxing holds the vertex of the least id"));
}

TEST(ParseGraph, SaysWhichLineIsWrongAndWhy) {
  const auto fault = [](const std::string& text) {
    const auto faults = faults_of(text);
    return faults.size() == 1 ? faults[0] : std::to_string(faults.size()) + " faults";
  };
  EXPECT_EQ(fault(""), "g:1: holds no pose graph: no vertex and no edge");
  EXPECT_EQ(fault("EDGE2 0 1 1 0 0 1 0 1 1 0 0.12"),
            "g:1: the file ends within this line, perhaps within a number; if it is whole, end the "
            "line");
  EXPECT_EQ(fault("VERTEX_SE2 0 1 2\n"),
            "g:1: VERTEX_SE2 is followed by id x y theta, here by 3 numbers");
  EXPECT_EQ(fault("VERTEX_SE2 0 1 2 0\n\nVERTEX_SE2 0 1 2 0\n"),
            "g:3: vertex 0 was there before, on line 1");
  EXPECT_EQ(fault("VERTEX_SE2 0 1 x 0\n"), "g:1: 'x' is not a finite number");
  EXPECT_EQ(fault("VERTEX_SE2 0 1 nan 0\n"), "g:1: 'nan' is not a finite number");
  EXPECT_EQ(fault("VERTEX_SE2 0 1 inf 0\n"), "g:1: 'inf' is not a finite number");
  EXPECT_EQ(fault("VERTEX_SE2 0 1 1e10 0\n"), "g:1: a position or heading beyond 1e9");
  EXPECT_EQ(fault("VERTEX_SE2 0.5 1 2 0\n"), "g:1: an id is a whole number from 0");
  EXPECT_EQ(fault("VERTEX_SE3:QUAT 0 1\n"),
            "g:1: unknown kind 'VERTEX_SE3:QUAT'; allowed are VERTEX_SE2, EDGE_SE2 and FIX, or "
            "VERTEX2, EDGE2 and EQUIV");
  EXPECT_EQ(fault("VERTEX2 0 0 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"),
            "g:2: EDGE_SE2 is of g2o, the lines before of TORO");
  EXPECT_EQ(fault("VERTEX_SE2 0 1 2 0\nEDGE_SE2 0 7 1 0 0 1 0 0 1 0 1\n"),
            "g:2: there is no vertex 7");
  // the vertex that is not understood is not missed as well
  EXPECT_EQ(fault("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 nan 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"),
            "g:2: 'nan' is not a finite number");
  EXPECT_EQ(fault("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 2 3 1 0 0 1 0 0 1 0 1\n"),
            "g:2: no edges join vertex 2 to vertex 0");
  EXPECT_EQ(fault("EDGE_SE2 0 1 1 0 0 1 0 0 1 0\n"),
            "g:1: EDGE_SE2 is followed by two ids, dx dy dtheta and six numbers of the "
            "information, here by 10 numbers");
  EXPECT_EQ(fault("EDGE_SE2 1 1 1 0 0 1 0 0 1 0 1\n"), "g:1: an edge from vertex 1 to itself");
  EXPECT_EQ(fault("EDGE_SE2 0 1 1 0 0 1 2 0 1 0 1\n"),
            "g:1: the information is not positive definite");
  EXPECT_EQ(fault("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 0\n"),
            "g:1: the information is not positive definite");
  EXPECT_EQ(fault("EDGE_SE2 0 1 1 0 0 1e30 0 0 1 0 1\n"),
            "g:1: the information or its inverse has a number above 1e18");
  EXPECT_EQ(fault("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"),
            "g:2: edge 0 1 is a copy of that on line 1");
}

TEST(ParseGraph, TellsFaultsTogetherUpToTen) {
  EXPECT_THAT(faults_of("VERTEX2 0 0 0\nEDGE2 0 1\nVERTEX2 1 0 0 0\n"),
              ElementsAre("g:1: VERTEX2 is followed by id x y theta, here by 3 numbers",
                          "g:2: EDGE2 is followed by two ids, dx dy dtheta and six numbers of the "
                          "information, here by 2 numbers"));
  std::string rubbish;
  for (int i = 0; i < 100; ++i) {
    rubbish += "\x01\xff\n";
  }
  const auto faults = faults_of(rubbish);
  EXPECT_EQ(faults.size(), 10U);
  EXPECT_THAT(faults.back(), testing::StartsWith("g:10: unknown kind '?\?'"));
}

TEST_F(GraphFiles, ThatAreNotThereAreFaults) {
  EXPECT_THROW(read_graph(folder_ / "no.g2o"), ConfigError);
  EXPECT_THROW(read_graph(folder_), ConfigError);
}

}  // namespace
}  // namespace panoptes
