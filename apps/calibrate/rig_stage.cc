// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_stage.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/by_maps_stage.h"
#include "apps/calibrate/camera_map.h"
#include "apps/calibrate/missing_pictures.h"
#include "apps/calibrate/recorded_wheels.h"
#include "apps/calibrate/rig_figures.h"
#include "apps/calibrate/rig_files.h"
#include "apps/calibrate/rig_pictures.h"
#include "apps/calibrate/saved_map.h"
#include "apps/calibrate/stage_cameras.h"
#include "apps/calibrate/stage_metrics.h"
#include "apps/command/out_dir.h"
#include "apps/mission/stop_condition.h"
#include "apps/process/fault.h"
#include "apps/process/progress.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/utf8.h"
#include "core/calib/joint_of_rig.h"
#include "core/calib/rig_verdict.h"
#include "core/camera/lens_parameters.h"
#include "core/config/fields.h"
#include "core/config/sha256.h"
#include "core/io/dataset.h"
#include "core/io/dataset_rows.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string map_file(const std::string& camera) { return "map_" + camera + ".json"; }

/// What tells a picture's file from another's of the same name: its size, and its end, which goes
/// by its pixels.
std::string mark_of(const fs::path& file) {
  constexpr std::uintmax_t kEnd_bytes = 64;
  const std::uintmax_t size = fs::file_size(file);
  std::string end(std::min(size, kEnd_bytes), ' ');
  std::ifstream in(file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(size - end.size()));
  in.read(end.data(), static_cast<std::streamsize>(end.size()));
  return fmt::format(" {} {}", size, end);
}

/// Warnings of what the recording lacks: cameras of the rig, pictures, and the ends of tables whose
/// last row is torn.
std::vector<std::string> what_is_missing(const RigStage& args,
                                         const std::vector<MappedCamera>& cameras) {
  std::vector<std::string> tables{std::string(kOdometryFile)};
  for (const MappedCamera& camera : cameras) {
    tables.push_back(data_csv(camera.name));
  }
  std::vector<std::string> warnings;
  for (const std::string& camera : cameras_left_out(args.dataset, args.rig, args.cameras)) {
    warnings.push_back(fmt::format(
        "{}: is a camera of the rig, and the recording has no pictures of it: it stays as the rig "
        "file has it; copy mav0/{} as well, or name those to calibrate with --cameras",
        camera, camera));
  }
  for (const MappedCamera& camera : cameras) {
    std::vector<Time> stamps;
    for (const RecordedPicture& picture : recorded_pictures(args.dataset, camera.name)) {
      stamps.push_back(picture.stamp);
    }
    if (std::string missing = missing_pictures(camera.name, stamps); !missing.empty()) {
      warnings.push_back(std::move(missing));
    }
  }
  for (const std::string& table : tables) {
    if (std::string torn = torn_row(args.dataset, table); !torn.empty()) {
      warnings.push_back(std::move(torn));
    }
  }
  return warnings;
}

/// What of an earlier try may lie in the folder: what goes on from there, and all of one that told
/// nothing.
std::vector<std::string> left_before(const RigStage& args) {
  std::vector<std::string> may_hold{"recording", "mission.yaml"};  // of a mission
  for (const auto& [camera, believed] : whole_rig(args.dataset, args.rig).cameras) {
    may_hold.push_back(map_file(camera));  // left out this time, perhaps
  }
  if (told_in_metrics(args.out, "outcome") == "failed" &&
      told_in_metrics(args.out, "command") == "calibrate" &&
      told_in_metrics(args.out, "stage") == "rig") {
    for (const auto& entry : fs::directory_iterator(args.out)) {
      may_hold.push_back(entry.path().filename().string());
    }
  }
  return may_hold;
}

/// What a camera's map is made of, and how.
std::string made_of(const RigStage& args, const std::string& camera, const RigCamera& believed,
                    GapsTold gaps) {
  std::string text = read_part(fs::path(args.dataset) / data_csv(camera)).value_or("");
  for (const RecordedPicture& picture : recorded_pictures(args.dataset, camera)) {
    text += mark_of(fs::path(args.dataset) / picture.file);
  }
  for (const double number : lens_parameters(believed.intrinsics)) {
    text += fmt::format(" {}", number);
  }
  if (gaps == GapsTold::kByWheels) {
    text += read_part(fs::path(args.dataset) / kOdometryFile).value_or("");
  }
  text += fmt::format(" {} {} {} {}", believed.sigma.focal_ratio, believed.sigma.centre_px,
                      name(args.slam.features), PANOPTES_VERSION);
  return sha256(text);
}

/// A camera's map as it lies in the folder, or made now and put there. Empty where it was
/// interrupted.
std::optional<MappedCamera> mapped(const RigStage& args, const fs::path& out,
                                   const std::string& camera, const RigCamera& believed,
                                   GapsTold gaps, const StopCondition& stop_condition,
                                   const std::function<void(double)>& progress) {
  const std::string of = made_of(args, camera, believed, gaps);
  MappedCamera told{camera, believed, {}, {}};
  if (std::optional<MonoMap> saved = read_map(out / map_file(camera), of, believed.intrinsics)) {
    told.map = std::move(*saved);
    told.adjusted = adjust_map(args.bundle, believed.intrinsics, believed.sigma, told.map);
  } else {
    CameraMap made = map_camera(args.dataset, camera, believed, args.slam, args.bundle, gaps,
                                progress, {[&] { return stop_condition.interrupted(); }, nullptr});
    if (stop_condition.interrupted()) {
      return std::nullopt;
    }
    told.map = std::move(made.map);
    told.adjusted = std::move(made.adjusted);
    write_map(out / map_file(camera), of, told.map);
  }
  return told;
}

/// The pictures of a map's frames: a start may have been given up.
std::vector<RecordedPicture> pictures_of(const std::string& dataset, const MappedCamera& camera) {
  std::vector<RecordedPicture> pictures = recorded_pictures(dataset, camera.name);
  const std::size_t given_up = pictures.size() - camera.map.frames.size();
  pictures.erase(pictures.begin(), pictures.begin() + static_cast<std::ptrdiff_t>(given_up));
  return pictures;
}

/// A camera whose map is of no use has all of its pictures to be found by.
void keep_all_pictures(const std::string& dataset, MappedCamera& camera) {
  if (camera.adjusted.T_map_camera.empty()) {
    camera.map.frames.clear();
    for (const RecordedPicture& picture : recorded_pictures(dataset, camera.name)) {
      camera.map.frames.push_back({picture.stamp, {}, true});
    }
  }
}

/// Thrown by what is told of progress, for there is nobody else to ask.
struct Interrupted {};

void say(const RigCalibration& told, const Judged& judged, const Json& figures) {
  std::printf(
      "%s: %s; %d observations in %zu keyframes, %d of them of points of other "
      "cameras' maps; reprojection %.2f px\n",
      std::string(name(judged.verdict)).c_str(), counted(told.cameras.size(), "camera").c_str(),
      told.bundle.observations, told.tracks.instants.size(), told.bundle.observations_other,
      told.bundle.rms_after_px);
  const RigCovariance& known = told.bundle.known;
  const Eigen::VectorXd sigma = known.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  for (std::size_t c = 0; c < told.cameras.size(); ++c) {
    const Pose3& T = told.bundle.state.T_body_camera[c];
    const Eigen::Index at = known.camera[c];
    std::printf(
        "  %s: at %.4f, %.4f, %.4f m +- %.1f, %.1f, %.1f mm; rotation +- %.3f deg; clock "
        "%+.1f ms",
        told.cameras[c].c_str(), T.translation.x(), T.translation.y(), T.translation.z(),
        1000 * sigma[at + 3], 1000 * sigma[at + 4], 1000 * sigma[at + 5],
        rad_to_deg(sigma.segment<3>(at).maxCoeff()), 1000 * told.bundle.state.clock_offset_s[c]);
    const Json& camera = figures["cameras"][as_utf8(told.cameras[c])];
    if (camera.contains("rotation_error_deg")) {
      std::printf("; as %s sees it off by %.3f deg, %.1f mm", told.cameras.front().c_str(),
                  camera["rotation_error_deg"].get<double>(),
                  1000 * camera["translation_error_m"].get<double>());
    }
    std::printf("\n");
    for (const std::string& what : known.unobservable[c]) {
      std::printf("    not seen: %s\n", what.c_str());
    }
  }
  if (told.bundle.has_wheels && !told.bundle.tells_metre) {
    std::printf(
        "  no metre: the robot never leaves where it begins; lengths are as the rig file has them; "
        "drive a motion with legs, or a rose\n");
  }
  if (told.bundle.tells_metre) {
    std::printf("  lengths are by the wheels' metre, which is known to %g %%\n",
                100 * told.wheels_known.sigma[kWayError]);
  }
  for (const std::string& reason : judged.reasons) {
    std::printf("  %s\n", reason.c_str());
  }
}

}  // namespace

std::string_view name(RigMethod method) {
  switch (method) {
    case RigMethod::kGuided:
      return "guided";
    case RigMethod::kThesis:
      return "thesis";
    case RigMethod::kCycles:
      return "cycles";
  }
  return "";
}

int calibrate_rig_of(const RigStage& args) {
  const auto lenses = stage_cameras(args.dataset, args.rig, args.cameras);
  if (args.method != RigMethod::kGuided && lenses.size() < 2) {
    throw ConfigError(fmt::format(
        "--method {}: tells cameras beside one another, and {} is the only one; give two at least, "
        "or use --method guided, which tells how one is mounted on the robot",
        name(args.method), lenses.front().first));
  }
  std::optional<RecordedWheels> wheels;
  if (read_part(fs::path(args.dataset) / kOdometryFile)) {
    wheels.emplace(args.dataset);
  } else if (lenses.size() < 2) {
    throw ConfigError(fmt::format(
        "{}: is missing, and without odometry one camera alone tells neither a length nor where "
        "it is mounted; record the odometry, or give a recording of several cameras",
        (fs::path(args.dataset) / kOdometryFile).string()));
  }
  for (const auto& [camera, believed] : lenses) {
    check_recording(args.dataset, camera, believed, args.slam);
    check_pictures(args.dataset, camera, believed.intrinsics);
    if (wheels) {
      wheels->check_reach(recorded_pictures(args.dataset, camera), believed);
    }
  }
  OutDir out(args.out, left_before(args));
  out.keep();
  Json figures{
      {"schema", "panoptes.metrics/1"}, {"command", "calibrate"}, {"stage", "rig"},
      {"version", PANOPTES_VERSION},    {"seed", args.seed},      {"outcome", "completed"}};
  Judged judged;
  Faults faults;
  const StopCondition stop_condition{StopOptions()};
  ProgressLine line(args.quiet);
  const auto parts = static_cast<double>(lenses.size()) + 1;
  const auto show = [&](const std::string& what, double done) {
    if (line.due()) {
      line.show(share_line(what, done / parts, line.wall_s()));
    }
  };
  std::vector<MappedCamera> cameras;
  for (const auto& [camera, believed] : lenses) {
    const auto before = static_cast<double>(cameras.size());
    const std::string what = "map of " + camera;
    std::optional<MappedCamera> made =
        mapped(args, out.path(), camera, believed, wheels ? GapsTold::kByWheels : GapsTold::kNot,
               stop_condition, [&](double done) { show(what, before + done); });
    if (!made) {
      std::fprintf(stderr, "interrupted: %zu of %zu maps are kept in %s; the same command %s\n",
                   cameras.size(), lenses.size(), args.out.c_str(),
                   cameras.empty() ? "begins again" : "goes on from there");
      return kInterrupted;
    }
    cameras.push_back(std::move(*made));
    keep_all_pictures(args.dataset, cameras.back());
  }
  std::optional<RigCalibration> told;
  std::vector<std::vector<RecordedPicture>> pictures;
  const WheelReadings readings =
      wheels ? WheelReadings([&](Time at) { return wheels->at(at); }) : nullptr;
  const FramePicture picture = [&](std::size_t c, std::size_t frame) {
    return read_grey_picture(args.dataset, pictures[c][frame]);
  };
  for (const MappedCamera& camera : cameras) {
    pictures.push_back(pictures_of(args.dataset, camera));
  }
  const auto together = [&](double done) {
    if (stop_condition.interrupted()) {
      throw Interrupted();
    }
    show("all cameras together", parts - 1 + done);
  };
  try {
    if (args.method != RigMethod::kGuided) {
      return calibrate_rig_by_maps(args, out.path(), cameras, picture,
                                   what_is_missing(args, cameras), std::move(figures), together);
    }
    RigCalibrationOptions options = args.calibration;
    options.known_together = whole_rig(args.dataset, args.rig).covariance;
    told = calibrate_rig(options, cameras, readings, picture, together);
    judged = judge_rig(cameras, *told);
  } catch (const Interrupted&) {
    std::fprintf(stderr,
                 "interrupted: all %zu maps are kept in %s; the same command goes on from there\n",
                 lenses.size(), args.out.c_str());
    return kInterrupted;
  } catch (const HandEyeError& error) {
    judged.verdict = Verdict::kFailed;
    judged.reasons.push_back(fmt::format(
        "stage rig: {}; --stage maps says and shows more of each camera", error.what()));
  }
  for (const std::string& missing : what_is_missing(args, cameras)) {
    judged.doubt(Verdict::kGood, missing);
  }
  if (told) {
    const Json of_rig = rig_figures(*told, true_rig(args.dataset));
    figures.update(of_rig);
    const Rig believed = whole_rig(args.dataset, args.rig);
    faults.attempt([&] {
      Rig found = calibrated(believed, *told);
      found.covariance = joint_covariance(*told);
      write_rig(out.path(), believed_after(found, believed, judged), told->cameras, judged.verdict);
    });
    write_rig_pictures(out.path(), *told, believed, judged.verdict, view_picture(cameras, picture),
                       faults);
    say(*told, judged, of_rig);
  } else {
    std::printf("failed: no rig is told\n");
    for (const std::string& reason : judged.reasons) {
      std::printf("  %s\n", reason.c_str());
    }
  }
  return write_judged(out.path(), std::move(figures), judged, faults);
}

}  // namespace panoptes
