// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "apps/pilots/pilot.h"

namespace panoptes {

/// Those who plan nothing.
class OtherPilot : public Pilot {
 public:
  OtherPilot(const Slam* slam, std::string who, std::function<bool()> done)
      : slam_(slam), who_(std::move(who)), done_(std::move(done)) {}

  PilotStep step(const Observation& /*seen*/, const SlamStep& at) override {
    PilotStep step;
    step.reason = who_;
    for (const std::string& told : {at.passed_over, at.cameras_told}) {
      step.reason += told.empty() ? "" : "; " + told;
    }
    step.mapped_free_m2 = slam_ != nullptr ? slam_->mapped_free_m2() : 0;
    return step;
  }
  bool done() const override { return done_ && done_(); }

 protected:
  const Slam* slam() const { return slam_; }
  static void command(const Twist2& command_body, PilotStep& step) {
    const bool stands = command_body.v_mps == 0 && command_body.w_radps == 0;
    step.command_body = command_body;
    step.state = stands ? PilotState::kStopped : PilotState::kDriving;
  }

 private:
  const Slam* slam_;
  std::string who_;
  std::function<bool()> done_;
};

}  // namespace panoptes
