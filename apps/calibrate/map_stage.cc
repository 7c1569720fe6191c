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
#include "apps/command/out_dir.h"
#include "apps/draw/pictures.h"
#include "apps/process/fault.h"
#include "apps/process/process.h"
#include "apps/process/progress.h"
#include "apps/process/stage_clock.h"
#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/calib/map_verdict.h"
#include "core/eval/camera_path.h"
#include "core/eval/statistics.h"
#include "core/io/csv.h"
#include "core/io/dataset.h"
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
  Json figures{{"keyframes", adjusted.keyframes.size()},
               {"points", adjusted.points.size()},
               {"observations", adjusted.observations},
               {"left_out", adjusted.left_out},
               {"fx_px", adjusted.lens.fx_px},
               {"cx_px", adjusted.lens.cx_px},
               {"cy_px", adjusted.lens.cy_px},
               {"converged", adjusted.converged},
               {"cpu_s", told.adjust_s}};
  if (told.adjusted_errors) {
    figures["heading_error_deg"] =
        rad_to_deg(quantile(told.adjusted_errors->heading_error_rad, 0.5));
    figures["path_error_percent"] = percent(*told.adjusted_errors);
  }
  return figures;
}

Json figures_of(const CameraMap& told) {
  const MonoMap& map = told.map;
  Json figures{{"features", map.points.size()}, {"nis", map.normalised_innovation},
               {"lost_s", map.lost_s},          {"pictures", map.frames.size()},
               {"begins_s", told.begins_s},     {"cpu_s", told.cpu_s}};
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
    poses.push_back({frame.stamp, frame.T_map_camera});
  }
  write_tum(path, poses);
}

void write_points(const fs::path& path, const MonoMap& map) {
  CsvWriter table(
      path, {"point", "x_m", "y_m", "z_m", "sigma_m", "pictures", "first_u_px", "first_v_px"});
  for (const MonoMap::Point& point : map.points) {
    table << point.number << point.p_map.x() << point.p_map.y() << point.p_map.z()
          << std::sqrt(point.covariance.trace() / 3) << static_cast<int>(point.seen.size())
          << point.feature.px.x() << point.feature.px.y();
    table.end_row();
  }
  table.finish();
}

void say(const CameraMap& told, const Judged& judged, const Json& figures) {
  std::printf("%s: %s; %zu points from %zu pictures", told.camera.c_str(),
              std::string(name(judged.verdict)).c_str(), told.map.points.size(),
              told.map.frames.size());
  if (told.begins_s > 0) {
    std::printf(", begun anew after %.1f s", told.begins_s);
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
  }
  std::printf("\n");
  for (const std::string& reason : judged.reasons) {
    std::printf("  %s\n", reason.c_str());
  }
}

}  // namespace

int calibrate_maps(const MapStage& args) {
  const auto lenses = stage_cameras(args.dataset, args.rig, args.cameras);
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
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    const auto& [camera, believed] = lenses[i];
    const CameraMap told =
        map_camera(args.dataset, camera, believed, args.slam, args.bundle, [&](double done) {
          if (line.due()) {
            line.show(
                share_line("map of " + camera,
                           (static_cast<double>(i) + done) / static_cast<double>(lenses.size()),
                           line.wall_s()));
          }
        });
    Json of_map = figures_of(told);
    const Judged judged = judge_map(told.map, told.adjusted, believed);
    worst = std::max(worst, judged.verdict);
    of_map["verdict"] = name(judged.verdict);
    of_map["warnings"] = judged.reasons;
    figures["cameras"][as_utf8(camera)]["map"] = of_map;
    faults.attempt([&] { write_path(out.path() / ("path_" + camera + ".tum"), told.map); });
    faults.attempt([&] { write_points(out.path() / ("points_" + camera + ".csv"), told.map); });
    faults.attempt(
        [&] { write_file(out.path() / ("map_" + camera + ".png"), png(draw_camera_map(told))); });
    faults.attempt(
        [&] { write_file(out.path() / ("growth_" + camera + ".png"), png(draw_growth(told))); });
    if (!told.looked_at.grey.empty()) {
      faults.attempt(
          [&] { write_file(out.path() / ("search_" + camera + ".png"), png(draw_search(told))); });
    }
    if (!told.keyframe_grey.empty()) {
      faults.attempt([&] {
        write_file(out.path() / ("reprojection_" + camera + ".png"), png(draw_reprojection(told)));
      });
    }
    say(told, judged, of_map);
  }
  figures["verdict"] = name(worst);
  if (worst == Verdict::kFailed || !faults.none()) {
    figures["outcome"] = "failed";
  }
  if (!faults.none()) {
    figures["fault"] = as_utf8(faults.text());
  }
  const ProcessUse use = process_use();
  figures["wall_s"] = use.wall_s;
  figures["cpu_s"] = use.cpu_s;
  figures["peak_memory_mb"] = use.peak_memory_mb;
  faults.attempt([&] { write_file(out.path() / "metrics.json", figures.dump(2) + "\n"); });
  return !faults.none() ? faults.status() : worst == Verdict::kFailed ? 1 : 0;
}

}  // namespace panoptes
