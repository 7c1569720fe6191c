// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/rng.h"
#include "core/calib/rig_bundle.h"
#include "core/calib/rig_views.h"
#include "core/camera/lens_parameters.h"
#include "core/camera/mounting.h"
#include "tests/support/driven_rose.h"

namespace panoptes {

/// What a rig sees as it drives: points about the place where it starts.
struct DrivenScene {
  bool shares = true;  ///< each camera sees the others' points
  double false_share = 0;
  double noise_px = 0.1;
  double wander_px = 0;  ///< noise of a point that one view hands on to the next of its camera
  double slide_px = 0;   ///< of a point that is seen from e times nearer, or from a radian aside
  int points_per_camera = 50;
  double near_m = 1.5;
  double far_m = 3;  ///< heights grow with it
};

/// A rig on a robot that drives amid points: the truth, what is believed of it, and its tracks.
struct DrivenRig {
  std::vector<RigCamera> truth;
  std::vector<RigCamera> believed;
  std::vector<Vec3> points_start;
  DrivenRose rose;
  RigTracks tracks;
  RigBundleState start;
};

/// The rig as it is believed to be, off the truth by what its sigmas say, each as the adjustment
/// weighs it; its clocks are believed to be right.
inline std::vector<RigCamera> drawn_belief(const std::vector<RigCamera>& truth, Rng& rng) {
  std::vector<RigCamera> believed;
  Rng lenses = rng.fork("lenses");
  for (const RigCamera& camera : truth) {
    RigCamera off = camera;
    const auto drawn = [&rng] {
      const double x = rng.normal();
      const double y = rng.normal();
      return Vec3(x, y, rng.normal());
    };
    const Vec3 turn_rad = camera.sigma.rotation_rad.cwiseProduct(drawn());
    const Vec3 shift_m = camera.sigma.position_m.cwiseProduct(drawn());
    off.T_body_camera = displaced(camera.T_body_camera, {turn_rad, shift_m});
    off.clock_offset_s = 0;
    constexpr double kTogether = 0.1;  // one focal length alone, of both
    Eigen::VectorXd lens = lens_parameters(camera.intrinsics);
    lens[0] *= 1 + camera.sigma.focal_ratio * rng.normal();
    lens[1] += lens[0] - camera.intrinsics.fx_px +
               kTogether * camera.sigma.focal_ratio * camera.intrinsics.fx_px * lenses.normal();
    lens[2] += camera.sigma.centre_px * rng.normal();
    lens[3] += camera.sigma.centre_px * rng.normal();
    for (Eigen::Index i = 4; i < lens.size(); ++i) {
      lens[i] += camera.sigma.focal_ratio * lenses.normal();
    }
    off.intrinsics = with_parameters(camera.intrinsics, lens);
    believed.push_back(off);
  }
  return believed;
}

/// Drives it. It starts as cameras' own maps tell: where points are is off by a hundredth of how
/// far they are, and what is farther than a room is anywhere nearer.
inline DrivenRig driven_rig(const std::vector<RigCamera>& truth, const DrivenScene& scene,
                            const RoseShape& rose, Rng rng) {
  DrivenRig out{truth, drawn_belief(truth, rng), {}, DrivenRose(rose, rng.fork("drive")), {}, {}};
  constexpr std::size_t kEvery = 9;
  constexpr std::size_t kFirst = 10;  // it stands still
  const Pose2 first = out.rose.T_start_body(out.rose.instant(kFirst));
  Rng by_map = rng.fork("by its own map");
  for (std::size_t i = kFirst; i + 10 < out.rose.instants(); i += kEvery) {
    const std::size_t instant = out.tracks.instants.size();
    out.tracks.instants.push_back(out.rose.instant(i));
    const Pose2 T_first_body = first.inverse() * out.rose.T_start_body(out.rose.instant(i));
    constexpr double kOff = 0.005;  // in m and rad
    out.start.T_start_body.push_back(on_floor({T_first_body.x_m + kOff * by_map.normal(),
                                               T_first_body.y_m + kOff * by_map.normal(),
                                               T_first_body.theta_rad + kOff * by_map.normal()}));
    for (std::size_t c = 0; c < truth.size(); ++c) {
      out.tracks.views.push_back(
          {c, instant, out.rose.instant(i) + from_seconds(truth[c].clock_offset_s)});
    }
  }
  out.start.T_start_body.front() = Pose3();
  std::vector<Pose3> T_start_camera;
  for (const RigView& view : out.tracks.views) {
    const RigCamera& camera = truth[view.camera];
    T_start_camera.push_back(
        on_floor(first.inverse() *
                 out.rose.T_start_body(view.stamp - from_seconds(camera.clock_offset_s))) *
        camera.T_body_camera);
  }
  constexpr double kRoom_m = 10;
  Rng distance = rng.fork("distance");
  const int points = scene.points_per_camera * static_cast<int>(truth.size());
  for (int p = 0; p < points; ++p) {
    const double angle_rad = rng.uniform(0, 2 * std::numbers::pi);
    const double far_m = rng.uniform(scene.near_m, scene.far_m);
    const double high_m = rng.uniform(0.2, 1.6) * (scene.far_m > kRoom_m ? far_m / 3 : 1);
    const Vec3 at(far_m * std::cos(angle_rad), far_m * std::sin(angle_rad), high_m);
    const auto of = static_cast<std::size_t>(p) % truth.size();
    std::vector<RigSeen> seen =
        sightings(truth, out.tracks.views, T_start_camera, at, out.start.points_start.size(), of);
    if (!scene.shares) {
      std::erase_if(seen, [](const RigSeen& each) { return !each.own; });
    }
    int own = 0;
    std::vector<Vec2> wander(truth.size(), Vec2::Zero());
    Eigen::Matrix2d slides = Eigen::Matrix2d::Zero();
    if (scene.slide_px > 0) {
      slides = Eigen::Matrix2d::NullaryExpr([&] { return scene.slide_px * rng.normal(); });
    }
    for (RigSeen& each : seen) {
      if (scene.wander_px > 0) {
        constexpr double kHandedOn = 0.9;
        Vec2& off = wander[out.tracks.views[each.view].camera];
        off = kHandedOn * off + std::sqrt(1 - kHandedOn * kHandedOn) * scene.wander_px *
                                    Vec2(rng.normal(), rng.normal());
        each.px += off;
      }
      if (scene.slide_px > 0) {
        const Vec3 away = at - T_start_camera[each.view].translation;
        each.px += slides * Vec2(std::log(far_m / away.norm()),
                                 std::atan2(at.x() * away.y() - at.y() * away.x(),
                                            at.x() * away.x() + at.y() * away.y()));
      }
      each.px += scene.noise_px * Vec2(rng.normal(), rng.normal());
      if (rng.uniform() < scene.false_share) {
        each.px += Vec2(9, -7);
      }
      own += each.own ? 1 : 0;
    }
    if (own >= 2) {
      out.tracks.seen.insert(out.tracks.seen.end(), seen.begin(), seen.end());
      out.points_start.push_back(at);
      const Vec3 off = 0.01 * far_m * Vec3(rng.normal(), rng.normal(), rng.normal());
      out.start.points_start.push_back((at + off) *
                                       (far_m > kRoom_m ? distance.uniform(0.1, 1) : 1));
    }
  }
  for (const RigCamera& camera : out.believed) {
    out.start.T_body_camera.push_back(camera.T_body_camera);
    out.start.lenses.push_back(camera.intrinsics);
    out.start.clock_offset_s.push_back(0);
  }
  return out;
}

/// Without what no picture makes surer: there are none.
inline RigBundle adjusted(DrivenRig& of) {
  RigBundleOptions options;
  options.systematic_lens_px = 0;
  options.systematic_distortion_px = 0;
  options.systematic_mounting_px = 0;
  return adjust_rig(
      options, of.believed, [&of](Time at) { return of.rose.wheels(at); }, of.tracks, of.start);
}

/// Turn and shift by which a camera is off as the first one sees it.
inline Eigen::Matrix<double, 6, 1> relative_error(const DrivenRig& of, const RigBundle& bundle,
                                                  std::size_t camera = 1) {
  const std::vector<Pose3>& all = bundle.state.T_body_camera;
  const Pose3 found = all.front().inverse() * all[camera];
  const Pose3 truth = of.truth.front().T_body_camera.inverse() * of.truth[camera].T_body_camera;
  const Eigen::AngleAxisd off(found.rotation * truth.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> e;
  e << off.angle() * off.axis(), found.translation - truth.translation;
  return e;
}

/// Turn about the body's axes and shift along them by which a camera is off on the body.
inline Eigen::Matrix<double, 6, 1> body_error(const DrivenRig& of, const RigBundle& bundle,
                                              std::size_t camera) {
  const Pose3& found = bundle.state.T_body_camera[camera];
  const Pose3& truth = of.truth[camera].T_body_camera;
  const Eigen::AngleAxisd off(found.rotation * truth.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> e;
  e << off.angle() * off.axis(), found.translation - truth.translation;
  return e;
}

}  // namespace panoptes
