// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/port_access.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <vector>

#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

namespace panoptes::hw {
namespace {

namespace fs = std::filesystem;

// What the links in a folder lead to; none where it may not be read.
std::vector<std::string> targets(const fs::path& folder) {
  std::vector<std::string> out;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code unreadable;
    out.push_back(fs::read_symlink(entry->path(), unreadable).string());
  }
  return out;
}

std::string user_name() {
  const passwd* user = ::getpwuid(::geteuid());
  return user == nullptr ? std::to_string(::geteuid()) : user->pw_name;
}

}  // namespace

PortAccess access_of(const std::string& node, const std::string& file) {
  struct stat status = {};
  ::stat(file.c_str(), &status);
  const group* owner = ::getgrgid(status.st_gid);
  PortAccess access{node, owner == nullptr ? "" : owner->gr_name,
                    (status.st_mode & S_IRGRP) != 0 && (status.st_mode & S_IWGRP) != 0, user_name(),
                    false};
  for (char** member = owner == nullptr ? nullptr : owner->gr_mem;
       member != nullptr && *member != nullptr; ++member) {
    access.member = access.member || access.user == *member;
  }
  return access;
}

std::string access_cure(const PortAccess& access) {
  if (access.member) {
    return access.user + " is in the group " + access.group +
           " already: log out and in again (or newgrp " + access.group + ")";
  }
  if (access.group_may && !access.group.empty() && access.group != "root") {
    return fmt::format("sudo usermod -aG {} {}, then log out and in again", access.group,
                       access.user);
  }
  const std::string name = std::filesystem::path(access.node).filename();
  const std::string kind = name.substr(0, name.find_last_not_of("0123456789") + 1);
  return fmt::format(
      R"(a udev rule gives it to a group that may: echo 'SUBSYSTEM=="tty", KERNEL=="{}[0-9]*", )"
      R"(GROUP="dialout", MODE="0660"' | sudo tee /etc/udev/rules.d/60-panoptes.rules; )"
      "sudo udevadm control --reload; sudo udevadm trigger; sudo usermod -aG dialout {}, then log "
      "out and in again",
      kind, access.user);
}

std::string port_holder(const std::string& node, const fs::path& root) {
  const std::string self = std::to_string(::getpid());
  std::error_code error;
  for (fs::directory_iterator entry(root / "proc", error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string pid = entry->path().filename();
    if (pid == self || pid.find_first_not_of("0123456789") != std::string::npos) {
      continue;
    }
    const std::vector<std::string> open = targets(entry->path() / "fd");
    const auto has = [&](const char* file) {
      return std::find(open.begin(), open.end(), file) != open.end();
    };
    const bool made_it =
        node.starts_with("/dev/pts/") && (has("/dev/ptmx") || has("/dev/pts/ptmx"));
    if (has(node.c_str()) && !made_it) {
      std::string name;
      std::getline(std::ifstream(entry->path() / "comm"), name);
      return fmt::format("{} (pid {})", name.empty() ? "a process" : name, pid);
    }
  }
  return {};
}

}  // namespace panoptes::hw
