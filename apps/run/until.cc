// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/until.h"

#include <csignal>

namespace panoptes {
namespace {

volatile std::sig_atomic_t g_interrupted = 0;

extern "C" void on_signal(int /*signal*/) { g_interrupted = 1; }

}  // namespace

Until::Until(const UntilOptions& options) : options_(options) {
  g_interrupted = 0;
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

Until::~Until() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool Until::interrupted() const { return g_interrupted != 0; }

void Until::hold(const Health& health) {
  held_by_ = health.held_by;
  bumped_ = health.bumper_pressed;
}

bool Until::reached(Time now, std::size_t keyframes) const {
  return interrupted() || !device_fault_.empty() || !held_by_.empty() ||
         !end_reason(now, keyframes).empty();
}

std::string Until::end_reason(Time now, std::size_t keyframes) const {
  if (now >= time_at(options_.duration_s)) {
    return "duration";
  }
  return options_.keyframes && keyframes >= static_cast<std::size_t>(*options_.keyframes)
             ? "keyframes"
             : "";
}

}  // namespace panoptes
