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

/// What the chosen subcommand does once the command line is read; returns the exit status.
using Command = std::function<int()>;

/// Each adds its subcommand and sets `chosen` when the user asks for it.
void add_explore(CLI::App& app, Command& chosen);
void add_teleop(CLI::App& app, Command& chosen);
void add_record(CLI::App& app, Command& chosen);
void add_trials(CLI::App& app, Command& chosen);
void add_loops(CLI::App& app, Command& chosen);
void add_relax(CLI::App& app, Command& chosen);
void add_evaluate(CLI::App& app, Command& chosen);
void add_render(CLI::App& app, Command& chosen);
void add_serve(CLI::App& app, Command& chosen);
void add_check(CLI::App& app, Command& chosen);
void add_doctor(CLI::App& app, Command& chosen);

/// What subcommands that run a mission share.
struct CommonArguments {
  std::optional<std::string> out_dir;
  std::optional<std::uint64_t> seed;
  std::optional<double> duration_s;
  std::vector<std::string> set;
  bool quiet = false;

  /// `--set`, `--seed` and `--duration` as overrides of a mission.
  std::vector<std::string> overrides() const;
};
void add_common(CLI::App& subcommand, CommonArguments& args);

}  // namespace panoptes
