// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace panoptes {

/// What the chosen subcommand does once the command line is read; returns the exit status. A
/// subcommand NAME is a file with `void add_NAME(CLI::App& app, Command& chosen)`, which adds it
/// and sets `chosen` when the user asks for it, and a line in apps/CMakeLists.txt.
using Command = std::function<int()>;

/// What subcommands that run a mission share.
struct CommonArguments {
  std::optional<std::string> out_dir;
  std::optional<std::uint64_t> seed;
  std::optional<double> duration_s;
  std::vector<std::string> set;
  std::optional<int> threads;
  bool quiet = false;

  /// `--set`, `--seed` and `--duration` as overrides of a mission.
  std::vector<std::string> overrides() const;
};
/// `--seed`, `--duration` and `--set`.
void add_overrides(CLI::App& subcommand, CommonArguments& args);
/// These and all others.
void add_common(CLI::App& subcommand, CommonArguments& args);

}  // namespace panoptes
