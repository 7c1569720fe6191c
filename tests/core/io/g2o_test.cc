// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/g2o.h"

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "core/io/file.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using G2o = ScratchTest;
constexpr double kRoundoff = 1e-9;  // of informations up to 1e4, turned there and back

Mat3 random_information(Rng& rng) {
  Mat3 A;
  for (int i = 0; i < 9; ++i) {
    A(i / 3, i % 3) = rng.normal() * 30;
  }
  return A * A.transpose() + Mat3::Identity();
}

TEST_F(G2o, ReadsBackWhatItWrote) {
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
  write_g2o(folder_ / "g.g2o", graph);
  const PoseGraph back = read_g2o(folder_ / "g.g2o");
  ASSERT_EQ(back.T_map_node, graph.T_map_node);
  ASSERT_EQ(back.edges.size(), graph.edges.size());
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    EXPECT_EQ(back.edges[i].from, graph.edges[i].from);
    EXPECT_EQ(back.edges[i].to, graph.edges[i].to);
    EXPECT_EQ(back.edges[i].closure, graph.edges[i].closure);
    EXPECT_EQ(back.edges[i].T_from_to, graph.edges[i].T_from_to);
    EXPECT_TRUE(back.edges[i].information.isApprox(graph.edges[i].information, kRoundoff));
  }
}

TEST_F(G2o, TurnsTheInformationIntoTheFrameOfTheEdgesStart) {
  // `to` is turned a quarter: what g2o calls x of the error is y seen from `from`
  write_file(folder_ / "g.g2o",
             "VERTEX_SE2 10 0 0 0\nVERTEX_SE2 20 1 0 1.5707963267948966\n"
             "EDGE_SE2 10 20 1 0 1.5707963267948966 100 0 0 4 0 9\n");
  const PoseGraph graph = read_g2o(folder_ / "g.g2o");
  const Mat3 expected = Vec3(4, 100, 9).asDiagonal();
  EXPECT_TRUE(graph.edges.at(0).information.isApprox(expected, kRoundoff));
  EXPECT_EQ(graph.edges[0].from, 0);
  EXPECT_EQ(graph.edges[0].to, 1);
}

TEST_F(G2o, ChainsPosesWhereTheFileHasNone) {
  write_file(folder_ / "g.g2o",
             "EDGE_SE2 0 1 1 0 1.5707963267948966 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n");
  const PoseGraph graph = read_g2o(folder_ / "g.g2o");
  ASSERT_EQ(graph.T_map_node.size(), 3U);
  EXPECT_NEAR(graph.T_map_node[2].x_m, 1, kRoundoff);
  EXPECT_NEAR(graph.T_map_node[2].y_m, 1, kRoundoff);
}

TEST_F(G2o, SaysWhichLineIsWrong) {
  const auto message = [&](const std::string& text) -> std::string {
    write_file(folder_ / "g.g2o", text);
    try {
      read_g2o(folder_ / "g.g2o");
    } catch (const IoError& e) {
      return std::string(e.what()).substr((folder_ / "g.g2o").string().size());
    }
    return "no error";
  };
  EXPECT_EQ(message("VERTEX_SE2 0 1 2\n"), ":1: VERTEX_SE2 is followed by id x y theta");
  EXPECT_EQ(message("VERTEX_SE2 0 1 2 0\nVERTEX_SE2 0 1 2 0\n"), ":2: vertex 0 was there before");
  EXPECT_EQ(message("VERTEX_SE2 0 1 x 0\n"), ":1: 'x' is not a number");
  EXPECT_EQ(message("VERTEX_SE2 0.5 1 2 0\n"), ":1: an id is a whole number from 0");
  EXPECT_EQ(message("VERTEX_SE3:QUAT 0 1\n"),
            ":1: unknown kind VERTEX_SE3:QUAT; allowed are VERTEX_SE2, EDGE_SE2 and FIX");
  EXPECT_EQ(message("VERTEX_SE2 0 1 2 0\nEDGE_SE2 0 7 1 0 0 1 0 0 1 0 1\n"),
            ": edge 0 7 joins a vertex that is not there");
  EXPECT_EQ(message("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 2 3 1 0 0 1 0 0 1 0 1\n"),
            ": its edges do not join all of its vertices");
}

}  // namespace
}  // namespace panoptes
