// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "core/io/csv.h"
#include "core/io/file.h"
#include "core/io/g2o.h"
#include "core/io/graph_file.h"
#include "tests/core/graph/random_walk.h"
#include "tests/support/run_here.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Relax : public ScratchTest {
 protected:
  static Said relax(std::vector<std::string> words) {
    words.insert(words.begin(), "relax");
    return run_here(std::move(words));
  }
  json metrics() const { return json::parse(read_file(folder_ / "out/r.metrics.json")); }
};

TEST_F(Relax, WritesTheGraphItsFiguresAndAPicture) {
  const Walk walk = random_walk(200, 20, {}, Rng(1));
  write_g2o(path("g.g2o"), walk.graph);
  const Said said = relax({path("g.g2o"), "--out", path("out/r.g2o")});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr(path("out/r.g2o")));
  const PoseGraph relaxed = read_graph(path("out/r.g2o")).graph;
  const json m = metrics();
  EXPECT_EQ(m["command"], "relax");
  EXPECT_EQ(m["outcome"], "completed");
  EXPECT_EQ(m["nodes"], 200);
  EXPECT_EQ(m["edges"], walk.graph.edges.size());
  EXPECT_EQ(m["edges_rejected"], 0);
  EXPECT_GE(m["solve_s"], 0);
  const double end = m["chi2"]["end"];
  constexpr double kWritten = 1e-6;  // informations are turned on the way
  EXPECT_NEAR(chi2(relaxed), end, kWritten * end);
  EXPECT_GT(m["chi2"]["start"], end);
  EXPECT_GT(std::filesystem::file_size(path("out/r.png")), 1000U);
}

TEST_F(Relax, LeavesFalseClosuresOut) {
  Walk walk = random_walk(200, 20, {}, Rng(2));
  const std::size_t edges = walk.graph.edges.size();
  add_false_closures(walk.graph, 20, 20, Rng(3));
  write_g2o(path("g.g2o"), walk.graph);
  const Said said = relax({path("g.g2o"), "--robust", "--out", path("out/r.g2o")});
  EXPECT_EQ(said.status, 0);
  EXPECT_EQ(metrics()["edges_rejected"], 20);
  const CsvTable rejected = read_csv(path("out/r.rejected.csv"));
  EXPECT_EQ(rejected.columns, (std::vector<std::string>{"from", "to"}));
  ASSERT_EQ(rejected.rows.size(), 20U);
  for (std::size_t i = 0; i < rejected.rows.size(); ++i) {
    const GraphEdge& added = walk.graph.edges[edges + i];
    const std::string from = std::to_string(added.from);
    const std::string to = std::to_string(added.to);
    EXPECT_EQ(rejected.rows[i], (std::vector<std::string>{from, to}));
    const std::string line = "rejected: " + from + " -> " + to + "\n";
    EXPECT_THAT(said.out, i < 10 ? testing::Matcher<std::string>(HasSubstr(line))
                                 : testing::Not(HasSubstr(line)));
  }
  EXPECT_THAT(said.out, HasSubstr("rejected: 10 more, in " + path("out/r.rejected.csv") + "\n"));
  EXPECT_EQ(read_graph(path("out/r.g2o")).graph.edges.size(), edges);
}

TEST_F(Relax, SaysThatItDidNotSettle) {
  Walk walk = random_walk(400, 20, {}, Rng(5));
  add_false_closures(walk.graph, 200, 20, Rng(6));
  write_g2o(path("g.g2o"), walk.graph);
  const Said said = relax({path("g.g2o"), "--out", path("out/r.g2o")});
  EXPECT_EQ(said.status, 1);
  EXPECT_EQ(metrics()["outcome"], "failed");
  EXPECT_THAT(said.err, HasSubstr("g.g2o: did not settle within"));
  EXPECT_THAT(said.err, HasSubstr("--robust"));
}

TEST_F(Relax, ReportsEveryStart) {
  const Walk walk = random_walk(200, 20, {}, Rng(1));
  write_g2o(path("g.g2o"), walk.graph);
  const Said said = relax({path("g.g2o"), "--out", path("out/r.g2o")});
  const json m = metrics();
  EXPECT_EQ(m["best_start"], "file");
  constexpr double kSame = 1e-9;  // two descents to one bottom, of which the file's is kept
  const double least = (1 - kSame) * m["chi2"]["end"].get<double>();
  for (const char* start : {"linear", "file", "tree", "descent"}) {
    EXPECT_TRUE(m["starts"].contains(start)) << start;
    EXPECT_GE(m["starts"][start]["chi2"]["end"], least) << start;
    EXPECT_THAT(said.out, HasSubstr(std::string("from ") + start + ": chi2 "));
  }
  EXPECT_EQ(m["starts"]["file"]["chi2"]["start"], m["chi2"]["start"]);
  EXPECT_THAT(said.out, testing::ContainsRegex("from file: .*, kept\n"));
}

// Closures that agree with each other by odometry, and with nothing else.
void add_false_group(PoseGraph& graph, int from, int to, int count, const Pose2& lie) {
  const std::vector<Pose2>& T = graph.T_map_node;
  const Mat3 information = graph.edges.front().information;
  for (int k = 0; k < count; ++k) {
    const Pose2 T_from_to =
        (T[from].inverse() * T[from + k]).inverse() * lie * (T[to].inverse() * T[to + k]);
    graph.edges.push_back({from + k, to + k, T_from_to, information, true});
  }
}

TEST_F(Relax, SaysThatAResultIsNotToBeTrusted) {
  Walk walk = random_walk(300, 20, {}, Rng(7));
  add_false_group(walk.graph, 20, 250, 10, {15, -9, 1});
  add_false_group(walk.graph, 90, 200, 10, {-11, 4, 2});
  write_g2o(path("g.g2o"), walk.graph);
  const Said said = relax({path("g.g2o"), "--robust", "--out", path("out/r.g2o")});
  EXPECT_EQ(said.status, 1);
  const json m = metrics();
  EXPECT_EQ(m["outcome"], "failed");
  EXPECT_EQ(m["trustworthy"], false);
  EXPECT_GT(m["edges_disagreeing"], 0);
  EXPECT_GT(m["chi2"]["end"], 4.0 * m["freedom"].get<double>());
  EXPECT_THAT(said.err, HasSubstr("g.g2o: not to be trusted: chi2 is "));
  EXPECT_THAT(said.err, HasSubstr(" closures kept disagree with the rest"));
  EXPECT_TRUE(std::filesystem::exists(path("out/r.g2o")));
}

TEST_F(Relax, EndsInTimeWithTheBestSoFar) {
  Walk walk = random_walk(200, 20, {}, Rng(8));
  add_false_closures(walk.graph, 20, 20, Rng(9));
  write_g2o(path("g.g2o"), walk.graph);
  for (const bool robust : {false, true}) {
    std::filesystem::remove_all(path("out"));
    std::vector<std::string> words{path("g.g2o"), "--time-limit", "1e-9", "--out",
                                   path("out/r.g2o")};
    if (robust) {
      words.emplace_back("--robust");
    }
    const Said said = relax(words);
    EXPECT_EQ(said.status, 1);
    EXPECT_EQ(metrics()["end_reason"], "time_limit");
    EXPECT_EQ(metrics()["outcome"], "failed");
    EXPECT_THAT(said.err, HasSubstr("g.g2o: not done within 1e-09 s; what is written is the best"));
    const PoseGraph best = read_graph(path("out/r.g2o")).graph;
    EXPECT_EQ(best.T_map_node.size(), 200U);
    const double end = metrics()["chi2"]["end"];
    EXPECT_NEAR(chi2(best), end, 1e-6 * (1 + end));
  }
  EXPECT_EQ(relax({path("g.g2o"), "--time-limit", "0", "--out", path("out/r.g2o")}).status, 2);
}

TEST_F(Relax, SaysThatTheTreeDescentMadeItWorse) {
  Walk walk = random_walk(200, 20, {}, Rng(1));
  panoptes::relax(walk.graph);
  write_g2o(path("g.g2o"), walk.graph);
  const Said said = relax({path("g.g2o"), "--method", "toro", "--out", path("out/r.g2o")});
  EXPECT_GT(metrics()["chi2"]["end"], metrics()["chi2"]["start"]);
  EXPECT_EQ(said.status, 1);
  EXPECT_EQ(metrics()["outcome"], "failed");
  EXPECT_THAT(said.err, HasSubstr("g.g2o: the tree descent made it worse: chi2 "));
}

TEST_F(Relax, StartsAndDescendsAsAsked) {
  const Walk walk = random_walk(200, 20, {}, Rng(4));
  PoseGraph nowhere = walk.graph;
  for (Pose2& pose : nowhere.T_map_node) {
    pose = {};
  }
  write_g2o(path("g.g2o"), nowhere);
  const Said said =
      relax({path("g.g2o"), "--start", "odometry", "--method", "toro", "--out", path("out/r.g2o")});
  EXPECT_EQ(said.status, 0);
  EXPECT_EQ(metrics()["method"], "toro");
  const double odometry = chi2(walk.graph);
  EXPECT_NEAR(metrics()["chi2"]["start"], odometry, 1e-6 * odometry);
}

TEST_F(Relax, HasNoChi2BeforeWhereTheFileHasNoPoses) {
  write_file(path("g.g2o"),
             "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n"
             "EDGE_SE2 0 2 2.1 0 0 1 0 0 1 0 1\n");
  EXPECT_EQ(relax({path("g.g2o"), "--out", path("out/r.g2o")}).status, 0);
  EXPECT_FALSE(metrics()["chi2"].contains("start"));
}

TEST_F(Relax, RefusesWhatItCannotUseWithStatus2AndWritesNothing) {
  Said said = relax({path("no.g2o"), "--out", path("out/r.g2o")});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, path("no.g2o") + ": no such file\n");
  write_file(path("g.g2o"), "VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 3 1 0 0 1 0 0 1 0 1\n");
  said = relax({path("g.g2o"), "--out", path("out/r.g2o")});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, path("g.g2o") + ":2: there is no vertex 3\n");
  write_file(path("h.g2o"), "EDGE_SE2 5 7 1 0 0 1 0 0 1 0 1\nEDGE_SE2 5 9 1 0 0 1 0 0 1 0 1\n");
  said = relax({path("h.g2o"), "--robust", "--out", path("out/r.g2o")});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, HasSubstr("no edge joins vertices 7 and 9"));
  EXPECT_EQ(relax({path("h.g2o"), "--out", path("h.g2o")}).status, 2);
  EXPECT_EQ(relax({path("h.g2o"), "--out", path("out")}).status, 2);
  EXPECT_EQ(relax({path("h.g2o"), "--out", path("h.g2o") + "/r.g2o"}).status, 2);
  EXPECT_EQ(
      relax({path("h.g2o"), "--robust", "--method", "toro", "--out", path("out/r.g2o")}).status, 2);
  EXPECT_EQ(relax({path("h.g2o"), "--method", "magic", "--out", path("out/r.g2o")}).status, 2);
  EXPECT_FALSE(std::filesystem::exists(path("out")));
}

}  // namespace
}  // namespace panoptes
