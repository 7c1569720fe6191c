// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/map_stage.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/camera_map.h"
#include "apps/calibrate/map_picture.h"
#include "apps/calibrate/stage_cameras.h"
#include "apps/calibrate/stage_metrics.h"
#include "apps/command/out_dir.h"
#include "apps/draw/pictures.h"
#include "apps/mission/stop_condition.h"
#include "apps/process/fault.h"
#include "apps/process/process.h"
#include "apps/process/progress.h"
#include "core/base/text.h"
#include "core/base/utf8.h"
#include "core/calib/map_verdict.h"
#include "core/camera/lens_parameters.h"
#include "core/eval/camera_path.h"
#include "core/eval/statistics.h"
#include "core/io/csv.h"
#include "core/io/file.h"
#include "core/io/tum.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

double percent(const CameraPathErrors& errors) {
  return errors.path_m > 0 ? 100 * errors.position_rms_m / errors.path_m : 0;
}

Json adjusted_figures(const CameraMap& told) {
  const AdjustedMap& adjusted = told.adjusted;
  Json figures{{"keyframes", adjusted.keyframes.size()}, {"points", adjusted.points.size()},
               {"observations", adjusted.observations},  {"left_out", adjusted.left_out},
               {"converged", adjusted.converged},        {"cpu_s", told.adjust_s}};
  const Eigen::VectorXd lens = lens_parameters(adjusted.lens);
  const std::vector<std::string> names = lens_parameter_names(adjusted.lens);
  for (std::size_t i = 0; i < names.size(); ++i) {
    figures["lens"][names[i]] = lens[static_cast<Eigen::Index>(i)];
  }
  if (told.adjusted_errors) {
    figures["heading_error_deg"] =
        rad_to_deg(quantile(told.adjusted_errors->heading_error_rad, 0.5));
    figures["path_error_percent"] = percent(*told.adjusted_errors);
  }
  return figures;
}

Json figures_of(const CameraMap& told) {
  const MonoMap& map = told.map;
  Json figures{{"features", map.points.size()},
               {"nis", map.normalised_innovation},
               {"lost_s", map.lost_s},
               {"lost", Json::array()},
               {"pictures", map.frames.size()},
               {"begins_s", map.begins_s},
               {"cpu_s", told.cpu_s}};
  for (const LostSpan& span : lost_spans(map)) {
    figures["lost"].push_back({span.from_s, span.to_s});
  }
  if (told.cut_short_s) {
    figures["cut_short_s"] = *told.cut_short_s;
  }
  if (map.closed) {
    figures["closed_s"] = to_seconds(map.frames[*map.closed].stamp - map.frames.front().stamp);
  }
  if (told.errors) {
    const std::vector<double>& heading = told.errors->heading_error_rad;
    figures["heading_error_deg"] = rad_to_deg(heading.back());
    figures["path_m"] = told.errors->path_m;
    figures["path_error_percent"] = percent(*told.errors);
    figures["scale"] = told.errors->scale;
    if (map.closed) {
      const auto at = static_cast<std::ptrdiff_t>(*map.closed);
      figures["heading_error_before_closure_deg"] =
          rad_to_deg(heading[*map.closed > 0 ? *map.closed - 1 : 0]);
      figures["heading_error_after_closure_deg"] =
          rad_to_deg(quantile({heading.begin() + at, heading.end()}, 0.5));
    }
  }
  if (!told.adjusted.T_map_camera.empty()) {
    figures["reprojection_rms_px"] = {{"before", told.adjusted.rms_before_px},
                                      {"after", told.adjusted.rms_after_px}};
    figures["adjusted"] = adjusted_figures(told);
  }
  return figures;
}

void write_path(const fs::path& path, const MonoMap& map) {
  std::vector<TumPose> poses;
  for (const MonoMap::Frame& frame : map.frames) {
    if (!frame.lost) {
      poses.push_back({frame.stamp, frame.T_map_camera});
    }
  }
  write_tum(path, poses);
}

void write_keyframes(const fs::path& path, const MonoMap& map, const AdjustedMap& adjusted) {
  std::vector<TumPose> poses;
  for (std::size_t i = 0; i < adjusted.keyframes.size(); ++i) {
    const auto frame = static_cast<std::size_t>(adjusted.keyframes[i]);
    poses.push_back({map.frames[frame].stamp, adjusted.T_map_camera[i]});
  }
  write_tum(path, poses);
}

// Both have their points in the order of their numbers.
void write_points(const fs::path& path, const MonoMap& map, const AdjustedMap& adjusted) {
  CsvWriter table(path, {"point", "x_m", "y_m", "z_m", "sigma_m", "pictures", "first_u_px",
                         "first_v_px", "adjusted_x_m", "adjusted_y_m", "adjusted_z_m"});
  auto next = adjusted.points.begin();
  for (const MonoMap::Point& point : map.points) {
    table << point.number << point.p_map.x() << point.p_map.y() << point.p_map.z()
          << std::sqrt(point.covariance.trace() / 3) << static_cast<int>(point.seen.size())
          << point.feature.px.x() << point.feature.px.y();
    while (next != adjusted.points.end() && next->number < point.number) {
      ++next;
    }
    if (next != adjusted.points.end() && next->number == point.number && next->observations > 1) {
      table << next->p_map.x() << next->p_map.y() << next->p_map.z();
    } else {
      table.skip().skip().skip();
    }
    table.end_row();
  }
  table.finish();
}

void say(const CameraMap& told, const Judged& judged, const Json& figures) {
  std::printf("%s: %s; %s from %s", told.camera.c_str(), std::string(name(judged.verdict)).c_str(),
              counted(told.map.points.size(), "point").c_str(),
              counted(told.map.frames.size(), "picture").c_str());
  if (told.map.begins_s > 0) {
    std::printf(", begun anew after %.1f s", told.map.begins_s);
  }
  if (told.map.closed) {
    std::printf(", closed after %.0f s", figures["closed_s"].get<double>());
  }
  if (figures.contains("heading_error_deg")) {
    std::printf(", heading off by %.2f deg at the end, path by %.2f %%",
                figures["heading_error_deg"].get<double>(),
                figures["path_error_percent"].get<double>());
  }
  if (figures.contains("reprojection_rms_px")) {
    std::printf("; reprojection %.2f px, %.2f px adjusted",
                figures["reprojection_rms_px"]["before"].get<double>(),
                figures["reprojection_rms_px"]["after"].get<double>());
    const Json& adjusted = figures["adjusted"];
    if (adjusted.contains("heading_error_deg")) {
      std::printf(", heading then off by %.3f deg, path by %.3f %%",
                  adjusted["heading_error_deg"].get<double>(),
                  adjusted["path_error_percent"].get<double>());
    }
  }
  std::printf("\n");
  for (const std::string& reason : judged.reasons) {
    std::printf("  %s\n", reason.c_str());
  }
}

// A map that was cut short says so.
Judged judged(const CameraMap& told, const RigCamera& believed) {
  Judged judged = judge_map(told.map, told.adjusted, believed);
  if (told.cut_short_s) {
    judged.doubt(Verdict::kPoor, fmt::format("it is of the first {:.1f} s of the recording alone",
                                             *told.cut_short_s));
  }
  return judged;
}

void write_tables(const fs::path& folder, const CameraMap& told, Faults& faults) {
  const auto file = [&](const char* what, const char* ending) {
    return folder / (what + told.camera + ending);
  };
  faults.attempt([&] { write_path(file("path_", ".tum"), told.map); });
  faults.attempt([&] { write_points(file("points_", ".csv"), told.map, told.adjusted); });
  if (!told.adjusted.T_map_camera.empty()) {
    faults.attempt([&] { write_keyframes(file("keyframes_", ".tum"), told.map, told.adjusted); });
  }
}

void write_pictures(const fs::path& folder, const CameraMap& told, Faults& faults) {
  const auto write = [&](const char* what, cv::Mat (*draw)(const CameraMap&)) {
    faults.attempt([&] { write_file(folder / (what + told.camera + ".png"), png(draw(told))); });
  };
  write("map_", draw_camera_map);
  if (!told.growth.empty()) {
    write("growth_", draw_growth);
  }
  if (!told.looked_at.grey.empty()) {
    write("search_", draw_search);
  }
  if (!told.keyframe_grey.empty()) {
    write("reprojection_", draw_reprojection);
  }
}

}  // namespace

int calibrate_maps(const MapStage& args) {
  const StopCondition stop_condition{StopOptions()};
  const auto lenses = stage_cameras(args.dataset, args.rig, args.cameras);
  for (const auto& [camera, believed] : lenses) {
    check_recording(args.dataset, camera, believed, args.slam);
  }
  OutDir out(args.out);
  Json figures{{"schema", "panoptes.metrics/1"},
               {"command", "calibrate"},
               {"stage", "maps"},
               {"version", PANOPTES_VERSION},
               {"outcome", "completed"}};
  Verdict worst = Verdict::kGood;
  Faults faults;
  ProgressLine line(args.quiet);
  out.keep();
  for (std::size_t i = 0; i < lenses.size() && !stop_condition.interrupted(); ++i) {
    const auto& [camera, believed] = lenses[i];
    const CameraMap told =
        map_camera(args.dataset, camera, believed, args.slam, args.bundle, GapsTold::kNot,
                   [&](double done) {
                     if (line.due()) {
                       line.show(share_line(
                           "map of " + camera,
                           (static_cast<double>(i) + done) / static_cast<double>(lenses.size()),
                           line.wall_s()));
                     }
                   },
                   {[&] { return stop_condition.interrupted(); }, &faults});
    Json of_map = figures_of(told);
    const Judged judgement = judged(told, believed);
    worst = std::max(worst, judgement.verdict);
    of_map["verdict"] = name(judgement.verdict);
    of_map["warnings"] = judgement.reasons;
    figures["cameras"][as_utf8(camera)]["map"] = of_map;
    write_tables(out.path(), told, faults);
    if (!stop_condition.hurried()) {
      write_pictures(out.path(), told, faults);
    }
    say(told, judgement, of_map);
  }
  if (figures.contains("cameras")) {
    figures["verdict"] = name(worst);
  }
  const bool interrupted = stop_condition.interrupted();
  if (interrupted || worst == Verdict::kFailed || !faults.none()) {
    figures["outcome"] = interrupted ? "interrupted" : "failed";
  }
  write_metrics(out.path(), figures, faults);
  return !faults.none() ? faults.status() : interrupted ? kInterrupted : worst == Verdict::kFailed;
}

}  // namespace panoptes
