// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/base/time.h"
#include "core/geometry/body.h"
#include "hw/pioneer/client.h"

namespace panoptes::hw {

/// A client joined to a line, in somebody's time: a thread's (PioneerBase) or that of a simulated
/// robot behind the line (hw/standin).
class BaseLink {
 public:
  virtual ~BaseLink() = default;

  virtual Time now() const = 0;

  /// The wall-clock instant of time 0, since 1970; empty where time is not the world's.
  virtual std::optional<std::int64_t> start_unix_ns() const { return std::nullopt; }

  /// Lets the link work until `done` says so of the client, or until `deadline`.
  virtual void wait(Time deadline, const std::function<bool(const PioneerClient&)>& done) = 0;

  /// Asks or tells the client something; what it wants to send is sent.
  virtual void with(const std::function<void(PioneerClient&)>& act) = 0;

 protected:
  BaseLink() = default;
  BaseLink(const BaseLink&) = delete;
  BaseLink& operator=(const BaseLink&) = delete;
};

/// Connects to the robot, and listens until it is known when its reports leave: half a second, or
/// a few where the link holds them up. Throws DeviceError with the device and the cure when there
/// is none within 10 s (15 s where packets come), or one that is not known.
void connect(BaseLink& link);

/// A Pioneer at the other end of a line, in wall-clock time since it was made. A thread of its own
/// carries the bytes and keeps every deadline: when whoever commands hangs, the robot is told to
/// stop all the same.
class PioneerBase final : public BaseLink {
 public:
  /// Throws what Line throws.
  PioneerBase(const std::string& address, const Body& body);
  ~PioneerBase() override;  ///< stops the robot, switches its motors off and closes the session

  Time now() const override;
  std::optional<std::int64_t> start_unix_ns() const override;
  void wait(Time deadline, const std::function<bool(const PioneerClient&)>& done) override;
  void with(const std::function<void(PioneerClient&)>& act) override;

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace panoptes::hw
