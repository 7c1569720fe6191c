// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace panoptes {

struct SourceFile {
  std::string name;  ///< from the tree's root
  std::string text;
};

/// Every header and source of our own.
inline std::vector<SourceFile> source_tree() {
  const std::filesystem::path root = PANOPTES_SOURCE_DIR;
  std::vector<SourceFile> files;
  for (const char* floor : {"core", "hw", "sim", "apps", "tests"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / floor)) {
      const auto extension = entry.path().extension();
      if (extension == ".h" || extension == ".cc") {
        std::ifstream in(entry.path());
        files.push_back({std::filesystem::relative(entry.path(), root).generic_string(),
                         {std::istreambuf_iterator<char>(in), {}}});
      }
    }
  }
  return files;
}

}  // namespace panoptes
