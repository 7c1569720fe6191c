// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/geometry/pose2.h"

namespace panoptes::hw {

/// The wheels' pose at the instant when one report left the base.
struct WheelPose {
  Time stamp;
  Pose2 T_odom_body;
  Twist2 twist_body;
  int epoch = 0;  ///< grows when it is not known how the robot came here
};

/// A velocity that was sent to the base, and when it is in force. The base goes there at the body's
/// accelerations.
struct CommandedTwist {
  Time at;
  Twist2 twist_body;
};

/// What has come from a base, and was sent to it, since it was asked last; in order of time.
struct BaseReports {
  std::vector<WheelPose> poses;
  std::vector<CommandedTwist> commanded;
  bool held_up = false;  ///< reports are held up on their way now and then, and so are commands
  std::string error;     ///< why the base is lost, or does not follow its commands; else empty
};

struct BaseTiming {
  Duration period{};            ///< from one report to the next
  Duration worst_round_trip{};  ///< from a command to the report of its effect, as measured so far
};

/// A base with wheels as a robot needs it (hw/physical), whoever makes its controller. It is
/// connected, and has reported once. One thread calls it, but for now() and wake().
class Base {
 public:
  virtual ~Base() = default;

  /// The robot's clock, which its cameras share (hw/camera_source.h).
  virtual Time now() const = 0;

  /// The wall-clock instant of time 0, since 1970; empty where time is not the world's.
  virtual std::optional<std::int64_t> start_unix_ns() const { return std::nullopt; }

  virtual BaseTiming timing() = 0;

  /// Waits until there are poses to be taken or the base is lost, until `done`, or `deadline`.
  virtual void wait(Time deadline, const std::function<bool()>& done) = 0;

  /// Makes wait() ask `done` again.
  virtual void wake() = 0;

  virtual BaseReports take_reports() = 0;

  /// By the last report.
  virtual Health health() = 0;

  /// Asks for a velocity, which expires after `valid_for` at the latest. Motors are enabled by the
  /// first that moves; before it commands to stand do nothing. Throws DeviceError when the base is
  /// lost.
  virtual void drive(const Twist2& command_body, Duration valid_for) = 0;

  virtual void stop() = 0;            ///< decelerates
  virtual void emergency_stop() = 0;  ///< regardless of deceleration, and until acknowledge()

  /// Somebody has seen why the robot is held (Health::held_by): it may move again.
  virtual void acknowledge() = 0;

  /// How base and link are doing, by the figure's name.
  virtual std::map<std::string, double> figures() = 0;

 protected:
  Base() = default;
  Base(const Base&) = delete;
  Base& operator=(const Base&) = delete;
};

}  // namespace panoptes::hw
