// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/eval/truth.h"
#include "core/io/growing_file.h"

namespace panoptes {

/// Writes what a robot that is served to others truly does, so that their runs can be evaluated:
///  - ground_truth.tum: the body in `scene`, a line a frame set;
///  - clearance.csv: `stamp_s, clearance_m` of the same instants, inf in an empty world;
///  - contacts.csv: `stamp_s, x_m, y_m, object, while_moving` of each contact;
///  - floor.yaml, floor.pgm, body.yaml, body.pgm: the layers of the world as maps of ROS
///    map_server in `scene`, occupied where set, else free; none of a layer without cells;
///  - true_platform.yaml: the true rig (of a robot that is served with cameras) and wheels;
///  - metrics.json: `start_unix_ns`, the wall instant of time 0.
/// All stamps are in seconds since then. What add() has returned from is in the files, whatever
/// becomes of the process.
class ServedTruthWriter {
 public:
  /// `folder` is there. `first` holds the layers, and may hold what was true already.
  ServedTruthWriter(const std::filesystem::path& folder, std::int64_t start_unix_ns,
                    const Truth& first);

  /// `news` is what is new since what was added before (Robot::truth_since).
  void add(const Truth& news);

  std::size_t poses() const { return poses_; }
  std::size_t contacts() const { return contacts_; }

 private:
  std::size_t poses_ = 0;
  std::size_t contacts_ = 0;
  GrowingFile contacts_csv_;
  GrowingFile clearance_csv_;
  GrowingFile poses_tum_;
};

struct ServedTruth {
  Truth truth;  ///< its layer `seen` is empty; the path length is summed along the poses
  std::int64_t start_unix_ns = 0;
};

/// As far as it was written whole: the robot may still be served, or its server be gone. Throws
/// ConfigError, with the file and line where there is one, for what is missing or wrong.
ServedTruth read_served_truth(const std::filesystem::path& folder);

/// `start_unix_ns` of a metrics.json; empty where it has none. Throws ConfigError for what is no
/// metrics.json.
std::optional<std::int64_t> start_unix_ns_of(const std::filesystem::path& metrics_json);

}  // namespace panoptes
