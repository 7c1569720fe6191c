// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "apps/command/command.h"
#include "apps/command/out_dir.h"
#include "apps/mission/mission.h"
#include "apps/mission/open_robot.h"
#include "apps/mission/stop_condition.h"
#include "apps/process/fault.h"
#include "apps/process/progress.h"
#include "apps/serve/served_run.h"
#include "hw/standin/wire_server.h"

namespace panoptes {
namespace {

constexpr double kForEver_s = 1e8;

struct ServeArguments {
  std::string mission;
  std::optional<int> port;
  std::string host = "127.0.0.1";
  bool pty = false;
  std::string link;
  CommonArguments common;
};

std::vector<std::unique_ptr<hw::Endpoint>> open_endpoints(const ServeArguments& args) {
  std::vector<std::unique_ptr<hw::Endpoint>> endpoints;
  const bool pty = args.pty || !args.link.empty();
  if (pty) {
    endpoints.push_back(std::make_unique<hw::PtyEndpoint>(args.link));
  }
  if (!pty || args.port) {
    endpoints.push_back(std::make_unique<hw::TcpEndpoint>(args.host, args.port.value_or(8101)));
  }
  return endpoints;
}

std::string doing(const hw::WireServer& server, const Truth& known, Time now) {
  const double speed_mps = known.poses.empty() ? 0 : known.poses.back().twist_body.v_mps;
  return fmt::format("{:.0f} s; {}, {:.2f} m/s, {:.1f} m driven, {} contacts", to_seconds(now),
                     server.connected() ? "a client is there" : "nobody is there", speed_mps,
                     known.path_m, known.contacts.size());
}

// Serves the mission's robot over a Pioneer's wire, in wall-clock time, until it is stopped.
int serve(const ServeArguments& args) {
  const auto mission = load_mission<ExploreMission>(args.mission, args.common.overrides(),
                                                    CameraRequirement::kNothing);
  const StopCondition stop_condition({args.common.duration_s.value_or(kForEver_s), std::nullopt});
  OutDir out(args.common.out_dir.value_or(default_out_dir(mission)));
  std::vector<std::unique_ptr<hw::Endpoint>> endpoints = open_endpoints(args);
  std::string names;
  for (const auto& endpoint : endpoints) {
    names += " " + endpoint->name();
  }
  const auto robot = open_robot_without_cameras(mission, Rng(mission.seed).fork("robot"));
  const auto* wired = std::get_if<PioneerOptions>(&mission.platform);
  const hw::StandInOptions standin = wired != nullptr ? wired->controller : hw::StandInOptions();
  hw::StandInController controller(*robot, mission.robot, standin);
  hw::WireServer server(controller, std::move(endpoints));
  ServedRun run(out.path(), mission, server.start_unix_ns(), robot->truth().value_or(Truth()));
  out.keep();
  std::printf("a Pioneer (%s) is at%s\n", standin.subclass.c_str(), names.c_str());
  std::fflush(stdout);
  ProgressLine line(args.common.quiet);
  const auto go_on = [&] {
    run.keep(*robot);
    return !stop_condition.reached(controller.now(), 0);
  };
  Faults faults;
  faults.attempt([&] {
    while (go_on()) {
      server.turn(go_on);
      if (line.due()) {
        line.show(doing(server, run.known(), controller.now()));
      }
    }
  });
  faults.attempt([&] { robot->stop(); });
  const char* outcome = stop_condition.interrupted() ? "interrupted" : "completed";
  faults.attempt([&] {
    run.write_metrics(faults.none() ? outcome : "failed", controller.now(), faults.text());
  });
  std::printf("%s\n", doing(server, run.known(), controller.now()).c_str());
  return !faults.none() ? faults.status() : stop_condition.interrupted() ? kInterrupted : 0;
}

}  // namespace

void add_serve(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<ServeArguments>();
  CLI::App* sub = app.add_subcommand("serve", "A mission's robot as a Pioneer on its real wire");
  sub->add_option("MISSION", args->mission, "the mission file")->required()->type_name("FILE");
  sub->add_option("--port", args->port, "for TCP (8101; with --pty none unless given)")
      ->type_name("N")
      ->check(CLI::Range(0, 65535));
  sub->add_option("--host", args->host, "the address to listen at (127.0.0.1)")->type_name("HOST");
  sub->add_flag("--pty", args->pty, "as a serial port");
  sub->add_option("--link", args->link, "a name for that port that stays the same")
      ->type_name("PATH");
  add_common(*sub, args->common);
  sub->footer(
      "Example: panoptes serve scenes/missions/explore-office.yaml --out runs/served\n"
      "or:      panoptes serve scenes/missions/explore-office.yaml --link pioneer\n"
      "It serves until Ctrl-C, or so long as --duration says.");
  sub->callback([args, &chosen] { chosen = [args] { return serve(*args); }; });
}

}  // namespace panoptes
