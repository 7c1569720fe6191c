// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/base/time.h"
#include "core/base/timing.h"
#include "core/camera/observation.h"
#include "core/eval/truth.h"
#include "core/geometry/pose2.h"

namespace panoptes::hw {

/// How the devices of a platform are doing, by the device's name and the figure's.
using DeviceFigures = std::map<std::string, std::map<std::string, double>>;

/// What every robot fulfils, simulated, recorded or real. One thread calls it. Time is the
/// platform's own and starts at 0; in simulation it moves only inside observe().
class Robot {
 public:
  virtual ~Robot() = default;

  /// Waits for the next frame set or the deadline, whichever is first; at the deadline the
  /// observation has odometry and health but no pictures. Never returns a set twice.
  /// Throws DeviceError when the device is lost.
  virtual Observation observe(Time deadline) = 0;

  /// Asks for a velocity of the body. It expires by itself (the robot stops) when not renewed
  /// within `valid_for`. The platform limits speed and acceleration.
  virtual void drive(const Twist2& command_body, Duration valid_for) = 0;

  virtual void stop() = 0;

  /// Right after a command to stand: as fast as the platform can, regardless of the acceleration
  /// that it is driven with. The next command takes that back. Some platforms cannot.
  virtual void brake_hard() {}

  /// As hard as it can. A real robot does not move after it before acknowledge().
  virtual void emergency_stop() { stop(); }

  /// Somebody has seen why the robot is held (Health::held_by): it may move again.
  virtual void acknowledge() {}
  virtual Time now() const = 0;

  /// What it states of its own time, before it is observed.
  virtual Timing timing() const = 0;

  virtual DeviceFigures devices() const { return {}; }

  /// The wall-clock instant of time 0, since 1970, of a platform that lives in that time.
  virtual std::optional<std::int64_t> start_unix_ns() const { return std::nullopt; }

  /// The truth up to now, where the platform knows it: simulated robots and recordings that hold
  /// it. For evaluation and the recorder alone.
  virtual std::optional<Truth> truth() const = 0;

  /// What is new in it after so many poses and contacts, and without the layers that stay as they
  /// are (`floor`, `body`): for a recorder that asks at every frame set.
  virtual std::optional<Truth> truth_since(std::size_t poses, std::size_t contacts) const {
    std::optional<Truth> news = truth();
    if (news) {
      news->poses.erase(news->poses.begin(), news->poses.begin() + static_cast<long>(poses));
      news->contacts.erase(news->contacts.begin(),
                           news->contacts.begin() + static_cast<long>(contacts));
      news->floor = {};
      news->body = {};
    }
    return news;
  }

 protected:
  Robot() = default;
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;
};

}  // namespace panoptes::hw
