// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/eval/truth.h"
#include "core/geometry/pose2.h"

namespace panoptes::hw {

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
  virtual Time now() const = 0;

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
