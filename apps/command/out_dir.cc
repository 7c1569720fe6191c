// SPDX-License-Identifier: BSD-3-Clause
#include "apps/command/out_dir.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "core/base/error.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

// The folder and those above it that are not there, the innermost first.
std::vector<fs::path> missing(fs::path folder) {
  std::vector<fs::path> all;
  std::error_code fault;
  for (; !folder.empty() && !fs::exists(folder, fault); folder = folder.parent_path()) {
    if (folder.has_filename()) {  // "runs/" is "runs"
      all.push_back(folder);
    }
  }
  return all;
}

}  // namespace

OutDir::OutDir(fs::path path, const std::vector<std::string>& may_hold)
    : path_(std::move(path)), made_(missing(path_)) {
  std::error_code fault;
  std::error_code ignored;
  fs::create_directories(path_, fault);
  if (!fs::is_directory(path_, ignored)) {
    throw ConfigError(path_.string() + (made_.empty() ? ": is not a folder; name another with --out"
                                                      : ": cannot be made: " + fault.message() +
                                                            "; name another folder with --out"));
  }
  lock_ = FolderLock::take(path_);
  if (!lock_) {
    throw ConfigError(path_.string() +
                      ": another panoptes is writing there; name another folder with --out");
  }
  bool empty = true;
  for (const auto& entry : fs::directory_iterator(path_, fault)) {
    was_empty_ = false;
    empty = empty && std::find(may_hold.begin(), may_hold.end(),
                               entry.path().filename().string()) != may_hold.end();
  }
  if (fault) {
    throw ConfigError(path_.string() + ": cannot be read: " + fault.message());
  }
  if (!empty) {
    throw ConfigError(path_.string() +
                      ": is not empty; remove it or name another folder with --out");
  }
  if (::access(path_.c_str(), W_OK | X_OK) != 0) {
    throw ConfigError(path_.string() + ": cannot be written; name another folder with --out");
  }
}

OutDir::~OutDir() {
  if (kept_ || !was_empty_) {
    return;
  }
  std::error_code ignored;  // somebody else may have put something there meanwhile
  std::vector<fs::path> inside;
  for (const auto& entry : fs::directory_iterator(path_, ignored)) {
    inside.push_back(entry.path());
  }
  for (const fs::path& one : inside) {  // it was empty: all of it is this command's
    fs::remove_all(one, ignored);
  }
  for (const fs::path& folder : made_) {
    fs::remove(folder, ignored);
  }
}

}  // namespace panoptes
