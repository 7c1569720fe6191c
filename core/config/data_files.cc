// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/data_files.h"

#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <system_error>

namespace panoptes {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kPrefix = "data:";

fs::path installed_root() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program.parent_path().parent_path() / "share" / "panoptes";
}

}  // namespace

std::string data_root() {
  if (const char* named = std::getenv("PANOPTES_DATA"); named != nullptr && *named != '\0') {
    return named;
  }
  std::error_code error;
  const fs::path source(PANOPTES_SOURCE_DIR);
  return (fs::is_directory(source / "scenes", error) ? source : installed_root()).string();
}

std::string resolve_path(const std::string& written, const std::string& mentioned_in) {
  if (written.starts_with(kPrefix)) {
    const std::string name = written.substr(kPrefix.size());
    const fs::path root = data_root();
    std::error_code error;
    const fs::path scene = root / "scenes" / name;
    const fs::path asset = root / "assets" / name;
    return (!fs::exists(scene, error) && fs::exists(asset, error) ? asset : scene)
        .lexically_normal()
        .string();
  }
  const fs::path path(written);
  return (path.is_absolute() ? path : fs::path(mentioned_in).parent_path() / path)
      .lexically_normal()
      .string();
}

std::string portable_path(const std::string& file) {
  if (file.starts_with(kPrefix)) {
    return file;
  }
  std::error_code error;
  const fs::path real = fs::weakly_canonical(file, error);
  if (error) {
    return file;
  }
  const fs::path root = fs::weakly_canonical(data_root(), error);
  for (const char* folder : {"scenes", "assets"}) {
    const fs::path inside = real.lexically_relative(root / folder);
    if (!inside.empty() && *inside.begin() != ".." && inside != ".") {
      return std::string(kPrefix) + inside.string();
    }
  }
  return real.string();
}

bool is_shipped(const std::string& file) { return portable_path(file).starts_with(kPrefix); }

}  // namespace panoptes
