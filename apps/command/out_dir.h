// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/command/folder_lock.h"

namespace panoptes {

/// The folder that a command's results go to: made, or there and empty, but for what the command
/// itself left there when it was interrupted. A command that is refused
/// before it has anything to keep leaves no trace of it, and no other command gets the folder
/// meanwhile.
class OutDir {
 public:
  /// Throws ConfigError when it is not empty, cannot be made or written, or is another command's.
  explicit OutDir(std::filesystem::path path, const std::vector<std::string>& may_hold = {});
  ~OutDir();
  OutDir(const OutDir&) = delete;
  OutDir& operator=(const OutDir&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// What is in it stays from now on.
  void keep() { kept_ = true; }
  bool kept() const { return kept_; }

 private:
  std::filesystem::path path_;
  bool was_empty_ = true;
  std::vector<std::filesystem::path> made_;  ///< it and those above it that were not there
  std::optional<FolderLock> lock_;
  bool kept_ = false;
};

}  // namespace panoptes
