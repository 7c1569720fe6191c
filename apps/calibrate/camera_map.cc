// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/camera_map.h"

#include <vector>

#include <fmt/format.h>

#include "apps/calibrate/missing_pictures.h"
#include "apps/calibrate/recorded_wheels.h"
#include "apps/calibrate/true_camera_path.h"
#include "apps/process/stage_clock.h"
#include "core/base/error.h"
#include "core/calib/odometry_prior.h"
#include "core/io/dataset.h"
#include "core/io/dataset_rows.h"

namespace panoptes {
namespace {

constexpr std::size_t kQuarters = 4;

/// Between two of the camera's stamps. Empty where the odometry does not reach.
std::optional<MotionTold> told_between(const RecordedWheels& wheels, const RigCamera& camera,
                                       Time before, Time now) {
  const Duration late = from_seconds(camera.clock_offset_s);
  const std::optional<Odometry> from = wheels.at(before - late);
  const std::optional<Odometry> to = wheels.at(now - late);
  return from && to
             ? std::optional(camera_motion(from->T_odom_body.inverse() * to->T_odom_body, camera))
             : std::nullopt;
}

void add_errors(const TrueCameraPath& truth, CameraMap& told) {
  std::vector<Pose3> path;
  std::vector<Pose3> true_path;
  for (const MonoMap::Frame& frame : told.map.frames) {
    path.push_back(frame.T_map_camera);
    true_path.push_back(truth.T_scene_camera(frame.stamp));
  }
  told.errors = camera_path_errors(path, true_path);
  if (!told.adjusted.T_map_camera.empty()) {
    std::vector<Pose3> of_keyframes;
    for (const int frame : told.adjusted.keyframes) {
      of_keyframes.push_back(true_path[static_cast<std::size_t>(frame)]);
    }
    told.adjusted_errors = camera_path_errors(told.adjusted.T_map_camera, of_keyframes);
  }
}

std::vector<RecordedPicture> pictures_of(const std::filesystem::path& dataset,
                                         const std::string& camera) {
  std::vector<RecordedPicture> pictures = recorded_pictures(dataset, camera);
  if (pictures.empty()) {
    throw ConfigError(
        (dataset / data_csv(camera)).string() +
        ": has no pictures; copy the recording again, or name the cameras that have some with "
        "--cameras");
  }
  return pictures;
}

/// Pictures farther apart are no neighbours.
double least_gap_s(const std::vector<RecordedPicture>& pictures) {
  constexpr double kPeriods = 1.5;
  std::vector<Time> stamps;
  for (const RecordedPicture& picture : pictures) {
    stamps.push_back(picture.stamp);
  }
  return kPeriods * picture_period_s(stamps);
}

cv::Mat grey_picture(const std::filesystem::path& dataset, const std::string& camera,
                     const Intrinsics& lens, const RecordedPicture& picture) {
  cv::Mat grey = read_grey_picture(dataset, picture);
  if (grey.cols != lens.width_px || grey.rows != lens.height_px) {
    throw ConfigError(
        fmt::format("{}: is {} x {} pixels, and the lens of {} is for {} x {}; give the rig "
                    "file that these pictures were taken with, with --rig",
                    picture.mention, grey.cols, grey.rows, camera, lens.width_px, lens.height_px));
  }
  return grey;
}

}  // namespace

void check_recording(const std::filesystem::path& dataset, const std::string& camera,
                     const RigCamera& believed, const MonoSlamOptions& options) {
  const std::vector<RecordedPicture> pictures = pictures_of(dataset, camera);
  grey_picture(dataset, camera, believed.intrinsics, pictures.front());
  if (options.motion_is_told) {
    RecordedWheels(dataset.string()).check_reach(pictures, believed);
  }
}

CameraMap map_camera(const std::filesystem::path& dataset, const std::string& camera,
                     const RigCamera& believed, const MonoSlamOptions& options,
                     const KeyframeBundleOptions& bundle, GapsTold gaps,
                     const std::function<void(double)>& progress, const MapEnds& ends) {
  const std::vector<RecordedPicture> pictures = pictures_of(dataset, camera);
  const Intrinsics& lens = believed.intrinsics;
  CameraMap told;
  told.camera = camera;
  told.lens = lens;
  MonoSlamOptions known = options;
  known.filter.focal_ratio = believed.sigma.focal_ratio;
  known.filter.centre_px = believed.sigma.centre_px;
  MonoSlam slam(known, lens);
  std::optional<RecordedWheels> wheels;
  if (options.motion_is_told || gaps == GapsTold::kByWheels) {
    wheels.emplace(dataset.string());
  }
  const double gap_s = options.motion_is_told ? 0 : least_gap_s(pictures);
  MonoMapBuilder builder;
  const Time first = pictures.front().stamp;
  told.growth_from = first;
  std::size_t read = 0;
  for (; read < pictures.size() && !(ends.interrupted && ends.interrupted()); ++read) {
    const RecordedPicture& picture = pictures[read];
    cv::Mat grey;
    const auto read_it = [&] { grey = grey_picture(dataset, camera, lens, picture); };
    if (ends.faults == nullptr) {
      read_it();
    } else if (!ends.faults->attempt(read_it)) {
      break;
    }
    const std::optional<MotionTold> told_motion =
        wheels && read > 0 && to_seconds(picture.stamp - pictures[read - 1].stamp) > gap_s
            ? told_between(*wheels, believed, pictures[read - 1].stamp, picture.stamp)
            : std::nullopt;
    const double before_s = process_use().cpu_s;
    const MonoSlamStep step = slam.step(grey, picture.stamp, told_motion);
    builder.add(picture.stamp, step);
    told.cpu_s += process_use().cpu_s - before_s;
    if (read == pictures.size() / 2) {
      told.looked_at = {grey, step, options.columns, options.rows, options.search_sigmas};
    }
    if ((read + 1) * kQuarters / pictures.size() > told.growth.size()) {
      told.growth.push_back(builder.map(slam));
    }
    progress(static_cast<double>(read + 1) / static_cast<double>(pictures.size()));
  }
  if (read < pictures.size()) {
    told.cut_short_s = read > 0 ? to_seconds(pictures[read - 1].stamp - first) : 0;
  }
  told.map = builder.map(slam);
  const double before_s = process_use().cpu_s;
  told.adjusted = adjust_map(bundle, lens, believed.sigma, told.map);
  told.adjust_s = process_use().cpu_s - before_s;
  if (!told.adjusted.T_map_camera.empty()) {
    told.keyframe_shown = told.adjusted.keyframes.size() / 2;
    const auto frame = static_cast<std::size_t>(told.adjusted.keyframes[told.keyframe_shown]);
    const std::size_t begins = read - told.map.frames.size();
    told.keyframe_grey = read_grey_picture(dataset, pictures[begins + frame]);
  }
  if (!told.map.frames.empty()) {
    if (const std::optional<TrueCameraPath> truth = TrueCameraPath::read(dataset, camera)) {
      add_errors(*truth, told);
    }
  }
  return told;
}

}  // namespace panoptes
