// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/platform_figures.h"

#include <optional>
#include <variant>

#include <nlohmann/json.hpp>

#include "core/camera/mounting.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

std::optional<double> distortion_error(const Distortion& truth, const Distortion& believed) {
  const auto k1 = [](const Distortion& of) {
    const auto* brown = std::get_if<BrownConrady>(&of);
    return brown == nullptr ? 0 : brown->k1;
  };
  const auto* true_fisheye = std::get_if<Equidistant>(&truth);
  const auto* fisheye = std::get_if<Equidistant>(&believed);
  if ((true_fisheye == nullptr) != (fisheye == nullptr)) {
    return std::nullopt;
  }
  return fisheye != nullptr ? true_fisheye->k1 - fisheye->k1 : k1(truth) - k1(believed);
}

double percent(double truth, double believed) { return 100 * (truth / believed - 1); }

}  // namespace

Json camera_errors(const Rig& truth, const Rig& believed) {
  Json all = Json::object();
  for (const auto& [name, camera] : believed.cameras) {
    const auto found = truth.cameras.find(name);
    if (found == truth.cameras.end()) {
      continue;
    }
    const RigCamera& real = found->second;
    const MountingOffset off = mounting_offset(camera.T_body_camera, real.T_body_camera);
    const Intrinsics& told = camera.intrinsics;
    const Intrinsics& lens = real.intrinsics;
    Json& one = all[name];
    one = {{"roll_error_deg", rad_to_deg(off.rotation_rad.x())},
           {"pitch_error_deg", rad_to_deg(off.rotation_rad.y())},
           {"yaw_error_deg", rad_to_deg(off.rotation_rad.z())},
           {"x_error_m", off.shift_m.x()},
           {"y_error_m", off.shift_m.y()},
           {"z_error_m", off.shift_m.z()},
           {"focal_error_percent",
            (percent(lens.fx_px, told.fx_px) + percent(lens.fy_px, told.fy_px)) / 2},
           {"centre_error_px", {lens.cx_px - told.cx_px, lens.cy_px - told.cy_px}},
           {"clock_error_s", real.clock_offset_s - camera.clock_offset_s}};
    if (const auto distortion = distortion_error(lens.distortion, told.distortion)) {
      one["distortion_error"] = *distortion;
    }
  }
  return all;
}

Json wheel_errors(const TrueWheels& truth, const Body& believed) {
  const double mean_m = (truth.left_radius_m + truth.right_radius_m) / 2;
  return {{"radius_error_percent", percent(mean_m, believed.wheel_radius_m)},
          {"radius_ratio_error_percent", percent(truth.left_radius_m, truth.right_radius_m)},
          {"base_error_percent", percent(truth.base_m, believed.wheel_base_m)}};
}

}  // namespace panoptes
