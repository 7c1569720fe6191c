// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/plan_stage.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <variant>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/rig_figures.h"
#include "apps/calibrate/stage_cameras.h"
#include "apps/calibrate/stage_metrics.h"
#include "apps/command/out_dir.h"
#include "apps/mission/mission.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/camera/lens_parameters.h"
#include "core/config/fields.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

ExploreMission mission_of(const PlanStage& args) {
  std::error_code ignored;
  if (fs::is_directory(args.mission, ignored)) {
    throw ConfigError(fmt::format(
        "--plan: {} is a folder, and a drive that is recorded needs no plan: give the file of a "
        "mission whose drive is a program, or calibrate the recording without --plan",
        args.mission));
  }
  return load_mission<ExploreMission>(args.mission, args.overrides, CameraRequirement::kNothing);
}

MotionProgramOptions program_of(const PlanStage& args, const ExploreMission& mission) {
  const auto* program = std::get_if<Drive<"program">>(&mission.drive);
  if (program == nullptr) {
    throw ConfigError(
        fmt::format("--plan: {}: drives by {}, and only a program is known before it is driven; "
                    "name one with --set drive={{program: rose}}",
                    args.mission, name_of(mission.drive)));
  }
  return program->motion;
}

Vec3 room_of(const std::string& text) {
  constexpr double kLeast_m = 1;
  constexpr double kMost_m = 100;
  Vec3 room_m;
  char more = 0;
  const int read =
      std::sscanf(text.c_str(), "%lfx%lfx%lf%c", &room_m.x(), &room_m.y(), &room_m.z(), &more);
  if (read != 3 || !(room_m.minCoeff() >= kLeast_m && room_m.maxCoeff() <= kMost_m)) {
    throw ConfigError("--room " + text +
                      ": must be LENGTHxWIDTHxHEIGHT in metres, as 5.5x5.5x2.6, each from 1 to "
                      "100");
  }
  return room_m;
}

std::string_view name_of(const MotionProgramOptions& program) {
  return std::visit([](const auto& chosen) { return chosen.kName; }, program);
}

std::string heading(const RigCalibration& plan, const MotionProgramOptions& program, double drive_s,
                    double planned_s, const Vec3& room_m) {
  std::string text = fmt::format(
      "plan: {} of {:.0f} s, {}; pictures of {} places; points on walls, floor and ceiling of a "
      "room of {} x {} x {} m are assumed\n",
      name_of(program), drive_s, counted(plan.cameras.size(), "camera"),
      plan.tracks.instants.size(), room_m.x(), room_m.y(), room_m.z());
  constexpr double kAbout_s = 5;
  if (drive_s + kAbout_s < planned_s) {
    text += fmt::format(
        "  it ends before the program does, which takes {:.0f} s: see until.duration_s\n",
        planned_s);
  }
  return text;
}

/// That a drive, with the robot about it, leads out of the room that it begins in the middle of.
std::string does_not_fit(const DrivePath& path, const Body& robot, const Vec3& room_m) {
  Vec2 reach_m = Vec2::Zero();
  for (const Pose2& pose : path.poses()) {
    reach_m = reach_m.cwiseMax(pose.position().cwiseAbs());
  }
  reach_m.array() += robot.radius_m;
  return (2 * reach_m.array() <= room_m.head<2>().array()).all()
             ? ""
             : fmt::format(
                   "the drive with the robot about it takes {:.1f} x {:.1f} m, and it would run "
                   "into a wall of the room, which is {} x {} m; drive a smaller motion, or name a "
                   "larger room",
                   2 * reach_m.x(), 2 * reach_m.y(), room_m.x(), room_m.y());
}

/// A camera's sigmas, and what stays open.
std::string told(const RigCalibration& plan, std::size_t c) {
  const RigCovariance& known = plan.bundle.known;
  const Eigen::VectorXd sigma = known.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const auto of = sigma.segment(known.camera[c], known.wheels - known.camera[c]);
  const Intrinsics& lens = plan.bundle.state.lenses[c];
  const auto own =
      std::count(plan.map_of_point.begin(), plan.map_of_point.end(), static_cast<int>(c));
  std::string text = fmt::format(
      "  {}: roll {:.3f}, pitch {:.3f}, yaw {:.3f} deg; x {:.1f}, y {:.1f}, z {:.1f} mm; clock "
      "{:.1f} ms; focal {:.3f} %; maps {} points, shares {}\n",
      plan.cameras[c], rad_to_deg(of[0]), rad_to_deg(of[1]), rad_to_deg(of[2]), 1000 * of[3],
      1000 * of[4], 1000 * of[5], 1000 * of[6 + lens_parameters(lens).size()],
      100 * of[6] / lens.fx_px, own, plan.shared[c]);
  if (c > 0) {
    const Eigen::Matrix<double, 6, 6> relative = known.relative(plan.bundle.state, 0, c);
    text += fmt::format("    as {} sees it: {:.3f} deg, {:.1f} mm\n", plan.cameras.front(),
                        rad_to_deg(std::sqrt(relative.topLeftCorner<3, 3>().trace())),
                        1000 * std::sqrt(relative.bottomRightCorner<3, 3>().trace()));
  }
  for (const std::string& what : known.unobservable[c]) {
    text += fmt::format("    not seen: {}\n", what);
  }
  return text;
}

}  // namespace

int plan_calibration_of(PlanStage args) {
  if (!args.room.empty()) {
    args.plan.room_m = room_of(args.room);
  }
  const ExploreMission mission = mission_of(args);
  const MotionProgramOptions program = program_of(args, mission);
  const Rig rig = args.rig.empty() ? mission.rig : read_settings<Rig>(args.rig);
  const auto cameras = rig_cameras(rig, args.cameras);
  args.plan.known_together = rig.covariance;
  std::optional<OutDir> out;
  if (!args.out.empty()) {
    out.emplace(args.out);
  }
  const DrivePath path = driven_path(program, mission.robot, mission.until.duration_s);
  const double drive_s = to_seconds(path.end());
  const RigCalibration plan = plan_calibration(args.plan, cameras, path);
  std::vector<std::string> advice = plan_advice(plan);
  if (std::string too_small = does_not_fit(path, mission.robot, args.plan.room_m);
      !too_small.empty()) {
    advice.push_back(std::move(too_small));
  }
  std::string text =
      heading(plan, program, drive_s, expected_s(program, mission.robot), args.plan.room_m);
  for (std::size_t c = 0; c < plan.cameras.size(); ++c) {
    text += told(plan, c);
  }
  for (const std::string& line : advice) {
    text += "  " + line + "\n";
  }
  std::printf("%s", text.c_str());
  if (!out) {
    return 0;
  }
  out->keep();
  Json figures{{"schema", "panoptes.metrics/1"},
               {"command", "calibrate"},
               {"stage", "plan"},
               {"version", PANOPTES_VERSION},
               {"outcome", "completed"},
               {"program", name_of(program)},
               {"drive_s", drive_s}};
  figures.update(rig_figures(plan, std::nullopt));
  figures.erase("reprojection_rms_px");  // of no pictures
  figures["warnings"] = advice;
  Faults faults;
  write_metrics(out->path(), figures, faults);
  return faults.none() ? 0 : faults.status();
}

}  // namespace panoptes
