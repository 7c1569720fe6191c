// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <string>

#include "core/base/time.h"
#include "hw/base.h"
#include "hw/pioneer/client.h"

namespace panoptes::hw {

/// A client joined to a line, in somebody's time: a thread's (PioneerBase) or that of a simulated
/// robot behind the line (hw/standin). By what its client says and does it is a Base.
class PioneerSession : public Base {
 public:
  /// Lets the session work until `done` says so of the client, or until `deadline`.
  virtual void work(Time deadline, const std::function<bool(const PioneerClient&)>& done) = 0;

  /// Asks or tells the client something; what it wants to send is sent.
  virtual void with(const std::function<void(PioneerClient&)>& act) = 0;

  BaseTiming timing() final;
  void wait(Time deadline, const std::function<bool()>& done) final;
  BaseReports take_reports() final;
  Health health() final;
  void drive(const Twist2& command_body, Duration valid_for) final;
  void stop() final;
  void emergency_stop() final;
  void acknowledge() final;
  std::map<std::string, double> figures() final;

 private:
  bool enabled_ = false;  // the motors, by the first command to move
};

/// Connects to the robot, and listens until it is known when its reports leave: half a second, or
/// a few where the link holds them up. Throws DeviceError with the device and the cure when there
/// is none within 10 s (15 s where packets come), or one that is not known.
void connect(PioneerSession& session);

}  // namespace panoptes::hw
