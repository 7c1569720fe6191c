// SPDX-License-Identifier: BSD-3-Clause
#include "apps/doctor/serial_ports.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "hw/pioneer/port_access.h"
#include "hw/pioneer/report.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

// A ttyS is there for every port that a board could have; type 0 has no chip.
bool has_device(const fs::path& tty) {
  std::error_code error;
  if (!fs::exists(tty / "device", error)) {
    return false;
  }
  int type = 1;
  std::ifstream(tty / "type") >> type;
  return type != 0;
}

// The entries of a folder that may not be there, in order.
std::vector<fs::path> entries(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    out.push_back(entry->path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

void judge(const fs::path& root, ListedPort& port) {
  const std::string file = root / fs::path(port.node).relative_path();
  const int opened = ::open(file.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  const int error = errno;
  struct stat status = {};
  if (opened < 0 && ::stat(file.c_str(), &status) != 0) {
    port.fault = "has no node in /dev";
    port.cure = "into a container it must be passed: --device " + port.node;
    return;
  }
  if (opened < 0 && error == EACCES) {
    const hw::PortAccess access = hw::access_of(port.node, file);
    port.fault = "no permission: it belongs to the group " +
                 (access.group.empty() ? std::to_string(status.st_gid) : access.group);
    port.cure = hw::access_cure(access);
    return;
  }
  if (opened < 0 && error != EBUSY) {
    port.fault = std::generic_category().message(error);
    port.cure = "is its adapter plugged in? try another socket, and dmesg for what the kernel says";
    return;
  }
  int exclusive = 0;
  const bool busy = opened < 0 || ::flock(opened, LOCK_EX | LOCK_NB) != 0 ||
                    (::ioctl(opened, TIOCGEXCL, &exclusive) == 0 && exclusive != 0);
  if (opened >= 0) {
    ::close(opened);
  }
  if (const std::string by = hw::port_holder(port.node, root); busy || !by.empty()) {
    port.fault = "busy: " + (by.empty() ? "another process has it" : by + " has it open");
    port.cure = by.empty() ? "end that: sudo fuser -v " + port.node : "end that";
  }
}

}  // namespace

std::vector<ListedPort> serial_ports(const fs::path& root) {
  std::vector<ListedPort> ports;
  for (const fs::path& tty : entries(root / "sys/class/tty")) {
    if (!has_device(tty)) {
      continue;
    }
    ListedPort port;
    port.node = "/dev/" + tty.filename().string();
    for (const fs::path& name : entries(root / "dev/serial/by-id")) {
      std::error_code error;
      if (fs::read_symlink(name, error).filename() == tty.filename()) {
        port.by_id.push_back("/dev/serial/by-id/" + name.filename().string());
      }
    }
    judge(root, port);
    ports.push_back(std::move(port));
  }
  return ports;
}

std::string answer_line(const hw::PioneerIdentity& answer) {
  return fmt::format(
      "{} {} \"{}\"{}, battery {:.1f} V{}{}", answer.class_name, answer.subclass, answer.name,
      answer.firmware.empty() ? "" : ", firmware " + answer.firmware, answer.battery_v,
      answer.battery_v < hw::kLowBattery_v ? " (low: charge it before it drives)" : "",
      answer.baud > 0 ? fmt::format(", {} baud", answer.baud) : "");
}

}  // namespace panoptes
