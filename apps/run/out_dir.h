// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

namespace panoptes {

/// The folder that a command's results go to: made, or there and empty. A command that is refused
/// before it has anything to keep leaves no trace of it.
class OutDir {
 public:
  /// Throws ConfigError when it is not empty or cannot be made or written.
  explicit OutDir(std::filesystem::path path);
  ~OutDir();
  OutDir(const OutDir&) = delete;
  OutDir& operator=(const OutDir&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// What is in it stays from now on.
  void keep() { kept_ = true; }

 private:
  std::filesystem::path path_;
  std::vector<std::filesystem::path> made_;  ///< it and those above it that were not there
  bool kept_ = false;
};

}  // namespace panoptes
