// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "hw/base.h"

namespace panoptes::hw {

/// A base that is no Pioneer, in wall-clock time: it reports what it is given, from any thread, and
/// keeps what it was asked for.
class FakeBase final : public Base {
 public:
  static constexpr Duration kPeriod = std::chrono::milliseconds(40);
  static constexpr Duration kRoundTrip = std::chrono::milliseconds(30);

  Time now() const override { return Time(std::chrono::steady_clock::now() - begun_); }

  BaseTiming timing() override { return {kPeriod, kRoundTrip}; }

  void wait(Time deadline, const std::function<bool()>& done) override {
    std::unique_lock lock(mutex_);
    waited_for_ = true;
    changed_.notify_all();
    changed_.wait_until(lock, begun_ + deadline.time_since_epoch(), [&] {
      return !reports_.poses.empty() || !reports_.error.empty() || done();
    });
  }

  void wake() override {
    { const std::lock_guard lock(mutex_); }
    changed_.notify_all();
  }

  /// On another thread: until somebody sleeps in wait().
  void until_waited_for() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waited_for_; });
  }

  BaseReports take_reports() override {
    const std::lock_guard lock(mutex_);
    BaseReports taken = reports_;
    reports_.poses.clear();
    reports_.commanded.clear();
    return taken;
  }

  Health health() override { return {true, false, held_by}; }
  void drive(const Twist2& command_body, Duration) override {
    asked.push_back("drive");
    const std::lock_guard lock(mutex_);
    reports_.commanded.push_back({now(), command_body});
  }
  void stop() override { asked.emplace_back("stop"); }
  void emergency_stop() override { asked.emplace_back("emergency_stop"); }
  void acknowledge() override { asked.emplace_back("acknowledge"); }
  std::map<std::string, double> figures() override { return {{"drops", 3}}; }

  /// On any thread: these have come, together.
  void report(const std::vector<WheelPose>& poses) {
    {
      const std::lock_guard lock(mutex_);
      reports_.poses.insert(reports_.poses.end(), poses.begin(), poses.end());
    }
    changed_.notify_all();
  }

  void fail(const std::string& error) {
    {
      const std::lock_guard lock(mutex_);
      reports_.error = error;
    }
    changed_.notify_all();
  }

  std::vector<std::string> asked;
  std::string held_by;

 private:
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::mutex mutex_;
  std::condition_variable changed_;
  BaseReports reports_;
  bool waited_for_ = false;
};

}  // namespace panoptes::hw
