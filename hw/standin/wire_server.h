// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "hw/standin/controller.h"
#include "hw/standin/endpoint.h"

namespace panoptes::hw {

/// Keeps a stand-in controller in step with the wall clock and with whoever comes to its endpoints.
/// Whatever kept it from running, the robot catches up; what was to be sent meanwhile is out of
/// date and is not sent.
class WireServer {
 public:
  /// `controller` outlives it; its time goes on from now.
  WireServer(StandInController& controller, std::vector<std::unique_ptr<Endpoint>> endpoints);

  /// Waits for something to do, not for long, and does it. While the robot is caught up,
  /// `each_second` of its time is given a chance to stop that.
  void turn(const std::function<bool()>& each_second);

  std::int64_t start_unix_ns() const { return start_unix_ns_; }  ///< of the controller's time 0
  bool connected() const { return client_.has_value(); }

 private:
  struct Due {
    Time at;
    Bytes bytes;
  };

  Time wall() const;
  void wait() const;
  Bytes hear();
  void collect();
  void deliver();

  StandInController& controller_;
  std::vector<std::unique_ptr<Endpoint>> endpoints_;
  std::optional<std::size_t> client_;  ///< the endpoint that has one; others are not heard
  std::deque<Due> due_;
  std::chrono::steady_clock::time_point started_;
  std::int64_t start_unix_ns_;
};

}  // namespace panoptes::hw
