// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace panoptes {

/// What the user wrote is wrong (exit status 2). Holds every fault found, one line each, in the
/// form `file:line:column: key: what is wrong; what is allowed`; `what()` is all of them joined by
/// newlines.
class ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(std::string line);
  explicit ConfigError(std::vector<std::string> lines);
  const std::vector<std::string>& lines() const { return lines_; }

 private:
  std::vector<std::string> lines_;
};

/// A file of the machine cannot be read or written: a missing mesh, a full disk (exit status 3).
class IoError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A device is missing or stopped answering (exit status 3).
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace panoptes
