// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "hw/base.h"
#include "hw/camera_source.h"
#include "hw/physical/odometry_track.h"
#include "hw/robot.h"

namespace panoptes::hw {

/// A base and cameras as one robot: every set of pictures with the odometry of its instant, the
/// base's reports being interpolated (extrapolated by one at most, which is marked; where the link
/// holds reports up the next one is waited for). A set that arrives wakes who observes. Without
/// cameras there is an observation a report.
class PhysicalRobot final : public Robot {
 public:
  /// `cameras` are started by the base's clock; null where there are none. `ramp` is how the base
  /// goes to a commanded velocity. `behind` is the simulated robot that a base in the same process
  /// stands for: it alone knows the truth; null where nobody does.
  PhysicalRobot(std::unique_ptr<Base> base, std::unique_ptr<CameraSource> cameras,
                const BaseRamp& ramp = {}, const Robot* behind = nullptr);
  ~PhysicalRobot() override;

  /// Throws DeviceError when the base is lost, or when it is not known any more how it came to
  /// where it is.
  Observation observe(Time deadline) override;
  void drive(const Twist2& command_body, Duration valid_for) override;
  void stop() override;
  void emergency_stop() override;
  void acknowledge() override;
  Time now() const override;
  Timing timing() const override;
  std::optional<Truth> truth() const override;
  std::optional<Truth> truth_since(std::size_t poses, std::size_t contacts) const override;
  DeviceFigures devices() const override;
  std::optional<std::int64_t> start_unix_ns() const override { return base_->start_unix_ns(); }

 private:
  void take_reports();

  std::unique_ptr<Base> base_;
  std::atomic<bool> arrived_ = false;      // a set, since one was asked for
  std::unique_ptr<CameraSource> cameras_;  // ends before what its threads call
  const Robot* behind_;
  OdometryTrack track_;
  std::optional<CameraSet> waiting_;  // for the odometry of its instant
  std::optional<Pose2> T_first_odom_;
  Time last_stamp_ = Time::min();
  bool held_up_ = false;  // reports, and so commands: these tell little of the motion
  int epoch_ = 0;
  std::size_t sets_ = 0;
  std::size_t extrapolated_ = 0;
};

}  // namespace panoptes::hw
