// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/rig_errors.h"

#include <algorithm>
#include <numbers>
#include <utility>
#include <variant>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "core/base/error.h"
#include "core/camera/joint_covariance.h"

namespace panoptes::sim {
namespace {

constexpr double kMostClock_s = 10;

Vec3 three_normals(Rng& rng, double sigma) {
  const double x = rng.normal(0, sigma);
  const double y = rng.normal(0, sigma);
  const double z = rng.normal(0, sigma);
  return {x, y, z};
}

using Mounting = Eigen::Vector<double, 6>;  // a turn about the body's axes, a shift along them

Pose3 mounted_off(const Pose3& T_body_camera, const Mounting& by) {
  Pose3 T = T_body_camera;
  if (!by.head<3>().isZero(0)) {
    T.rotation = (turned_by(by.head<3>()) * T.rotation).normalized();
  }
  T.translation += by.tail<3>();
  return T;
}

Mounting drawn_mounting(const MountingError& error, Rng draw) {
  Mounting by;
  by << three_normals(draw, deg_to_rad(error.sigma_deg)), three_normals(draw, error.sigma_m);
  return by;
}

// Of all cameras at once, as what was calibrated together is off together. What is drawn for a
// camera is its own, so that rigs which hardly differ are off by much the same.
std::map<std::string, Mounting> mountings_as_known(const Rig& rig, const Rng& draw) {
  std::vector<std::string> parameters;
  const auto size = static_cast<Eigen::Index>(6 * rig.cameras.size());
  Eigen::VectorXd sigma(size);
  Eigen::VectorXd normals(size);
  for (const auto& [name, camera] : rig.cameras) {
    const auto at = static_cast<Eigen::Index>(parameters.size());
    const std::vector<std::string> all = joint_parameters(name, camera.intrinsics);
    parameters.insert(parameters.end(), all.begin(), all.begin() + 6);
    sigma.segment<6>(at) << camera.sigma.rotation_rad, camera.sigma.position_m;
    Rng of_camera = draw.fork(name);
    for (double& number : normals.segment<6>(at)) {
      number = of_camera.normal();
    }
  }
  const Eigen::MatrixXd together = rig.covariance ? correlations(*rig.covariance, parameters)
                                                  : Eigen::MatrixXd::Identity(size, size);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(together);
  const Eigen::MatrixXd& V = axes.eigenvectors();
  const Eigen::VectorXd root = axes.eigenvalues().cwiseMax(0).cwiseSqrt();
  const Eigen::VectorXd drawn =
      sigma.asDiagonal() * (V * (root.asDiagonal() * (V.transpose() * normals)));
  std::map<std::string, Mounting> by;
  for (const auto& [name, camera] : rig.cameras) {
    by[name] = drawn.segment<6>(static_cast<Eigen::Index>(6 * by.size()));
  }
  return by;
}

LensOffset drawn_lens(const LensError& error, Rng draw) {
  LensOffset offset;
  offset.focal_percent = draw.normal(0, error.sigma_focal_percent);
  offset.centre_px.x() = draw.normal(0, error.sigma_centre_px);
  offset.centre_px.y() = draw.normal(0, error.sigma_centre_px);
  offset.distortion = draw.normal(0, error.sigma_distortion);
  return offset;
}

Intrinsics with_offset(Intrinsics lens, const LensOffset& by) {
  lens.fx_px *= 1 + by.focal_percent / 100;
  lens.fy_px *= 1 + by.focal_percent / 100;
  lens.cx_px += by.centre_px.x();
  lens.cy_px += by.centre_px.y();
  if (by.distortion != 0) {
    if (lens.is_pinhole()) {
      lens.distortion = BrownConrady{};
    }
    if (auto* brown = std::get_if<BrownConrady>(&lens.distortion)) {
      brown->k1 += by.distortion;
    } else {
      std::get<Equidistant>(lens.distortion).k1 += by.distortion;
    }
  }
  return lens;
}

// Why no picture could be drawn through a lens that is off by so much.
std::string fault_of(const Intrinsics& lens, const LensOffset& by) {
  const bool is_off = by.focal_percent != 0 || !by.centre_px.isZero(0) || by.distortion != 0;
  if (lens.is_pinhole() || !is_off) {
    return {};
  }
  const bool axis_inside = lens.cx_px > 0 && lens.cy_px > 0 && lens.cx_px < lens.width_px - 1 &&
                           lens.cy_px < lens.height_px - 1;
  return axis_inside ? lens_fault(lens) : "must leave the lens' centre inside the picture";
}

template <class T>
void add_unknown(const std::map<std::string, T>& exactly, const std::string& key,
                 const Rig& nominal, std::vector<KeyFault>& faults) {
  std::vector<std::string> known;
  for (const auto& [name, camera] : nominal.cameras) {
    known.push_back(name);
  }
  for (const auto& [name, value] : exactly) {
    if (!nominal.cameras.contains(name)) {
      const std::string near = nearest_word(name, known);
      faults.push_back(
          {key + ".exactly." + name,
           "the rig has no camera " + name +
               (near.empty() ? "; name one of the rig's" : "; did you mean " + near + "?")});
    }
  }
}

}  // namespace

void bind(Fields& f, MountingError& o) {
  f("as_known", o.as_known);
  if (!f.writing() || !o.as_known) {
    f("sigma_deg", o.sigma_deg, between(0, 45));
    f("sigma_m", o.sigma_m, between(0, 1));
  }
  for (const char* key : {"sigma_deg", "sigma_m"}) {
    f.require(!o.as_known || !f.present(key), key,
              "must not be given beside as_known, by which the rig's own sigmas count");
  }
  f("exactly", o.exactly);
}

void bind(Fields& f, LensOffset& o) {
  f("focal_percent", o.focal_percent, between(-50, 100));
  f("centre_px", o.centre_px, between(-1000, 1000));
  f("distortion", o.distortion, between(-1, 1));
}

void bind(Fields& f, LensError& o) {
  f("sigma_focal_percent", o.sigma_focal_percent, between(0, 10));
  f("sigma_centre_px", o.sigma_centre_px, between(0, 100));
  f("sigma_distortion", o.sigma_distortion, between(0, 0.2));
  f("exactly", o.exactly);
}

void bind(Fields& f, ClockError& o) {
  f("sigma_s", o.sigma_s, between(0, 1));
  f("exactly", o.exactly, between(-kMostClock_s, kMostClock_s));
}

std::vector<KeyFault> rig_error_faults(const RigErrors& errors, const Rig& nominal) {
  std::vector<KeyFault> faults;
  add_unknown(errors.mounting.exactly, "mounting_error", nominal, faults);
  add_unknown(errors.lens.exactly, "lens_error", nominal, faults);
  add_unknown(errors.clock.exactly, "clock_error", nominal, faults);
  for (const auto& [name, offset] : errors.lens.exactly) {
    if (const auto camera = nominal.cameras.find(name); camera != nominal.cameras.end()) {
      const std::string fault = fault_of(with_offset(camera->second.intrinsics, offset), offset);
      if (!fault.empty()) {
        faults.push_back({"lens_error.exactly." + name, fault});
      }
    }
  }
  return faults;
}

Rig true_rig(const RigErrors& errors, const Rig& nominal, const Rng& rng) {
  const Rng mounting_rng = rng.fork("mounting");
  const Rng lens_rng = rng.fork("lens-errors");
  const Rng clock_rng = rng.fork("clock-errors");
  Rig rig = nominal;
  rig.covariance.reset();
  const std::map<std::string, Mounting> known =
      errors.mounting.as_known ? mountings_as_known(nominal, mounting_rng.fork("as known"))
                               : std::map<std::string, Mounting>();
  for (auto& [name, camera] : rig.cameras) {
    const auto mounting = errors.mounting.exactly.find(name);
    camera.T_body_camera =
        mounting != errors.mounting.exactly.end()
            ? displaced(camera.T_body_camera, mounting->second)
            : mounted_off(camera.T_body_camera,
                          errors.mounting.as_known
                              ? known.at(name)
                              : drawn_mounting(errors.mounting, mounting_rng.fork(name)));
    const auto lens = errors.lens.exactly.find(name);
    const LensOffset offset = lens == errors.lens.exactly.end()
                                  ? drawn_lens(errors.lens, lens_rng.fork(name))
                                  : lens->second;
    camera.intrinsics = with_offset(camera.intrinsics, offset);
    if (const std::string fault = fault_of(camera.intrinsics, offset); !fault.empty()) {
      throw ConfigError(fmt::format(
          "platform.lens_error: the camera {} with its centre off by ({:.1f}, {:.1f}) px and its "
          "distortion by {:.3f}: {}; lower sigma_centre_px and sigma_distortion, or take another "
          "seed",
          name, offset.centre_px.x(), offset.centre_px.y(), offset.distortion, fault));
    }
    const auto clock = errors.clock.exactly.find(name);
    camera.clock_offset_s += clock == errors.clock.exactly.end()
                                 ? clock_rng.fork(name).normal(0, errors.clock.sigma_s)
                                 : clock->second;
  }
  return rig;
}

}  // namespace panoptes::sim
