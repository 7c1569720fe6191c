// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/platform_figures.h"

#include <cmath>
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

/// `key`, `key_sigma` and `key_error`, in the unit that `key` says.
void put_learned(Json& into, const std::string& key, const std::optional<LearnedValue>& learned,
                 double units = 1) {
  if (!learned) {
    return;
  }
  into[key] = units * learned->value;
  into[key + "_sigma"] = units * learned->sigma;
  if (learned->error) {
    into[key + "_error"] = units * *learned->error;
  }
}

Json camera_json(const LearnedCamera& camera) {
  const double degrees = rad_to_deg(1);
  Json one = Json::object();
  put_learned(one, "yaw_correction_deg", camera.yaw_rad, degrees);
  put_learned(one, "pitch_correction_deg", camera.pitch_rad, degrees);
  put_learned(one, "roll_correction_deg", camera.roll_rad, degrees);
  put_learned(one, "x_correction_m", camera.x_m);
  put_learned(one, "y_correction_m", camera.y_m);
  put_learned(one, "z_correction_m", camera.z_m);
  put_learned(one, "clock_offset_s", camera.clock_s);
  put_learned(one, "centre_bearing_correction_deg", camera.centre_bearing_rad, degrees);
  if (camera.centre_bearing_rad && camera.centre_bearing_rad->error) {
    one["centre_bearing_error_deg"] = degrees * std::abs(*camera.centre_bearing_rad->error);
  }
  if (camera.position_error_m) {
    one["position_error_m"] = *camera.position_error_m;
  }
  if (camera.consistency) {
    one["error_chi2"] = camera.consistency->chi2;
    one["error_freedom"] = camera.consistency->freedom;
    one["error_inside_95"] = camera.consistency->inside_95 ? 1 : 0;
  }
  return one;
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

Json rig_json(const std::map<std::string, LearnedCamera>& cameras) {
  Json all = Json::object();
  for (const auto& [name, camera] : cameras) {
    if (Json one = camera_json(camera); !one.empty()) {
      all[name] = std::move(one);
    }
  }
  return all;
}

Json wheels_json(const LearnedWheels& wheels) {
  Json json = Json::object();
  put_learned(json, "radius_ratio", wheels.radius_ratio);
  put_learned(json, "base", wheels.base_m);
  return json;
}

void put_wheel_errors(Json& wheels, const TrueWheels& truth) {
  const std::map<std::string, double> known{
      {"radius_ratio", truth.left_radius_m / truth.right_radius_m}, {"base", truth.base_m}};
  for (const auto& [key, value] : known) {
    if (wheels.contains(key)) {
      wheels[key + "_error"] = wheels[key].get<double>() - value;
    }
  }
}

}  // namespace panoptes
