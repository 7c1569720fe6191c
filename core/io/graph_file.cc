// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/graph_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/io/digits.h"
#include "core/io/file.h"
#include "core/io/g2o.h"

namespace panoptes {
namespace {

constexpr double kFarthest_m = 1e9;        // farther, nothing of a robot's graph lies
constexpr double kMostInformation = 1e18;  // a nanometre; more overflows where it is squared
constexpr std::size_t kMostFaults = 10;    // told at once

enum class Format { kG2o, kToro };

struct Kind {
  const char* word;
  Format format;
  enum class Of { kVertex, kEdge, kNothing } of;
};
constexpr std::array<Kind, 8> kKinds{{{"VERTEX_SE2", Format::kG2o, Kind::Of::kVertex},
                                      {"EDGE_SE2", Format::kG2o, Kind::Of::kEdge},
                                      {"FIX", Format::kG2o, Kind::Of::kNothing},
                                      {"VERTEX2", Format::kToro, Kind::Of::kVertex},
                                      {"EDGE2", Format::kToro, Kind::Of::kEdge},
                                      {"VERTEX", Format::kToro, Kind::Of::kVertex},
                                      {"EDGE", Format::kToro, Kind::Of::kEdge},
                                      {"EQUIV", Format::kToro, Kind::Of::kNothing}}};

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

// A word as it can be printed, whatever bytes it holds.
std::string shown(std::string_view word) {
  constexpr std::size_t kMost = 40;
  std::string text(word.substr(0, kMost));
  for (char& c : text) {
    c = c < ' ' || c > '~' ? '?' : c;
  }
  return "'" + text + (word.size() > kMost ? "...'" : "'");
}

struct LineFault {
  std::string what;
};

class Parser {
 public:
  explicit Parser(std::string name) : name_(std::move(name)) {}

  void line(int number, std::string_view text) {
    number_ = number;
    const std::vector<std::string_view> words = words_of(text);
    if (words.empty() || words.front().front() == '#' || faults_.size() >= kMostFaults) {
      return;
    }
    try {
      statement(words);
    } catch (const LineFault& fault) {
      vertex_faulty_ = vertex_faulty_ || words.front().starts_with("VERTEX");
      blame(number, fault.what);
    }
  }

  void ends_without_newline(int number) {
    if (faults_.empty()) {  // else the last line has said what it lacks
      blame(
          number,
          "the file ends within this line, perhaps within a number; if it is whole, end the line");
    }
  }

  GraphFile finish() {
    for (const RawEdge& raw : edges_) {
      for (const int id : {raw.from_id, raw.to_id}) {
        if (!poses_given_) {
          vertices_.emplace(id, Vertex{{}, raw.line});
        } else if (!vertices_.contains(id) && !vertex_faulty_) {
          blame(raw.line, "there is no vertex " + std::to_string(id));
        }
      }
    }
    if (vertices_.empty() && faults_.empty()) {
      blame(std::max(number_, 1), "holds no pose graph: no vertex and no edge");
    }
    refuse();
    GraphFile file;
    file.poses_given = poses_given_;
    std::map<int, int> index;
    for (const auto& [id, vertex] : vertices_) {
      index.emplace(id, static_cast<int>(file.ids.size()));
      file.ids.push_back(id);
      file.graph.T_map_node.push_back(vertex.T_map_node);
    }
    join(index, file.graph);
    refuse();
    PoseGraph reckoned = file.graph;
    if (const std::optional<int> lost = dead_reckon(reckoned)) {
      const int id = file.ids[*lost];
      blame(vertices_.at(id).line, "no edges join vertex " + std::to_string(id) + " to vertex " +
                                       std::to_string(file.ids.front()));
    }
    refuse();
    if (!poses_given_) {
      file.graph = std::move(reckoned);
    }
    file.warnings = std::move(warnings_);
    return file;
  }

 private:
  struct Vertex {
    Pose2 T_map_node;
    int line = 0;
  };
  struct RawEdge {
    int from_id = 0;
    int to_id = 0;
    int line = 0;
    GraphEdge edge;
  };

  void statement(const std::vector<std::string_view>& words) {
    const auto* const kind = std::find_if(kKinds.begin(), kKinds.end(),
                                          [&](const Kind& k) { return words.front() == k.word; });
    if (kind == kKinds.end()) {
      throw LineFault{"unknown kind " + shown(words.front()) +
                      "; allowed are VERTEX_SE2, EDGE_SE2 and FIX, or VERTEX2, EDGE2 and EQUIV"};
    }
    if (format_ && *format_ != kind->format) {
      throw LineFault{std::string(kind->word) + " is of " +
                      (kind->format == Format::kToro ? "TORO, the lines before of g2o"
                                                     : "g2o, the lines before of TORO")};
    }
    format_ = kind->format;
    std::vector<double> values;
    for (std::size_t i = 1; i < words.size(); ++i) {
      const std::optional<double> value = parse_number(words[i]);
      if (!value) {
        throw LineFault{shown(words[i]) + " is not a finite number"};
      }
      values.push_back(*value);
    }
    if (kind->of == Kind::Of::kVertex) {
      vertex(kind->word, values);
    } else if (kind->of == Kind::Of::kEdge) {
      edge(kind->word, values);
    } else if (!left_out_) {
      left_out_ = true;
      warning(number_, kind->format == Format::kToro
                           ? "EQUIV lines are left out: no two vertices are made one"
                           : "FIX lines are left out: relaxing holds the vertex of the least id");
    }
  }

  void vertex(const std::string& word, const std::vector<double>& values) {
    if (values.size() != 4) {
      throw LineFault{word + " is followed by id x y theta, here by " +
                      std::to_string(values.size()) + " numbers"};
    }
    const int id = id_of(values[0]);
    const Pose2 T_map_node = pose_of(values, 1);
    poses_given_ = true;
    const auto [at, is_new] = vertices_.emplace(id, Vertex{T_map_node, number_});
    if (!is_new) {
      throw LineFault{"vertex " + std::to_string(id) + " was there before, on line " +
                      std::to_string(at->second.line)};
    }
  }

  void edge(const std::string& word, const std::vector<double>& values) {
    if (values.size() != 11) {
      throw LineFault{word + " is followed by two ids, dx dy dtheta and six numbers of the " +
                      "information, here by " + std::to_string(values.size()) + " numbers"};
    }
    RawEdge raw{id_of(values[0]), id_of(values[1]), number_, {}};
    if (raw.from_id == raw.to_id) {
      throw LineFault{"an edge from vertex " + std::to_string(raw.from_id) + " to itself"};
    }
    raw.edge.T_from_to = pose_of(values, 2);
    // g2o: I11 I12 I13 I22 I23 I33; TORO: I11 I12 I22 I33 I13 I23
    const bool toro = format_ == Format::kToro;
    const double I11 = values[5];
    const double I12 = values[6];
    const double I13 = toro ? values[9] : values[7];
    const double I22 = toro ? values[7] : values[8];
    const double I23 = toro ? values[10] : values[9];
    const double I33 = toro ? values[8] : values[10];
    Mat3 I;
    I << I11, I12, I13, I12, I22, I23, I13, I23, I33;
    const Eigen::LLT<Mat3> llt(I);
    if (llt.info() != Eigen::Success || !(I.inverse().diagonal().minCoeff() > 0)) {
      throw LineFault{"the information is not positive definite"};
    }
    if (I.cwiseAbs().maxCoeff() > kMostInformation ||
        I.inverse().cwiseAbs().maxCoeff() > kMostInformation) {
      throw LineFault{"the information or its inverse has a number above 1e18"};
    }
    raw.edge.information = toro ? I : turned_information(I, -raw.edge.T_from_to.theta_rad);
    edges_.push_back(raw);
  }

  // The edges between nodes instead of ids; tells odometry from closures.
  void join(const std::map<int, int>& index, PoseGraph& graph) {
    std::set<int> has_odometry;  // by the later node
    std::map<std::tuple<int, int, std::array<double, 9>>, int> lines;
    for (const RawEdge& raw : edges_) {
      GraphEdge edge = raw.edge;
      edge.from = index.at(raw.from_id);
      edge.to = index.at(raw.to_id);
      const bool neighbours = std::abs(edge.from - edge.to) == 1;
      edge.closure = !neighbours || !has_odometry.insert(std::max(edge.from, edge.to)).second;
      const Pose2& T = edge.T_from_to;
      const Mat3& I = edge.information;
      const auto [at, is_new] =
          lines.emplace(std::tuple(edge.from, edge.to,
                                   std::array{T.x_m, T.y_m, T.theta_rad, I(0, 0), I(0, 1), I(0, 2),
                                              I(1, 1), I(1, 2), I(2, 2)}),
                        raw.line);
      if (!is_new) {
        const std::string what = "edge " + std::to_string(raw.from_id) + " " +
                                 std::to_string(raw.to_id) + " is a copy of that on line " +
                                 std::to_string(at->second);
        if (neighbours) {
          blame(raw.line, what);
        } else {
          warning(raw.line, what + "; both count");
        }
      }
      graph.edges.push_back(edge);
    }
  }

  static int id_of(double value) {
    constexpr double kMost = 2147483647;
    if (value != std::floor(value) || value < 0 || value > kMost) {
      throw LineFault{"an id is a whole number from 0"};
    }
    return static_cast<int>(value);
  }

  static Pose2 pose_of(const std::vector<double>& values, std::size_t at) {
    if (std::abs(values[at]) > kFarthest_m || std::abs(values[at + 1]) > kFarthest_m ||
        std::abs(values[at + 2]) > kFarthest_m) {
      throw LineFault{"a position or heading beyond 1e9"};
    }
    return {values[at], values[at + 1], wrap_angle(values[at + 2])};
  }

  void blame(int line, const std::string& what) {
    if (faults_.size() < kMostFaults) {
      faults_.push_back(name_ + ":" + std::to_string(line) + ": " + what);
    }
  }
  void warning(int line, const std::string& what) {
    warnings_.push_back(name_ + ":" + std::to_string(line) + ": " + what);
  }
  void refuse() const {
    if (!faults_.empty()) {
      throw ConfigError(faults_);
    }
  }

  std::string name_;
  int number_ = 0;
  std::optional<Format> format_;
  bool left_out_ = false;  // a line that says nothing here
  bool poses_given_ = false;
  bool vertex_faulty_ = false;  // then one that is not there may be the one that was not understood
  std::map<int, Vertex> vertices_;
  std::vector<RawEdge> edges_;
  std::vector<std::string> faults_;
  std::vector<std::string> warnings_;
};

}  // namespace

GraphFile parse_graph(const std::string& name, std::string_view text) {
  text = without_byte_order_mark(text);
  Parser parser(name);
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    parser.line(++number, text.substr(at, end - at));
    at = end + 1;
  }
  if (!text.empty() && text.back() != '\n') {
    parser.ends_without_newline(number);
  }
  return parser.finish();
}

GraphFile read_graph(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw ConfigError(path.string() + ": no such file");
  }
  if (std::filesystem::is_directory(path, ignored)) {
    throw ConfigError(path.string() + ": not a file");
  }
  return parse_graph(path.string(), read_file(path));
}

}  // namespace panoptes
