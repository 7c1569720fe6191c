// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/camera/rig.h"
#include "core/eval/truth.h"
#include "core/geometry/body.h"
#include "core/io/dataset.h"
#include "hw/robot.h"

namespace panoptes::hw {

/// What a platform that knows says of what its pictures truly show.
struct TruePictures {
  std::function<std::map<std::string, TruePicture>()> of_last_set;  ///< empty where nobody knows
  std::vector<std::string> things;  ///< what TruePicture::instance counts, from 1
};

/// Any robot, and all that it perceives and is told kept in a dataset (core/io/dataset_writer.h,
/// hw/replay/truth_files.h). A thread of its own packs the pictures and writes; when it falls
/// behind by a few frame sets, observe() waits for it. True pictures go to mav0/<camera>_depth (16
/// bit, millimetres, 0 where nothing is, 65535 where it is farther than 16 bits tell; along the
/// camera's axis, of an equidistant lens along each pixel's ray), <camera>_labels (16 bit, the
/// thing's number in mav0/things.csv) and <camera>_floor (255 on the floor); the sensor.yaml of
/// each folder says so.
class RecordingRobot final : public Robot {
 public:
  /// `folder` is claimed; `rig` is what the robot believes, its floor marks surveyed. A truth that
  /// knows of no contacts is not to be kept: it has come from a dataset, which has it still.
  RecordingRobot(std::unique_ptr<Robot> robot, std::filesystem::path folder,
                 const RecordingInfo& info, const Rig& rig, const Body& body,
                 TruePictures true_pictures = {}, bool keep_truth = true);
  ~RecordingRobot() override;

  /// Besides what the robot throws: IoError, with the place and until when the recording is whole,
  /// when something of it could not be written.
  Observation observe(Time deadline) override;
  void drive(const Twist2& command_body, Duration valid_for) override;
  void stop() override;
  void brake_hard() override { robot_->brake_hard(); }
  void emergency_stop() override { robot_->emergency_stop(); }
  void acknowledge() override { robot_->acknowledge(); }
  DeviceFigures devices() const override { return robot_->devices(); }
  std::optional<std::int64_t> start_unix_ns() const override { return robot_->start_unix_ns(); }
  Time now() const override;
  Timing timing() const override { return robot_->timing(); }
  std::optional<Truth> truth() const override;

  /// Waits until all is written. Throws as observe() does.
  void finish();

 private:
  class Writer;

  std::unique_ptr<Robot> robot_;
  TruePictures true_pictures_;
  std::unique_ptr<Writer> writer_;
};

}  // namespace panoptes::hw
