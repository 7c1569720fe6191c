// SPDX-License-Identifier: BSD-3-Clause
#include "apps/mission/stop_condition.h"

#include <array>
#include <csignal>
#include <cstddef>

#include <fmt/format.h>

#include "hw/pioneer/emergency_stop.h"

namespace panoptes {
namespace {

constexpr std::array<int, 3> kSignals = {SIGINT, SIGTERM, SIGHUP};
constexpr double kOdometryPatience_s = 10;
constexpr int kNow = 3;  // signals after which nothing more is awaited

volatile std::sig_atomic_t g_signals = 0;

extern "C" void on_signal(int signal) {
  if (signal == SIGHUP && g_signals > 0) {
    return;  // a terminal that goes says so more than once
  }
  g_signals = g_signals + 1;
  if (g_signals >= kNow) {
    hw::stop_registered_robots();
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

StopCondition::StopCondition(const StopOptions& options) : options_(options) {
  g_signals = 0;
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;  // a file that is being written is written whole
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    if (kSignals[i] != SIGHUP || before_[i].sa_handler != SIG_IGN) {  // as nohup wants it
      sigaction(kSignals[i], &action, nullptr);
    }
  }
}

StopCondition::~StopCondition() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], &before_[i], nullptr);
  }
}

bool StopCondition::interrupted() const { return g_signals > 0; }
bool StopCondition::hurried() const { return g_signals > 1; }

void StopCondition::watch_odometry(Time now, const std::string& fault) {
  if (fault.empty()) {
    odometry_silent_since_.reset();
    return;
  }
  odometry_silent_since_ = odometry_silent_since_.value_or(now);
  const double silent_s = to_seconds(now - *odometry_silent_since_);
  if (silent_s >= kOdometryPatience_s) {
    lose_device(
        DeviceError(fmt::format("odometry: {}; nothing else for {:.0f} s", fault, silent_s)));
  }
}

void StopCondition::hold(const Health& health) {
  held_by_ = health.held_by;
  bumped_ = health.bumper_pressed;
}

bool StopCondition::reached(Time now, std::size_t keyframes) const {
  return interrupted() || !device_fault_.empty() || !held_by_.empty() || !touched_.empty() ||
         !rig_fault_.empty() || !end_reason(now, keyframes).empty();
}

std::string StopCondition::end_reason(Time now, std::size_t keyframes) const {
  if (now >= time_at(options_.duration_s)) {
    return "duration";
  }
  return options_.keyframes && keyframes >= static_cast<std::size_t>(*options_.keyframes)
             ? "keyframes"
             : "";
}

}  // namespace panoptes
