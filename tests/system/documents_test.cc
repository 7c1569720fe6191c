// SPDX-License-Identifier: BSD-3-Clause
// Every file that a command leaves and every figure in it is in apps/report/README.md.
#include <algorithm>
#include <cctype>
#include <regex>
#include <set>
#include <sstream>

#include <gmock/gmock.h>

#include "core/io/csv.h"
#include "core/io/file.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::string kFiles = "## Files";

// `a.{b, c}` stands for a.b and a.c.
std::vector<std::string> expanded(const std::string& span) {
  const auto open = span.find('{');
  const auto close = span.find('}');
  if (open == std::string::npos || close == std::string::npos) {
    return {span};
  }
  std::vector<std::string> all;
  std::string inside = span.substr(open + 1, close - open - 1);
  for (std::size_t from = 0; from <= inside.size();) {
    const std::size_t to = std::min(inside.find(", ", from), inside.size());
    all.push_back(span.substr(0, open) + inside.substr(from, to - from) + span.substr(close + 1));
    from = to + 2;
  }
  return all;
}

// Whatever stands between backquotes.
std::set<std::string> names_in(const std::string& text) {
  std::set<std::string> names;
  static const std::regex kSpan("`([^`\n]+)`");
  for (std::sregex_iterator at(text.begin(), text.end(), kSpan), end; at != end; ++at) {
    for (const std::string& name : expanded((*at)[1])) {
      names.insert(name);
    }
  }
  return names;
}

// `<camera>` stands for any name.
bool is_among(const std::set<std::string>& names, const std::string& name) {
  return std::any_of(names.begin(), names.end(), [&](const std::string& pattern) {
    std::string expression;
    for (std::size_t i = 0; i < pattern.size(); ++i) {
      if (pattern[i] == '<') {
        expression += "[^/]+";
        i = std::min(pattern.find('>', i), pattern.size() - 1);
      } else {
        expression += std::isalnum(static_cast<unsigned char>(pattern[i])) != 0 || pattern[i] == '_'
                          ? std::string(1, pattern[i])
                          : std::string("[") +
                                (pattern[i] == '[' || pattern[i] == ']' ? "\\" : "") + pattern[i] +
                                "]";
      }
    }
    return std::regex_match(name, std::regex(expression));
  });
}

// a.b[].c of every value.
void flatten(const json& value, const std::string& path, std::set<std::string>& into) {
  if (value.is_object()) {
    for (const auto& [key, inner] : value.items()) {
      flatten(inner, path + (path.empty() ? "" : ".") + key, into);
    }
  } else if (value.is_array() && !value.empty() && value.front().is_object()) {
    for (const json& inner : value) {
      flatten(inner, path + "[]", into);
    }
  } else {
    into.insert(path);
  }
}

class Documents : public SystemTest {
 protected:
  Documents() : page_(read_file(fs::path(PANOPTES_SOURCE_DIR) / "apps" / "report" / "README.md")) {
    std::istringstream lines(page_);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("| `")) {
        const std::set<std::string> first = names_in(line.substr(0, line.find(" | ")));
        figures_.insert(first.begin(), first.end());
      }
    }
  }

  // Where the page first names it, as it is or with `<camera>` for a camera's name.
  std::size_t place_of(const std::string& file) const {
    static const std::regex kPattern("`([^`\n]*<[^`\n]*)`");
    const std::size_t at = page_.find('`' + file + '`');
    for (std::sregex_iterator span(page_.begin(), page_.end(), kPattern), end;
         at == std::string::npos && span != end; ++span) {
      if (is_among({(*span)[1]}, file)) {
        return static_cast<std::size_t>(span->position());
      }
    }
    return at;
  }

  // In the words of the page that tell of a file: its row, or its paragraph.
  std::string about(const std::string& file) const {
    const std::size_t at = place_of(file);
    const std::size_t end = page_.find(page_[page_.rfind('\n', at) + 1] == '|' ? "\n" : "\n\n", at);
    return page_.substr(at, end - at);
  }

  void expect_figures(const fs::path& metrics_json) const {
    std::set<std::string> keys;
    flatten(json::parse(read_file(metrics_json)), "", keys);
    for (const std::string& key : keys) {
      EXPECT_TRUE(is_among(figures_, key)) << key << " of " << metrics_json;
    }
  }

  // From these words on, up to the next heading or command.
  std::string part(const std::string& from) const {
    const std::size_t at = page_.find(from);
    return page_.substr(at, std::min(page_.find("\n## ", at), page_.find("\n**", at)) - at);
  }

  void expect_documented(const std::string& out, const std::string& section) const {
    const fs::path run = folder_ / "work" / out;
    const std::set<std::string> names = names_in(section);
    for (const auto& entry : fs::recursive_directory_iterator(run)) {
      const std::string name = fs::relative(entry.path(), run).string();
      if (!entry.is_regular_file() || name.starts_with("mav0/")) {
        continue;
      }
      EXPECT_TRUE(is_among(names, name)) << name;
      if (name == "metrics.json") {
        expect_figures(entry.path());
      } else if (entry.path().extension() == ".csv" && name != "things.csv") {
        const std::set<std::string> told = names_in(about(name));
        for (const std::string& column : read_csv(entry.path()).columns) {
          EXPECT_TRUE(told.contains(column)) << column << " of " << name;
        }
      }
    }
  }

  std::string page_;
  std::set<std::string> figures_;  ///< of all tables
};

TEST_F(Documents, TellOfEverythingThatARunLeaves) {
  ASSERT_EQ(explore(kOffice, "run",
                    {"--set", "platform.start={x_m: 4.95, y_m: 4.0, theta_deg: -90}", "--set",
                     "drive={route: {waypoints: [{x_m: 4.95, y_m: 1.2}, {x_m: 4.95, y_m: 4.0}, "
                     "{x_m: 4.95, y_m: 1.2}]}}",
                     "--set", "places={histogram: [grey], distance: [emd], pictures: [front]}",
                     "--set", "require=[\"collisions == 0\"]"})
                .status,
            0);
  expect_documented("run", part(kFiles));
  EXPECT_TRUE(metrics("run")["loops"].contains("pose_error"));
}

TEST_F(Documents, TellOfGoals) {
  panoptes({"navigate", kOffice, "--quiet", "--goals", "0.4,1.2; 1,0", "--duration", "60", "--set",
            "platform.start={x_m: 4.95, y_m: 4.0, theta_deg: -90}", "--out", "goals"});
  expect_documented("goals", part(kFiles));
  const auto goals = metrics("goals")["goals"];
  ASSERT_EQ(goals.size(), 2U);
  EXPECT_TRUE(goals[0].contains("why"));
  EXPECT_TRUE(goals[1].contains("path_m"));
  EXPECT_TRUE(goals[1].contains("shortest_m"));
}

TEST_F(Documents, TellOfRecordingsAndReplays) {
  ASSERT_EQ(panoptes({"record", kOffice, "--quiet", "--out", "data", "--duration", "2", "--depth",
                      "--labels"})
                .status,
            0);
  expect_documented("data", part(kFiles) + part("**record**"));
  explore("data", "again", {"--set", "navigator.driver.lookahead_m=0.3"});
  expect_documented("again", part(kFiles));
  const std::set<std::string> names = names_in(part("**record**"));
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "work" / "data" / "mav0")) {
    const std::string name = fs::relative(entry.path(), folder_ / "work" / "data" / "mav0");
    const auto folder = entry.path().parent_path().filename().string();
    EXPECT_TRUE(!entry.is_regular_file() || is_among(names, name) ||
                is_among(names, entry.path().filename()))
        << name;
  }
}

TEST_F(Documents, TellOfRobotsAtTheEndOfAWire) {
  ASSERT_EQ(explore(kScenes + "missions/wire-office.yaml", "wire",
                    {"--duration", "3", "--set", "require=[]"})
                .status,
            0);
  expect_documented("wire", part(kFiles));
  EXPECT_TRUE(metrics("wire").contains("devices"));
  ASSERT_EQ(panoptes({"serve", kOffice, "--quiet", "--port", "0", "--duration", "1", "--out", "s"})
                .status,
            0);
  expect_documented("s", part("**serve**"));
}

TEST_F(Documents, TellOfTrials) {
  panoptes({"trials", kOffice, "--seeds", "1-2", "--vary", "navigator.driver.lookahead_m=0.3,0.4",
            "--duration", "1", "--quiet", "--out", "t"});
  expect_figures(folder_ / "work" / "t" / "metrics.json");
  for (const auto& entry : fs::directory_iterator(folder_ / "work" / "t")) {
    EXPECT_TRUE(entry.is_directory() ||
                is_among(names_in(part("**trials**")), entry.path().filename()));
  }
}

TEST_F(Documents, TellOfStudies) {
  const std::string study =
      write("study.yaml", "missions: [{name: office, mission: " + kOffice +
                              "}]\nrigs: [{name: as it is}, {name: again}]\nrungs: [{name: none}]\n"
                              "scores: [{most: distance_m}, {least: keyframes}]\n");
  panoptes(
      {"trials", "--study", study, "--seeds", "1", "--duration", "1", "--quiet", "--out", "s"});
  const fs::path out = folder_ / "work" / "s";
  expect_figures(out / "metrics.json");
  for (const auto& entry : fs::directory_iterator(out)) {
    EXPECT_TRUE(entry.is_directory() ||
                is_among(names_in(part("**trials**")), entry.path().filename()));
  }
  const std::set<std::string> told = names_in(about("study.csv"));
  const std::vector<std::string> columns = read_csv(out / "study.csv").columns;
  for (std::size_t i = 0; i < 6; ++i) {  // the others are figures
    EXPECT_TRUE(told.contains(columns[i])) << columns[i];
  }
}

TEST_F(Documents, TellOfPicturesFromAPose) {
  ASSERT_EQ(panoptes({"render", kOffice, "--pose", "5,4.4,90", "--depth", "--labels", "--out", "r"})
                .status,
            0);
  expect_documented("r", part("**render**"));
  ASSERT_EQ(panoptes({"render", kOffice, "--pose", "2.1,2,0", "--out", "inside"}).status, 0);
  expect_documented("inside", part("**render**"));
}

TEST_F(Documents, TellOfRigsByGeometry) {
  ASSERT_EQ(panoptes({"place", kScenes + "rigs/front-back-floor.yaml",
                      kScenes + "rigs/front-alone.yaml", "--out", "p"})
                .status,
            0);
  expect_documented("p", part("**place**"));
}

TEST_F(Documents, TellOfPlacementStudies) {
  ASSERT_EQ(
      panoptes({"place", kScenes + "placements/floor-camera.yaml", "--quiet", "--out", "q"}).status,
      0);
  expect_figures(folder_ / "work" / "q" / "metrics.json");
  for (const auto& entry : fs::directory_iterator(folder_ / "work" / "q")) {
    EXPECT_TRUE(is_among(names_in(part("**place**")), entry.path().filename())) << entry.path();
  }
  const std::vector<std::string> columns = read_csv(folder_ / "work" / "q" / "study.csv").columns;
  for (const char* column : {"rig", "rank", "verdict", "faults", "pareto"}) {
    EXPECT_TRUE(names_in(page_).contains(column)) << column;
    EXPECT_THAT(columns, testing::Contains(column));
  }
}

TEST_F(Documents, TellOfMapsOfCameras) {
  ASSERT_EQ(panoptes({"record", kScenes + "missions/record-room.yaml", "--duration", "4", "--quiet",
                      "--out", "rose"})
                .status,
            0);
  panoptes(
      {"calibrate", "rose", "--stage", "maps", "--cameras", "ahead", "--quiet", "--out", "maps"});
  expect_documented("maps", part("**calibrate --stage maps**"));
  EXPECT_TRUE(metrics("maps")["cameras"]["ahead"]["map"].contains("adjusted"));
}

TEST_F(Documents, TellOfRelaxationAndPlaces) {
  write("ring.g2o",
        "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_SE2 2 2 0.1 0\n"
        "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n"
        "EDGE_SE2 0 2 2 0 0 1 0 0 1 0 1\n");
  ASSERT_EQ(panoptes({"relax", "ring.g2o", "--robust", "--out", "relaxed.g2o"}).status, 0);
  expect_figures(folder_ / "work" / "relaxed.metrics.json");
  for (const char* ending : {".metrics.json", ".png", ".rejected.csv"}) {
    EXPECT_TRUE(fs::exists(folder_ / "work" / (std::string("relaxed") + ending))) << ending;
    EXPECT_TRUE(names_in(page_).contains(ending)) << ending;
  }
  ASSERT_EQ(panoptes({"record", kOffice, "--quiet", "--out", "data", "--duration", "2"}).status, 0);
  ASSERT_EQ(panoptes({"loops", "data/mav0/front/data", "--quiet", "--out", "loops"}).status, 0);
  expect_figures(folder_ / "work" / "loops" / "metrics.json");
}

}  // namespace
}  // namespace panoptes
