// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/map_stage.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/camera_map.h"
#include "apps/calibrate/camera_map_truth.h"
#include "apps/calibrate/camera_pictures.h"
#include "apps/command/out_dir.h"
#include "apps/process/fault.h"
#include "apps/process/process.h"
#include "apps/process/progress.h"
#include "apps/process/stage_clock.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/utf8.h"
#include "core/eval/statistics.h"
#include "core/io/dataset.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// The cameras that are mapped, with their lenses.
std::vector<std::pair<std::string, Intrinsics>> lenses_of(const MapStage& args) {
  const std::optional<Rig> rig =
      args.rig.empty() ? rig_beside(args.dataset) : read_settings<Rig>(args.rig);
  if (!rig) {
    throw ConfigError(args.dataset +
                      ": has no rig.yaml, which says what its lenses are; give one with --rig");
  }
  std::vector<std::string> names = args.cameras;
  if (names.empty()) {
    for (const std::string& name : camera_folders(fs::path(args.dataset) / "mav0")) {
      if (rig->cameras.contains(name)) {
        names.push_back(name);
      }
    }
  }
  std::vector<std::pair<std::string, Intrinsics>> lenses;
  for (const std::string& name : names) {
    const auto found = rig->cameras.find(name);
    if (found == rig->cameras.end()) {
      throw ConfigError("the rig has no camera " + name);
    }
    lenses.emplace_back(name, found->second.intrinsics);
  }
  if (lenses.empty()) {
    throw ConfigError(args.dataset + ": has pictures of no camera of the rig");
  }
  return lenses;
}

double median_deg(std::vector<double> angles_rad) {
  std::sort(angles_rad.begin(), angles_rad.end());
  return angles_rad.empty() ? 0 : rad_to_deg(angles_rad[angles_rad.size() / 2]);
}

Json true_figures(const MonoMap& map, const TrueCameraPath& truth) {
  const CameraPathErrors errors = camera_path_errors(map.frames, truth);
  const std::vector<double>& heading = errors.heading_error_rad;
  if (std::getenv("DBG")) for (std::size_t i = 0; i < heading.size(); i += (i < 60 ? 2 : 15)) std::printf("HEAD %zu %.3f\n", i, rad_to_deg(heading[i]));
  Json figures{{"heading_error_deg", rad_to_deg(heading.back())},
               {"path_m", errors.path_m},
               {"path_error_percent",
                errors.path_m > 0 ? 100 * errors.position_rms_m / errors.path_m : 0},
               {"scale", errors.scale}};
  if (map.closed) {
    const std::size_t at = *map.closed;
    figures["heading_error_before_closure_deg"] = rad_to_deg(heading[at > 0 ? at - 1 : 0]);
    figures["heading_error_after_closure_deg"] =
        median_deg({heading.begin() + static_cast<std::ptrdiff_t>(at), heading.end()});
  }
  return figures;
}

Json figures_of(const CameraMap& told, const fs::path& dataset) {
  const MonoMap& map = told.map;
  Json figures{{"features", map.points.size()},
               {"nis", map.normalised_innovation},
               {"lost_s", map.lost_s},
               {"pictures", map.frames.size()},
               {"cpu_s", told.cpu_s}};
  if (map.closed) {
    figures["closed_s"] =
        to_seconds(map.frames[*map.closed].stamp - map.frames.front().stamp);
  }
  if (const std::optional<TrueCameraPath> truth = TrueCameraPath::read(dataset, told.camera)) {
    figures.update(true_figures(map, *truth));
  }
  return figures;
}

}  // namespace

int calibrate_maps(const MapStage& args) {
  const auto lenses = lenses_of(args);
  OutDir out(args.out);
  std::vector<CameraMap> all(lenses.size());
  {
    ProgressLine line(args.quiet);
    for (std::size_t i = 0; i < lenses.size(); ++i) {
      all[i] = map_camera(args.dataset, lenses[i].first, lenses[i].second, args.slam,
                          [&](double done) {
                            if (line.due()) {
                              line.show(share_line(
                                  "map of " + lenses[i].first,
                                  (static_cast<double>(i) + done) /
                                      static_cast<double>(lenses.size()),
                                  line.wall_s()));
                            }
                          });
    }
  }
  Json figures{{"schema", "panoptes.metrics/1"},
               {"command", "calibrate"},
               {"stage", "maps"},
               {"version", PANOPTES_VERSION},
               {"outcome", "completed"}};
  for (const CameraMap& told : all) {
    const Json of_map = figures_of(told, args.dataset);
    std::printf("%s: %s\n", told.camera.c_str(), of_map.dump().c_str());
    figures["cameras"][as_utf8(told.camera)]["map"] = of_map;
  }
  out.keep();
  write_file(out.path() / "metrics.json", figures.dump(2) + "\n");
  return 0;
}

}  // namespace panoptes
