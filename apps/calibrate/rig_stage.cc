// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_stage.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/camera_map.h"
#include "apps/calibrate/recorded_wheels.h"
#include "apps/calibrate/saved_map.h"
#include "apps/calibrate/stage_cameras.h"
#include "apps/command/out_dir.h"
#include "apps/process/fault.h"
#include "apps/process/process.h"
#include "apps/process/progress.h"
#include "apps/process/stage_clock.h"
#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/camera/lens_parameters.h"
#include "core/config/sha256.h"
#include "core/io/dataset.h"
#include "core/io/dataset_rows.h"
#include "core/io/file.h"
#include "hw/replay/truth_files.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string made_of(const RigStage& args, const std::string& camera, const Intrinsics& lens) {
  std::string text = read_part(fs::path(args.dataset) / data_csv(camera)).value_or("");
  const Eigen::VectorXd numbers = lens_parameters(lens);
  for (const double number : numbers) {
    text += fmt::format(" {}", number);
  }
  text += fmt::format(" {} {}", name(args.slam.features), PANOPTES_VERSION);
  return sha256(text);
}

std::optional<Rig> true_rig(const fs::path& dataset) {
  const std::optional<hw::RecordedTruth> recorded = hw::RecordedTruth::read(dataset);
  if (!recorded || recorded->observations() == 0) {
    return std::nullopt;
  }
  return recorded->after(recorded->observations()).rig;
}

}  // namespace

int calibrate_rig_of(const RigStage& args) {
  const auto lenses = stage_cameras(args.dataset, args.rig, args.cameras);
  const RecordedWheels wheels(args.dataset);
  const fs::path out(args.out);
  fs::create_directories(out);
  ProgressLine line(args.quiet);
  std::vector<MappedCamera> cameras;
  std::vector<std::vector<RecordedPicture>> pictures;
  for (const auto& [camera, believed] : lenses) {
    const fs::path file = out / ("map_" + camera + ".json");
    const std::string of = made_of(args, camera, believed.intrinsics);
    MappedCamera mapped{camera, believed, {}, {}};
    if (std::optional<MonoMap> saved = read_map(file, of, believed.intrinsics)) {
      mapped.map = std::move(*saved);
      mapped.adjusted = adjust_map(args.bundle, believed.intrinsics, believed.sigma, mapped.map);
    } else {
      CameraMap told =
          map_camera(args.dataset, camera, believed, args.slam, args.bundle, [&](double done) {
            if (line.due()) {
              line.show(share_line("map of " + camera, done, line.wall_s()));
            }
          });
      mapped.map = std::move(told.map);
      mapped.adjusted = std::move(told.adjusted);
      write_map(file, of, mapped.map);
    }
    cameras.push_back(std::move(mapped));
    pictures.push_back(recorded_pictures(args.dataset, camera));
    pictures.back().erase(
        pictures.back().begin(),
        pictures.back().begin() +
            static_cast<std::ptrdiff_t>(pictures.back().size() - cameras.back().map.frames.size()));
  }
  const double before_s = process_use().cpu_s;
  const RigCalibration told = calibrate_rig(
      args.calibration, cameras, [&](Time at) { return wheels.at(at); },
      [&](std::size_t c, std::size_t frame) {
        return read_grey_picture(args.dataset, pictures[c][frame]);
      },
      [&](double done) {
        if (line.due()) {
          line.show(share_line("rig", done, line.wall_s()));
        }
      });
  std::printf(
      "%.1f CPU s; %d observations, %d of other cameras, %d left out; rms %.3f -> %.3f px; %s\n",
      process_use().cpu_s - before_s, told.bundle.observations, told.bundle.observations_other,
      told.bundle.left_out, told.bundle.rms_before_px, told.bundle.rms_after_px,
      told.bundle.converged ? "converged" : "not converged");
  const std::optional<Rig> truth = true_rig(args.dataset);
  const RigState& state = told.bundle.state;
  const RigCovariance& known = told.bundle.known;
  std::printf("wheels %.4f %.4f %.4f sigma %.4f %.4f %.4f\n", state.wheel_errors[0],
              state.wheel_errors[1], state.wheel_errors[2],
              std::sqrt(known.covariance(known.wheels, known.wheels)),
              std::sqrt(known.covariance(known.wheels + 1, known.wheels + 1)),
              std::sqrt(known.covariance(known.wheels + 2, known.wheels + 2)));
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const PlanarHandEye& alone = told.hand_eye[c];
    std::printf(
        "%s: own %.3f px, other %.3f px; sigmas %s; clock %.2f ms\n", cameras[c].name.c_str(),
        told.bundle.sigma_own_px[c], told.bundle.sigma_other_px[c],
        fmt::format(
            "{:.4f}",
            fmt::join(
                std::vector<double>{
                    rad_to_deg(std::sqrt(known.covariance(known.camera[c], known.camera[c]))),
                    rad_to_deg(
                        std::sqrt(known.covariance(known.camera[c] + 1, known.camera[c] + 1))),
                    rad_to_deg(
                        std::sqrt(known.covariance(known.camera[c] + 2, known.camera[c] + 2))),
                    1000 * std::sqrt(known.covariance(known.camera[c] + 3, known.camera[c] + 3)),
                    1000 * std::sqrt(known.covariance(known.camera[c] + 4, known.camera[c] + 4)),
                    1000 * std::sqrt(known.covariance(known.camera[c] + 5, known.camera[c] + 5))},
                " "))
            .c_str(),
        1000 * state.clock_offset_s[c]);
    for (const std::string& word : known.unobservable[c]) {
      std::printf("  not seen: %s\n", word.c_str());
    }
    if (truth) {
      const RigCamera& real = truth->cameras.at(cameras[c].name);
      const auto tell = [&](const char* what, const Pose3& T_body_camera, double clock_s) {
        const Eigen::AngleAxisd off(T_body_camera.rotation *
                                    real.T_body_camera.rotation.conjugate());
        const Vec3 turn = rad_to_deg(off.angle()) * off.axis();
        const Vec3 shift = 1000 * (T_body_camera.translation - real.T_body_camera.translation);
        std::printf(
            "  %-8s roll %.3f pitch %.3f yaw %.3f deg; x %.1f y %.1f z %.1f mm; clock %.2f ms\n",
            what, turn.x(), turn.y(), turn.z(), shift.x(), shift.y(), shift.z(),
            1000 * (clock_s - real.clock_offset_s));
      };
      tell("file", cameras[c].believed.T_body_camera, cameras[c].believed.clock_offset_s);
      tell("alone", alone.T_body_camera, alone.clock_offset_s);
      tell("rig", state.T_body_camera[c], state.clock_offset_s[c]);
      if (c > 0) {
        const RigCamera& ref = truth->cameras.at(cameras[0].name);
        const Pose3 real_rel = ref.T_body_camera.inverse() * real.T_body_camera;
        const Pose3 rel = state.T_body_camera[0].inverse() * state.T_body_camera[c];
        const Eigen::AngleAxisd off(rel.rotation * real_rel.rotation.conjugate());
        Eigen::Matrix<double, 6, 1> e;
        e << off.angle() * off.axis(), rel.translation - real_rel.translation;
        const Eigen::Matrix<double, 6, 6> P = known.relative(state, 0, c);
        std::printf("  relative %.4f deg, %.2f mm; normalised %.2f\n", rad_to_deg(off.angle()),
                    1000 * e.tail<3>().norm(), e.dot(P.ldlt().solve(e)) / 6);
      }
    }
  }
  return 0;
}

}  // namespace panoptes
