// SPDX-License-Identifier: BSD-3-Clause
// Reads every #include of the tree and fails on one against the arrows of the house.
#include <algorithm>
#include <array>
#include <regex>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/source_tree.h"

namespace panoptes {
namespace {

/// Each may include those before it and itself.
constexpr std::array<std::string_view, 5> kFloors = {"core", "hw", "sim", "apps", "tests"};
constexpr std::array<std::string_view, 16> kRooms = {
    "base",  "geometry", "config", "camera",  "vision", "motion", "odometry", "map",
    "graph", "loops",    "plan",   "explore", "calib",  "nav",    "io",       "eval"};
constexpr std::array<std::string_view, 4> kHwRooms = {"physical", "replay", "pioneer", "standin"};
constexpr std::array<std::string_view, 22> kAppRooms = {
    "process", "command", "step",   "draw",      "relax",     "recognition", "report", "study",
    "teleop",  "mission", "doctor", "pilots",    "listeners", "run",         "serve",  "evaluate",
    "preview", "batch",   "trials", "calibrate", "place",     "check"};
/// What draws, moves and loads the synthetic world.
constexpr std::array<std::string_view, 6> kWorldly = {"GL/",    "GLES",    "box2d/",
                                                      "Box2D/", "assimp/", "embree"};

template <class List>
int place_in(const List& list, std::string_view name) {
  return static_cast<int>(std::find(list.begin(), list.end(), name) - list.begin());
}

std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  std::istringstream words(path);
  for (std::string part; std::getline(words, part, '/');) {
    parts.push_back(part);
  }
  return parts;
}

/// What is wrong with an include between rooms of one floor; empty when nothing is.
template <class Rooms>
std::string room_fault(const Rooms& rooms, const std::vector<std::string>& here,
                       const std::vector<std::string>& there) {
  const int my_room = place_in(rooms, here[1]);
  const int its_room = place_in(rooms, there[1]);
  if (my_room == static_cast<int>(rooms.size()) || its_room == static_cast<int>(rooms.size())) {
    return here[0] + " has no such room";
  }
  if (its_room > my_room) {
    return here[0] + "/" + here[1] + " must not include " + there[0] + "/" + there[1];
  }
  return "";
}

/// What is wrong with one include of one file; empty when nothing is.
std::string fault_of(const std::string& file, const std::string& included, bool in_quotes) {
  const std::vector<std::string> here = parts_of(file);
  const std::vector<std::string> there = parts_of(included);
  const int my_floor = place_in(kFloors, here[0]);
  const int its_floor = place_in(kFloors, there[0]);
  const bool ours = there.size() > 1 && its_floor < static_cast<int>(kFloors.size());
  if (in_quotes != ours) {
    return ours ? "our own headers are included in quotes" : "is not a path from the tree's root";
  }
  if (ours) {
    if (its_floor > my_floor) {
      return here[0] + " must not include " + there[0];
    }
    if (here[0] == "core" && there[0] == "core") {
      return room_fault(kRooms, here, there);
    }
    if (here[0] == "hw" && there[0] == "hw" && there.size() > 2) {
      return here.size() > 2 ? room_fault(kHwRooms, here, there)
                             : "a contract must not know who fulfils it";
    }
    if (here[0] == "apps" && there[0] == "apps" && here.size() > 2) {
      return room_fault(kAppRooms, here, there);
    }
    return "";
  }
  const auto begins = [&](std::string_view start) { return included.starts_with(start); };
  if (my_floor <= place_in(kFloors, "hw") &&
      std::any_of(kWorldly.begin(), kWorldly.end(), begins)) {
    return here[0] + " must not know the synthetic world";
  }
  const bool standard =
      included.find('/') == std::string::npos && included.find('.') == std::string::npos;
  if (file.ends_with(".h") && my_floor <= place_in(kFloors, "sim") && !standard &&
      !begins("Eigen/") && !begins("opencv2/core")) {
    return "a header shows no third party's but Eigen's and opencv2/core's";
  }
  return "";
}

/// All that is wrong in one file, a line each.
std::vector<std::string> faults_in(const std::string& file, const std::string& text) {
  static const std::regex kInclude(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  std::vector<std::string> faults;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch match;
    if (std::regex_search(line, match, kInclude)) {
      const std::string fault = fault_of(file, match[2], match[1] == "\"");
      if (!fault.empty()) {
        faults.push_back(file + ":" + std::to_string(number) + ": " + match[2].str() + ": " +
                         fault);
      }
    }
  }
  return faults;
}

TEST(Includes, PointOneWay) {
  const std::vector<SourceFile> files = source_tree();
  std::vector<std::string> faults;
  for (const SourceFile& file : files) {
    for (const std::string& fault : faults_in(file.name, file.text)) {
      faults.push_back(fault);
    }
  }
  EXPECT_GT(files.size(), 100U) << "the tree was not found";
  EXPECT_THAT(faults, testing::IsEmpty());
}

TEST(Includes, ThatAreFineAreLeftAlone) {
  for (const auto& [file, line] : std::vector<std::pair<std::string, std::string>>{
           {"core/nav/a.h", "#include \"core/map/fusion.h\""},
           {"core/nav/a.h", "#include \"core/nav/b.h\""},
           {"core/nav/a.h", "#include <Eigen/Core>"},
           {"core/nav/a.h", "#include <opencv2/core/mat.hpp>"},
           {"core/nav/a.h", "#include <vector>"},
           {"core/graph/a.cc", "#include <ceres/ceres.h>"},
           {"hw/robot.h", "#include \"core/eval/truth.h\""},
           {"hw/physical/a.h", "#include \"hw/base.h\""},
           {"hw/standin/a.h", "#include \"hw/pioneer/b.h\""},
           {"sim/physics/a.cc", "#include <box2d/box2d.h>"},
           {"apps/run/a.h", "#include \"sim/world/world.h\""},
           {"apps/run/a.h", "#include \"apps/mission/b.h\""},
           {"apps/a.cc", "#include \"apps/trials/b.h\""},
           {"tests/core/a_test.cc", "#include \"tests/support/b.h\""},
           {"core/base/a.cc", "// #includes are \"sim/a.h\""},
       }) {
    EXPECT_THAT(faults_in(file, line + "\n"), testing::IsEmpty());
  }
}

TEST(Includes, AgainstTheArrowsAreFound) {
  const auto fault = [](const std::string& file, const std::string& line) {
    const auto faults = faults_in(file, "\n" + line + "\n");
    return faults.size() == 1 ? faults[0] : "not one fault";
  };
  EXPECT_EQ(fault("core/nav/a.cc", "#include \"core/eval/truth.h\""),
            "core/nav/a.cc:2: core/eval/truth.h: core/nav must not include core/eval");
  EXPECT_EQ(fault("core/nav/a.cc", "#include \"core/io/file.h\""),
            "core/nav/a.cc:2: core/io/file.h: core/nav must not include core/io");
  EXPECT_EQ(fault("core/map/a.cc", "  #  include \"hw/robot.h\""),
            "core/map/a.cc:2: hw/robot.h: core must not include hw");
  EXPECT_EQ(fault("hw/a.cc", "#include \"sim/a.h\""),
            "hw/a.cc:2: sim/a.h: hw must not include sim");
  EXPECT_EQ(fault("hw/physical/a.cc", "#include \"hw/pioneer/b.h\""),
            "hw/physical/a.cc:2: hw/pioneer/b.h: hw/physical must not include hw/pioneer");
  EXPECT_EQ(fault("hw/base.h", "#include \"hw/pioneer/b.h\""),
            "hw/base.h:2: hw/pioneer/b.h: a contract must not know who fulfils it");
  EXPECT_EQ(fault("sim/a.cc", "#include \"apps/a.h\""),
            "sim/a.cc:2: apps/a.h: sim must not include apps");
  EXPECT_EQ(fault("apps/mission/a.cc", "#include \"apps/run/b.h\""),
            "apps/mission/a.cc:2: apps/run/b.h: apps/mission must not include apps/run");
  EXPECT_EQ(fault("apps/run/a.cc", "#include \"apps/b.h\""),
            "apps/run/a.cc:2: apps/b.h: apps has no such room");
  EXPECT_EQ(fault("core/attic/a.cc", "#include \"core/base/time.h\""),
            "core/attic/a.cc:2: core/base/time.h: core has no such room");
  EXPECT_EQ(fault("core/map/a.cc", "#include <GL/osmesa.h>"),
            "core/map/a.cc:2: GL/osmesa.h: core must not know the synthetic world");
  EXPECT_EQ(fault("core/map/a.h", "#include <opencv2/imgproc.hpp>"),
            "core/map/a.h:2: opencv2/imgproc.hpp: a header shows no third party's but Eigen's and "
            "opencv2/core's");
  EXPECT_EQ(fault("sim/physics/a.h", "#include <box2d/box2d.h>"),
            "sim/physics/a.h:2: box2d/box2d.h: a header shows no third party's but Eigen's and "
            "opencv2/core's");
  EXPECT_EQ(fault("core/map/a.cc", "#include <core/map/fusion.h>"),
            "core/map/a.cc:2: core/map/fusion.h: our own headers are included in quotes");
  EXPECT_EQ(fault("core/map/a.cc", "#include \"fusion.h\""),
            "core/map/a.cc:2: fusion.h: is not a path from the tree's root");
}

}  // namespace
}  // namespace panoptes
