// SPDX-License-Identifier: BSD-3-Clause
#include "apps/serve/served_truth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/eval/loops.h"
#include "core/io/csv.h"
#include "core/io/digits.h"
#include "core/io/map_server.h"
#include "core/io/tum.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kPoses = "ground_truth.tum";
constexpr const char* kClearance = "clearance.csv";
constexpr const char* kContacts = "contacts.csv";
constexpr const char* kPlatform = "true_platform.yaml";

GrowingFile begun(const fs::path& file, std::string_view head) {
  GrowingFile made(file);
  if (!head.empty()) {
    made.append(head);
  }
  return made;
}

void write_layer(const fs::path& stem, const TruthLayer& layer) {
  if (layer.cells.empty()) {
    return;
  }
  write_map_server(stem, transformed(layer, [](std::uint8_t cell) {
                     return cell != 0 ? Cell::kOccupied : Cell::kFree;
                   }));
}

TruthLayer read_layer(const fs::path& yaml) {
  std::error_code ignored;
  if (!fs::exists(yaml, ignored)) {
    return {};
  }
  return transformed(read_map_server(yaml), [](Cell cell) {
    return static_cast<std::uint8_t>(cell == Cell::kOccupied ? 1 : 0);
  });
}

// Without the last line where it was cut short, so that no number is taken for another.
std::string whole_lines(const fs::path& file) {
  std::string text = read_file(file);
  text.resize(text.rfind('\n') + 1);  // to nothing where there is none
  return text;
}

// A table whose first line, too, may be cut short.
CsvTable read_grown(const fs::path& file, const std::vector<std::string>& columns) {
  const std::string text = whole_lines(file);
  CsvTable table = parse_csv(file.string(), text.empty() ? csv_row(columns) : text);
  if (table.columns != columns) {
    std::string head = csv_row(columns);
    head.pop_back();
    throw ConfigError(file.string() + ":1: must be " + head);
  }
  return table;
}

const std::vector<std::string> kClearanceColumns = {"stamp_s", "clearance_m"};
const std::vector<std::string> kContactColumns = {"stamp_s", "x_m", "y_m", "object",
                                                  "while_moving"};

double clearance_at(const CsvTable& table, std::size_t row) {
  return table.rows[row][1] == "inf" ? std::numeric_limits<double>::infinity()
                                     : table.number(row, 1);
}

ServedTruth read(const fs::path& folder) {
  ServedTruth served;
  const std::optional<std::int64_t> start = start_unix_ns_of(folder / "metrics.json");
  if (!start) {
    throw ConfigError((folder / "metrics.json").string() +
                      ": start_unix_ns: missing; it must be the wall instant of time 0");
  }
  served.start_unix_ns = *start;
  const std::vector<TumPose> poses =
      parse_tum((folder / kPoses).string(), whole_lines(folder / kPoses));
  const CsvTable clearance = read_grown(folder / kClearance, kClearanceColumns);
  std::vector<Pose2> trajectory;
  for (std::size_t i = 0; i < std::min(poses.size(), clearance.rows.size()); ++i) {
    if (clearance.stamp(i, 0) != poses[i].stamp) {
      throw clearance.fault(i, "stamp_s must be " + seconds(poses[i].stamp) + ", as in " + kPoses +
                                   ", got " + clearance.rows[i][0]);
    }
    TruePose pose;
    pose.stamp = poses[i].stamp;
    pose.T_scene_body = floor_pose(poses[i]);
    pose.clearance_m = clearance_at(clearance, i);
    trajectory.push_back(pose.T_scene_body);
    served.truth.poses.push_back(pose);
  }
  served.truth.path_m = trajectory.empty() ? 0 : path_lengths_m(trajectory).back();
  const CsvTable contacts = read_grown(folder / kContacts, kContactColumns);
  for (std::size_t i = 0; i < contacts.rows.size(); ++i) {
    served.truth.contacts.push_back({contacts.stamp(i, 0),
                                     {contacts.number(i, 1), contacts.number(i, 2)},
                                     contacts.rows[i][3],
                                     contacts.whole(i, 4) != 0});
  }
  std::error_code ignored;
  if (fs::exists(folder / kPlatform, ignored)) {  // who served before has left none
    auto platform = read_settings<TruePlatform>((folder / kPlatform).string());
    served.truth.rig = std::move(platform.rig);
    served.truth.wheels = platform.wheels;
  }
  served.truth.floor = read_layer(folder / "floor.yaml");
  served.truth.body = read_layer(folder / "body.yaml");
  return served;
}

}  // namespace

ServedTruthWriter::ServedTruthWriter(const fs::path& folder, std::int64_t start_unix_ns,
                                     const Truth& first)
    : contacts_csv_(begun(folder / kContacts, csv_row(kContactColumns))),
      clearance_csv_(begun(folder / kClearance, csv_row(kClearanceColumns))),
      poses_tum_(begun(folder / kPoses, {})) {
  const Json metrics{
      {"schema", "panoptes.metrics/1"}, {"command", "serve"}, {"start_unix_ns", start_unix_ns}};
  write_file(folder / "metrics.json", metrics.dump(2) + "\n");
  write_file(folder / kPlatform, write_settings(TruePlatform{first.rig, first.wheels}));
  write_layer(folder / "floor", first.floor);
  write_layer(folder / "body", first.body);
  add(first);
}

// A contact first, so that none is lost; a pose last, so that one that is there has all it needs.
void ServedTruthWriter::add(const Truth& news) {
  for (const TrueContact& contact : news.contacts) {
    contacts_csv_.append(
        csv_row({seconds(contact.stamp), shortest(contact.p_scene.x()),
                 shortest(contact.p_scene.y()), contact.object, contact.while_moving ? "1" : "0"}));
  }
  std::string clearances;
  std::string poses;
  for (const TruePose& pose : news.poses) {
    clearances += csv_row({seconds(pose.stamp),
                           std::isfinite(pose.clearance_m) ? shortest(pose.clearance_m) : "inf"});
    poses += tum_row({pose.stamp, on_floor(pose.T_scene_body)});
  }
  if (!poses.empty()) {
    clearance_csv_.append(clearances);
    poses_tum_.append(poses);
  }
  contacts_ += news.contacts.size();
  poses_ += news.poses.size();
}

ServedTruth read_served_truth(const fs::path& folder) {
  try {
    return read(folder);
  } catch (const IoError& error) {
    throw ConfigError(error.what());
  }
}

std::optional<std::int64_t> start_unix_ns_of(const fs::path& metrics_json) {
  try {
    const Json metrics = Json::parse(read_file(metrics_json));
    if (!metrics.is_object()) {
      throw ConfigError(metrics_json.string() + ": is no metrics.json");
    }
    const auto found = metrics.find("start_unix_ns");
    if (found == metrics.end()) {
      return std::nullopt;
    }
    return found->get<std::int64_t>();
  } catch (const Json::exception& error) {
    throw ConfigError(metrics_json.string() + ": " + error.what());
  }
}

}  // namespace panoptes
