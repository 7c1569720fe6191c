// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "apps/command/command.h"
#include "apps/mission/mission.h"
#include "apps/run/mission_run.h"
#include "apps/run/refined.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/digits.h"

namespace panoptes {
namespace {

struct NavigateArguments {
  std::string mission;
  std::string goals;
  std::optional<std::string> refined;
  CommonArguments common;
};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\n\r";
  const std::size_t from = text.find_first_not_of(kBlank);
  return from == std::string_view::npos
             ? std::string_view()
             : text.substr(from, text.find_last_not_of(kBlank) - from + 1);
}

std::vector<std::string_view> parts(std::string_view text, char between) {
  std::vector<std::string_view> all;
  while (true) {
    const std::size_t at = text.find(between);
    all.push_back(trimmed(text.substr(0, at)));
    if (at == std::string_view::npos) {
      return all;
    }
    text.remove_prefix(at + 1);
  }
}

// As the setting `drive:` of a mission.
std::string drive_to(const std::string& goals) {
  std::vector<std::string> points;
  if (trimmed(goals).empty()) {
    throw ConfigError(
        "--goals: must name a place at least: x,y in metres, as in --goals '2,1; 4,3'");
  }
  for (const std::string_view goal : parts(goals, ';')) {
    const auto fault = [&](const std::string& must) {
      return ConfigError(
          fmt::format("--goals: goal {} {}, got '{}'", points.size() + 1, must, goal));
    };
    const std::vector<std::string_view> words = parts(goal, ',');
    const std::optional<double> x_m = parse_number(words.front());
    const std::optional<double> y_m = parse_number(words.back());
    if (words.size() != 2 || !x_m || !y_m) {
      throw fault("must be x,y in metres");
    }
    if (!(std::abs(*x_m) <= kFarthestGoal_m && std::abs(*y_m) <= kFarthestGoal_m)) {
      throw fault(fmt::format("must lie within {} m of the start", kFarthestGoal_m));
    }
    points.push_back(fmt::format("{{x_m: {}, y_m: {}}}", *x_m, *y_m));
  }
  return "drive={goals: [" + joined(points) + "]}";
}

// Drives the mission's robot to the goals, whoever it says drives.
int navigate(const NavigateArguments& args) {
  constexpr CameraRequirement kNeeds = CameraRequirement::kNavigator;
  std::vector<std::string> overrides = args.common.overrides();
  overrides.push_back(drive_to(args.goals));
  auto mission = load_mission<ExploreMission>(
      args.mission, with_refined(args.refined, args.mission, overrides, kNeeds), kNeeds);
  mission.require.emplace_back("end_reason == goals_done");  // in time
  if (std::holds_alternative<hw::RecordedOptions>(mission.platform)) {
    throw ConfigError(args.mission +
                      ": platform: a recording cannot be driven; give a mission with another "
                      "platform, or map it again with panoptes explore");
  }
  return run_mission(
      mission,
      {"navigate", args.common.out_dir.value_or(default_out_dir(mission)), args.common.quiet, {}});
}

}  // namespace

void add_navigate(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<NavigateArguments>();
  CLI::App* sub =
      app.add_subcommand("navigate", "Drive to goals in a world that nobody has described");
  sub->add_option("MISSION", args->mission, "the mission file")->required()->type_name("FILE");
  sub->add_option("--goals", args->goals,
                  "where to drive to, in turn: 'x,y; x,y', metres from where the robot starts, x "
                  "ahead and y to the left")
      ->required()
      ->type_name("POINTS");
  add_refined(*sub, args->refined);
  add_common(*sub, args->common);
  sub->footer(
      "Example: panoptes navigate scenes/missions/explore-office.yaml --seed 1 --goals '2,0; 0,0' "
      "--out runs/to-goals\n"
      "Exit status 0: every goal was reached; 1: one was refused, for nothing leads there, or "
      "the time was up first.");
  sub->callback([args, &chosen] { chosen = [args] { return navigate(*args); }; });
}

}  // namespace panoptes
