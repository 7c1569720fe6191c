// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "apps/command/command.h"
#include "apps/command/out_dir.h"
#include "apps/draw/pictures.h"
#include "apps/mission/mission.h"
#include "apps/mission/stop_condition.h"
#include "apps/preview/camera_preview.h"
#include "apps/preview/contact_sheet.h"
#include "apps/process/fault.h"
#include "apps/process/stage_clock.h"
#include "apps/run/loop.h"
#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/io/dataset_writer.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

struct RenderArguments {
  std::string mission;
  std::vector<std::string> poses;
  double at_s = 0;
  bool depth = false;
  bool labels = false;
  CommonArguments common;
};

struct AskedPose {
  std::string text;
  Pose2 T_scene_body;
};

Pose2 parse_pose(const std::string& text) {
  std::array<double, 3> numbers{};
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto skip_blanks = [&] {
    while (at != end && *at == ' ') {
      ++at;
    }
  };
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    skip_blanks();
    const auto [after, error] = std::from_chars(at, end, numbers[i]);
    at = after;
    skip_blanks();
    const bool last = i + 1 == numbers.size();
    if (error != std::errc() || !std::isfinite(numbers[i]) ||
        (last ? at != end : at == end || *at != ',')) {
      throw ConfigError("--pose " + text +
                        ": must be x,y,theta_deg in scene, metres and degrees, e.g. 2,3,90");
    }
    at += last ? 0 : 1;
  }
  constexpr double kFarthest_m = 10'000;  // no world reaches so far
  if (std::hypot(numbers[0], numbers[1]) > kFarthest_m) {
    throw ConfigError("--pose " + text + ": is more than 10 km from the origin, where no world is");
  }
  return {numbers[0], numbers[1], wrap_angle(deg_to_rad(numbers[2]))};
}

// Each --pose may hold several, divided by semicolons.
std::vector<AskedPose> parse_poses(const std::vector<std::string>& words) {
  std::vector<AskedPose> poses;
  for (const std::string& word : words) {
    std::size_t from = 0;
    while (from <= word.size()) {
      const std::size_t to = std::min(word.find(';', from), word.size());
      const std::string text = word.substr(from, to - from);
      if (text.find_first_not_of(' ') != std::string::npos) {
        poses.push_back({text.substr(text.find_first_not_of(' ')), parse_pose(text)});
      }
      from = to + 1;
    }
  }
  if (poses.empty()) {
    throw ConfigError("--pose: must be x,y,theta_deg in scene, metres and degrees, e.g. 2,3,90");
  }
  return poses;
}

void write_pictures(const std::filesystem::path& folder, const CameraPreview::Views& views,
                    const std::vector<std::string>& instance_names, const cv::Mat& sheet) {
  std::filesystem::create_directories(folder);
  for (const CameraView& camera_view : views.cameras) {
    write_file(folder / (camera_view.name + ".png"), png(camera_view.image.bgr));
    if (!camera_view.image.depth_m.empty()) {
      write_file(folder / (camera_view.name + "_depth.png"),
                 png(millimetres(camera_view.image.depth_m)));
    }
    if (!camera_view.image.instance.empty()) {
      write_file(folder / (camera_view.name + "_labels.png"), png(camera_view.image.instance));
      write_file(folder / (camera_view.name + "_floor.png"), png(camera_view.image.floor_label));
    }
  }
  if (!instance_names.empty()) {
    write_file(folder / "things.csv", things_csv(instance_names));
  }
  write_file(folder / "render.png", png(sheet));
  std::printf("%s\n", (folder / "render.png").c_str());
}

Json figures_of(const AskedPose& pose, const CameraPreview::Views& views) {
  Json json{{"x_m", pose.T_scene_body.x_m},
            {"y_m", pose.T_scene_body.y_m},
            {"theta_deg", rad_to_deg(pose.T_scene_body.theta_rad)}};
  if (views.clearance_m) {
    json["clearance_m"] = *views.clearance_m;
  }
  if (!views.fault.empty()) {
    json["fault"] = "the robot " + views.fault;
  }
  return json;
}

void write_metrics(const std::filesystem::path& out_dir, const ExploreMission& mission,
                   const std::string& outcome, double at_s, const Json& poses,
                   const std::string& fault) {
  const ProcessUse use = process_use();
  Json metrics{{"schema", "panoptes.metrics/1"},
               {"command", "render"},
               {"version", PANOPTES_VERSION},
               {"seed", mission.seed},
               {"mission", mission.name},
               {"outcome", outcome},
               {"requirements", Json::array()},
               {"poses", poses},
               {"run_s", at_s},
               {"wall_s", use.wall_s},
               {"cpu_s", use.cpu_s},
               {"peak_memory_mb", use.peak_memory_mb}};
  if (!fault.empty()) {
    metrics["fault"] = as_utf8(fault);
  }
  write_file(out_dir / "metrics.json", metrics.dump(2) + "\n");
}

// What each camera of the rig would see from there, as believed to be mounted, without noise.
int render(const RenderArguments& args) {
  const std::vector<AskedPose> poses = parse_poses(args.poses);
  const auto mission = load_mission<ExploreMission>(args.mission, args.common.overrides(),
                                                    CameraRequirement::kNothing);
  const auto* simulated = std::get_if<sim::SimulatedOptions>(&mission.platform);
  if (simulated == nullptr) {
    throw ConfigError(args.mission + ": platform: nothing to draw; render needs a simulated one");
  }
  OutDir out(args.common.out_dir.value_or(default_out_dir(mission)));
  const StopCondition stop_condition(mission.until);
  Json looked_at = Json::array();
  std::string outcome = "completed";
  Faults faults;
  try {
    CameraPreview preview(mission, *simulated, patient_renderer(stop_condition, args.common.quiet));
    for (const AskedPose& pose : poses) {
      if (stop_condition.interrupted()) {
        outcome = "interrupted";
        break;
      }
      const CameraPreview::Views views = preview.render(
          pose.T_scene_body, time_at(args.at_s), {.depth = args.depth, .instance = args.labels});
      if (!views.fault.empty()) {
        std::fprintf(stderr, "--pose %s: the robot %s; drawn all the same\n", pose.text.c_str(),
                     views.fault.c_str());
      }
      const auto folder = poses.size() == 1
                              ? out.path()
                              : out.path() / ("pose-" + std::to_string(looked_at.size() + 1));
      out.keep();
      write_pictures(folder, views,
                     args.labels ? preview.instance_names() : std::vector<std::string>(),
                     contact_sheet(mission, pose.T_scene_body, args.at_s, views));
      looked_at.push_back(figures_of(pose, views));
    }
  } catch (const sim::BakeStopped&) {
    outcome = "interrupted";
  } catch (...) {
    if (!out.kept()) {
      throw;
    }
    faults.attempt([] { throw; });
    outcome = "failed";
  }
  out.keep();
  faults.attempt(
      [&] { write_metrics(out.path(), mission, outcome, args.at_s, looked_at, faults.text()); });
  return !faults.none() ? faults.status() : outcome == "completed" ? 0 : 130;
}

}  // namespace

void add_render(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<RenderArguments>();
  CLI::App* sub = app.add_subcommand("render", "What would each camera see there?");
  sub->add_option("MISSION", args->mission, "the mission file")->required()->type_name("FILE");
  sub->add_option("--pose", args->poses,
                  "the robot's place in scene, metres and degrees; again, or after a semicolon, "
                  "for more of them")
      ->required()
      ->type_name("X,Y,THETA_DEG")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  constexpr double kMost_s = 1e6;
  sub->add_option("--at-s", args->at_s, "when, in worlds where something happens (0)")
      ->type_name("S")
      ->check(CLI::Range(0.0, kMost_s));
  sub->add_flag("--depth", args->depth,
                "the true depth as well (16 bit, mm; 0 nothing, 65535 that far or farther)");
  sub->add_flag("--labels", args->labels,
                "which thing every pixel truly shows as well (16 bit, its number in things.csv), "
                "and whether floor");
  add_common(*sub, args->common);
  sub->footer(
      "Example: panoptes render scenes/missions/explore-office.yaml --pose '5,5,45; 5,4.4,90' "
      "--out runs/look");
  sub->callback([args, &chosen] { chosen = [args] { return render(*args); }; });
}

}  // namespace panoptes
