// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/eval/truth.h"
#include "core/io/dataset.h"
#include "core/io/growing_file.h"

namespace panoptes::hw {

/// Writes the truth of a run into a dataset's mav0/truth0, so that what is evaluated on its replay
/// is the same to the last bit:
///  - poses.csv, contacts.csv: a row each;
///  - seen.csv: the cells of the layer `seen` as they are set, in runs along a row;
///  - data.csv: a row an observation: the true way so far, and how many rows of the other tables
///    were known by then;
///  - floor.png, body.png: the layers that stay as they are, white where set, the highest row
///    first;
///  - layers.yaml: where the layers lie in `scene`;
///  - platform.yaml: the true rig and wheels, as far as they are known.
/// For other programs the poses are in mav0/state_groundtruth_estimate0 as well, as EuRoC has them:
/// of the body in `scene`.
class TruthWriter {
 public:
  /// `folder` is the dataset's; `truth` holds the layers.
  TruthWriter(const std::filesystem::path& folder, const Truth& truth);

  /// `news` is what the robot says is new since what was added before (Robot::truth_since).
  void add(Time observation, const Truth& news);

  std::size_t poses() const { return poses_; }
  std::size_t contacts() const { return contacts_; }

 private:
  void add_seen(Time observation, const TruthLayer& seen);

  TruthLayer seen_;  // as far as it is written
  std::size_t poses_ = 0;
  std::size_t contacts_ = 0;
  std::size_t seen_runs_ = 0;
  GrowingFile data_csv_;
  GrowingFile poses_csv_;
  GrowingFile contacts_csv_;
  GrowingFile seen_csv_;
  GrowingFile estimate_csv_;
};

/// The truth of a recorded run, and what was known of it at each observation.
class RecordedTruth {
 public:
  /// Up to the last observation that all tables know whole: a recording may have been cut short.
  /// Its stamps are moved by `epoch` (Dataset::epoch). Throws ConfigError with the file and line
  /// for what is wrong; empty where the dataset has no truth of ours.
  static std::optional<RecordedTruth> read(const std::filesystem::path& folder,
                                           Duration epoch = {});

  /// A trajectory with a pose for each observation, and nothing else; `file` is for messages.
  static RecordedTruth of_poses(const std::vector<TruePose>& poses, const std::string& file);

  std::size_t observations() const { return known_.size(); }

  /// Whether it would tell of contacts and clearances; a trajectory does not.
  bool touches_known() const { return touches_known_; }

  /// Leaves out the dataset's observations that this truth does not reach to, and adds a warning.
  /// Throws ConfigError with the file and line where the two are not of the same observations.
  void cut_to_fit(Dataset& dataset) const;

  /// After so many observations.
  Truth after(std::size_t observations) const;

 private:
  struct Known {
    Time stamp;
    std::string mention;  // file:line
    double path_m = 0;
    std::size_t poses = 0;
    std::size_t contacts = 0;
    std::size_t seen_runs = 0;
  };
  struct Run {
    std::size_t first = 0;  // index of a cell
    std::size_t count = 0;
  };

  Truth all_;  // but for the layer `seen`, which is empty, and the way
  bool touches_known_ = true;
  std::vector<Known> known_;
  std::vector<Run> seen_runs_;
  std::string file_;  // that says what was known when
};

}  // namespace panoptes::hw
