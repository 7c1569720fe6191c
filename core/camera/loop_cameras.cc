// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/loop_cameras.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <set>

#include "core/base/error.h"

namespace panoptes {
namespace {

const std::string kLoopRole = "loop_";
constexpr double kSteep_rad = deg_to_rad(60);  // of the axis above or below the horizon
constexpr double kSharedView = 0.75;           // of the narrower picture, where two are one facing
constexpr int kSteepFacings =
    8;  // headings of a camera that sees the same at any: 45 degrees apart

Vec3 axis_body(const LoopCamera& camera) { return camera.T_body_camera.rotation * Vec3::UnitZ(); }

double azimuth_rad(const LoopCamera& camera) {
  const Vec3 axis = axis_body(camera);
  return std::atan2(axis.y(), axis.x());
}

double view_rad(const LoopCamera& camera) {
  return 2 * std::atan2(camera.intrinsics.width_px / 2.0, camera.intrinsics.fx_px);
}

bool near(double angle_rad, double other_rad, double within_rad) {
  return std::abs(wrap_angle(angle_rad - other_rad)) < within_rad;
}

// The same heading, the opposite one, then to the left and to the right.
std::vector<double> turns_of(const LoopCameras& cameras) {
  std::vector<double> turns{0};
  const auto add = [&](double turn_rad, double apart_rad) {
    if (std::none_of(turns.begin(), turns.end(),
                     [&](double known_rad) { return near(turn_rad, known_rad, apart_rad); })) {
      turns.push_back(turn_rad);
    }
  };
  for (const LoopCamera& a : cameras) {
    for (const LoopCamera& b : cameras) {
      if (!a.looks_steeply() && !b.looks_steeply()) {
        const double apart_rad = (1 - kSharedView) * std::min(view_rad(a), view_rad(b));
        add(wrap_angle(azimuth_rad(a) - azimuth_rad(b)), apart_rad);
      }
    }
  }
  if (std::any_of(cameras.begin(), cameras.end(),
                  [](const LoopCamera& camera) { return camera.looks_steeply(); })) {
    for (int k = 1; k < kSteepFacings; ++k) {
      const double turn_rad = 2 * std::numbers::pi * k / kSteepFacings;
      add(wrap_angle(turn_rad), std::numbers::pi / kSteepFacings);
    }
  }
  const auto opposite = std::min_element(
      turns.begin() + 1, turns.end(),
      [](double a_rad, double b_rad) { return std::abs(a_rad) > std::abs(b_rad); });
  if (opposite != turns.end()) {
    std::rotate(turns.begin() + 1, opposite, opposite + 1);
  }
  return turns;
}

}  // namespace

bool LoopCamera::looks_steeply() const {
  return std::abs(axis_body(*this).z()) > std::sin(kSteep_rad);
}

LoopCameras loop_cameras(const Rig& rig) {
  std::vector<std::string> roles{kLoopRole + "front", kLoopRole + "back"};
  std::set<std::string> others;
  for (const auto& [name, camera] : rig.cameras) {
    std::copy_if(camera.roles.begin(), camera.roles.end(), std::inserter(others, others.end()),
                 [&](const std::string& role) {
                   return is_loop_role(role) && role != roles[0] && role != roles[1];
                 });
  }
  roles.insert(roles.end(), others.begin(), others.end());
  LoopCameras cameras;
  for (const std::string& role : roles) {
    const std::string name = rig.with_role(role);
    const bool known = std::any_of(cameras.begin(), cameras.end(),
                                   [&](const LoopCamera& camera) { return camera.name == name; });
    if (!name.empty() && !known) {
      const RigCamera& camera = rig.cameras.at(name);
      cameras.push_back({name, role.substr(kLoopRole.size()), camera.intrinsics,
                         camera.T_body_camera, camera.clock_offset_s, camera.sigma});
    }
  }
  if (cameras.empty()) {
    throw ConfigError(
        "rig.cameras: no camera has a role that begins with loop_, such as loop_front, which "
        "closing loops needs");
  }
  return cameras;
}

Facing same_facing(const LoopCameras& cameras) {
  Facing facing;
  for (int camera = 0; camera < static_cast<int>(cameras.size()); ++camera) {
    facing.pairs.push_back({camera, camera});
  }
  return facing;
}

std::vector<Facing> facings(const LoopCameras& cameras) {
  std::vector<Facing> all;
  for (const double turn_rad : turns_of(cameras)) {
    Facing facing{turn_rad, {}};
    for (int a = 0; a < static_cast<int>(cameras.size()); ++a) {
      for (int b = 0; b < static_cast<int>(cameras.size()); ++b) {
        const LoopCamera& before = cameras[a];
        const LoopCamera& now = cameras[b];
        const bool steep = before.looks_steeply();
        const double apart_rad = (1 - kSharedView) * std::min(view_rad(before), view_rad(now));
        // the axis of `before`, then, points where that of `now` does
        if (steep ? a == b
                  : !now.looks_steeply() &&
                        near(azimuth_rad(before), turn_rad + azimuth_rad(now), apart_rad)) {
          facing.pairs.push_back({a, b, steep && turn_rad != 0});
        }
      }
    }
    all.push_back(std::move(facing));
  }
  return all;
}

}  // namespace panoptes
