// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace panoptes {

/// A mission whose drive is recorded to calibrate by.
struct DriveToRecord {
  std::string mission;  ///< its file
  std::vector<std::string> overrides;
  std::filesystem::path out;  ///< whose folder `recording` the dataset is
  bool quiet = false;

  std::filesystem::path dataset() const;
};

/// Records the drive, unless a whole recording of it is there, and copies its mission.yaml beside
/// what is calibrated. The exit status; but for 0, which is that of a whole one, it has said why.
/// Throws ConfigError where another recording is there, or one that was cut short.
int record_here(const DriveToRecord& drive);

}  // namespace panoptes
