// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/base/time.h"
#include "core/geometry/body.h"
#include "hw/pioneer/session.h"

namespace panoptes::hw {

/// A Pioneer at the other end of a line, in wall-clock time since it was made. A thread of its own
/// carries the bytes and keeps every deadline: when whoever commands hangs, the robot is told to
/// stop all the same.
class PioneerBase final : public PioneerSession {
 public:
  /// Throws what Line throws.
  PioneerBase(const std::string& address, const Body& body);
  ~PioneerBase() override;  ///< stops the robot, switches its motors off and closes the session

  Time now() const override;
  std::optional<std::int64_t> start_unix_ns() const override;
  void wake() override;
  void work(Time deadline, const std::function<bool(const PioneerClient&)>& done) override;
  void with(const std::function<void(PioneerClient&)>& act) override;

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace panoptes::hw
