// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace panoptes::hw {

/// Who may use a node, and who asks.
struct PortAccess {
  std::string node;        ///< /dev/ttyUSB0
  std::string group;       ///< that owns it; empty: one without a name
  bool group_may = false;  ///< read and write
  std::string user;
  bool member = false;  ///< the user is of the group, but has not logged in since
};

/// The command that lets the user open it: joining its group, or a udev rule where that would give
/// more than the port (root's) or nothing at all.
std::string access_cure(const PortAccess& access);

/// Of this process to a file that is there and stands for `node`.
PortAccess access_of(const std::string& node, const std::string& file);

/// Another process that has a port open, as `gpsd (pid 123)`; empty when none is seen (those of
/// others are seen by root alone). Whoever made a pseudo-terminal is the robot behind it, and none.
std::string port_holder(const std::string& node, const std::filesystem::path& root = "/");

}  // namespace panoptes::hw
