// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/g2o.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/digits.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

/// The same information seen from axes turned by `angle_rad`.
Mat3 turned(const Mat3& information, double angle_rad) {
  const bool round = information(0, 0) == information(1, 1) && information(0, 1) == 0 &&
                     information(0, 2) == 0 && information(1, 2) == 0;
  if (round) {
    return information;  // exactly, so that a file read and written again is the same file
  }
  Mat3 R = Mat3::Identity();
  R.topLeftCorner<2, 2>() = Pose2{0, 0, angle_rad}.rotation();
  const Mat3 result = R.transpose() * information * R;
  return (result + result.transpose()) / 2;
}

struct RawEdge {
  int from_id;
  int to_id;
  GraphEdge edge;
};

}  // namespace

void write_g2o(const std::filesystem::path& path, const PoseGraph& graph) {
  AtomicFile file(path);
  for (std::size_t i = 0; i < graph.T_map_node.size(); ++i) {
    const Pose2& T = graph.T_map_node[i];
    file.append("VERTEX_SE2 " + std::to_string(i) + " " + shortest(T.x_m) + " " + shortest(T.y_m) +
                " " + shortest(T.theta_rad) + "\n");
  }
  for (const GraphEdge& edge : graph.edges) {
    const Mat3 I = turned(edge.information, edge.T_from_to.theta_rad);
    std::string line = "EDGE_SE2 " + std::to_string(edge.from) + " " + std::to_string(edge.to);
    for (const double value : {edge.T_from_to.x_m, edge.T_from_to.y_m, edge.T_from_to.theta_rad,
                               I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2)}) {
      line += " " + shortest(value);
    }
    file.append(line + "\n");
  }
  file.commit();
}

PoseGraph read_g2o(const std::filesystem::path& path) {
  std::istringstream text(read_file(path));
  std::map<int, Pose2> vertices;
  std::vector<RawEdge> edges;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    std::istringstream words(line);
    std::string kind;
    if (!(words >> kind) || kind.front() == '#' || kind == "FIX") {
      continue;
    }
    const auto fault = [&](const std::string& what) {
      return IoError(path.string() + ":" + std::to_string(number) + ": " + what);
    };
    std::vector<double> values;
    for (std::string word; words >> word;) {
      const std::optional<double> value = parse_number(word);
      if (!value) {
        throw fault("'" + word + "' is not a number");
      }
      values.push_back(*value);
    }
    const auto id = [&](double value) {
      constexpr double kMost = 2147483647;
      if (value != std::floor(value) || value < 0 || value > kMost) {
        throw fault("an id is a whole number from 0");
      }
      return static_cast<int>(value);
    };
    if (kind == "VERTEX_SE2") {
      if (values.size() != 4) {
        throw fault("VERTEX_SE2 is followed by id x y theta");
      }
      if (!vertices.emplace(id(values[0]), Pose2{values[1], values[2], wrap_angle(values[3])})
               .second) {
        throw fault("vertex " + std::to_string(id(values[0])) + " was there before");
      }
    } else if (kind == "EDGE_SE2") {
      if (values.size() != 11) {
        throw fault(
            "EDGE_SE2 is followed by two ids, dx dy dtheta and the upper half of the information");
      }
      GraphEdge edge;
      edge.T_from_to = {values[2], values[3], wrap_angle(values[4])};
      Mat3 I;
      I << values[5], values[6], values[7], values[6], values[8], values[9], values[7], values[9],
          values[10];
      edge.information = turned(I, -edge.T_from_to.theta_rad);
      edges.push_back({id(values[0]), id(values[1]), edge});
    } else {
      throw fault("unknown kind " + kind + "; allowed are VERTEX_SE2, EDGE_SE2 and FIX");
    }
  }
  const bool poses_given = !vertices.empty();
  if (!poses_given) {
    for (const RawEdge& raw : edges) {
      vertices.emplace(raw.from_id, Pose2{});
      vertices.emplace(raw.to_id, Pose2{});
    }
  }
  PoseGraph graph;
  std::map<int, int> index;
  for (const auto& [id, T_map_node] : vertices) {
    index.emplace(id, static_cast<int>(graph.T_map_node.size()));
    graph.T_map_node.push_back(T_map_node);
  }
  for (const RawEdge& raw : edges) {
    const auto from = index.find(raw.from_id);
    const auto to = index.find(raw.to_id);
    if (from == index.end() || to == index.end()) {
      throw IoError(path.string() + ": edge " + std::to_string(raw.from_id) + " " +
                    std::to_string(raw.to_id) + " joins a vertex that is not there");
    }
    GraphEdge edge = raw.edge;
    edge.from = from->second;
    edge.to = to->second;
    edge.closure = std::abs(edge.to - edge.from) != 1;
    graph.edges.push_back(edge);
  }
  if (!poses_given) {
    std::vector<bool> placed(graph.T_map_node.size(), false);
    if (!placed.empty()) {
      placed[0] = true;
    }
    for (bool any = true; any;) {  // each sweep places what an edge joins to something placed
      any = false;
      for (const GraphEdge& edge : graph.edges) {
        const auto from = static_cast<std::size_t>(edge.from);
        const auto to = static_cast<std::size_t>(edge.to);
        if (placed[from] == placed[to]) {
          continue;
        }
        if (placed[from]) {
          graph.T_map_node[to] = graph.T_map_node[from] * edge.T_from_to;
        } else {
          graph.T_map_node[from] = graph.T_map_node[to] * edge.T_from_to.inverse();
        }
        placed[from] = placed[to] = true;
        any = true;
      }
    }
    if (std::find(placed.begin(), placed.end(), false) != placed.end()) {
      throw IoError(path.string() + ": its edges do not join all of its vertices");
    }
  }
  return graph;
}

}  // namespace panoptes
