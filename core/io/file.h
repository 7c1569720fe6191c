// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace panoptes {

/// A file that appears under its name whole or not at all: it grows under a temporary name beside
/// (`<name>.part`), and commit() brings it to the disk and renames it. Destroyed uncommitted, it
/// leaves nothing. Throws IoError with the path and the machine's reason, again when used again.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void append(std::string_view bytes);  ///< buffered: most calls touch no disk
  void commit();

 private:
  void flush();
  [[noreturn]] void fail(const char* doing);

  std::filesystem::path path_;
  std::filesystem::path part_;
  std::string buffer_;
  int descriptor_ = -1;
};

void write_file(const std::filesystem::path& path, std::string_view bytes);
std::string read_file(const std::filesystem::path& path);  ///< ConfigError; of ours IoError

}  // namespace panoptes
