// SPDX-License-Identifier: BSD-3-Clause
#include "apps/process/process.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string_view>
#include <thread>

#include <opencv2/core/utility.hpp>

#include "apps/process/fault.h"
#include "hw/pioneer/emergency_stop.h"
#include "sim/render/renderer.h"

namespace panoptes {
namespace {

// What was thrown where nothing may be, as in a destructor of a library, ends the program with the
// status that it has elsewhere.
[[noreturn]] void end_at_once() {
  hw::stop_registered_robots();
  Fault fault{4, "a bug of panoptes, please report it: it was ended"};
  if (const std::exception_ptr thrown = std::current_exception()) {
    try {
      std::rethrow_exception(thrown);
    } catch (...) {
      fault = current_fault();
    }
  }
  std::fprintf(stderr, "%s\n", fault.what.c_str());
  std::_Exit(fault.status);
}

/// What ends a program without a word.
constexpr std::array kDeadly = {SIGQUIT, SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL};
std::array<struct sigaction, kDeadly.size()> g_before{};

extern "C" void say_and_end(int signal, siginfo_t* info, void* /*context*/) {
  hw::stop_registered_robots();
  for (std::size_t i = 0; i < kDeadly.size(); ++i) {
    if (kDeadly[i] == signal) {
      ::sigaction(signal, &g_before[i], nullptr);
    }
  }
  // Once this has returned it ends the program as it would have: by what it did again, or
  if (info->si_code <= 0) {  // somebody has sent it
    ::raise(signal);
  }
}

}  // namespace

void set_up_process() {
  std::set_terminate(end_at_once);
  struct sigaction action = {};
  action.sa_sigaction = say_and_end;
  action.sa_flags = SA_SIGINFO;
  for (std::size_t i = 0; i < kDeadly.size(); ++i) {
    ::sigaction(kDeadly[i], &action, &g_before[i]);
  }
  std::signal(SIGXFSZ, SIG_IGN);  // the write fails instead
  std::signal(SIGPIPE, SIG_IGN);  // likewise: a reader that left ends no run
  cv::setNumThreads(1);
  // More than two threads gain nothing on pictures as small as ours.
  constexpr unsigned kUseful = 2;
  sim::set_render_threads(
      static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, kUseful)));
  if (const char* wanted = std::getenv("PANOPTES_REPRODUCIBLE");
      wanted != nullptr && std::string_view(wanted) == "1") {
    sim::set_same_on_every_processor();
  }
}

}  // namespace panoptes
