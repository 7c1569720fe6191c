// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace panoptes {

/// A kind of settings file, and how it is told from the others.
struct FileKind {
  std::string name;
  std::string folder;             ///< of scenes/, where such files lie
  std::vector<std::string> keys;  ///< that no kind after it has
  std::string use;                ///< what to do with it; empty for a mission
};
const std::vector<FileKind>& file_kinds();

/// By the keys that the file holds; null when they do not tell. Throws ConfigError where it cannot
/// be read.
const FileKind* kind_by_keys(const std::string& file);

/// The same, else by the folder it lies in.
const FileKind* kind_of(const std::string& file);

/// Throws ConfigError for what is there and is something else than a mission, with what it is and
/// what to give instead.
void refuse_other_than_mission(const std::string& file);

}  // namespace panoptes
