// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/camera/rig.h"
#include "core/eval/truth.h"
#include "hw/robot.h"

namespace panoptes::hw {

/// A rig of two small cameras, `front` and `floor`, the latter with surveyed marks.
Rig small_rig();

/// A robot that perceives what was made up beforehand, and knows a truth that grows with it.
class ScriptedRobot final : public Robot {
 public:
  explicit ScriptedRobot(int observations);

  Observation observe(Time deadline) override;
  void drive(const Twist2& /*command_body*/, Duration /*valid_for*/) override {}
  void stop() override {}
  Time now() const override { return now_; }
  Timing timing() const override {
    return {std::chrono::milliseconds(100), std::chrono::milliseconds(8)};
  }
  std::optional<Truth> truth() const override { return truth_; }

 private:
  int left_;
  int count_ = 0;
  Time now_{};
  Truth truth_;
};

/// What it is told after the i-th observation.
Twist2 made_up_command(int i);

/// Observes and drives `count` times; what was perceived comes back.
std::vector<Observation> drive_on(Robot& robot, int count, int from = 0);

void expect_same(const Observation& a, const Observation& b);
void expect_same(const Truth& a, const Truth& b);

}  // namespace panoptes::hw
