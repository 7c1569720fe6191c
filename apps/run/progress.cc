// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/progress.h"

#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

#include "apps/run/stage_clock.h"

namespace panoptes {
namespace {

constexpr double kRedraw_s = 0.25;
constexpr double kPlainLine_s = 30;

std::string minutes(double seconds) {
  const long whole = std::lround(seconds);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

std::string progress_line(double now_s, double length_s, double wall_s) {
  std::string line =
      fmt::format("{} of {} ({:.0f} %)", minutes(now_s), minutes(length_s), 100 * now_s / length_s);
  if (now_s > 0 && wall_s > 0) {
    line += fmt::format(", {} left", minutes((length_s - now_s) * wall_s / now_s));
  }
  return line;
}

Progress::Progress(Duration length, bool quiet)
    : length_s_(to_seconds(length)),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      started_s_(steady_s()),
      shown_s_(started_s_) {}

Progress::~Progress() {
  if (drawn_) {
    std::fputc('\n', stderr);
  }
}

bool Progress::due(double wall_s) const {
  return !quiet_ && wall_s - shown_s_ >= (terminal_ ? kRedraw_s : kPlainLine_s);
}

void Progress::show(Time now, const std::string& doing) {
  const double wall_s = steady_s();
  if (!due(wall_s)) {
    return;
  }
  shown_s_ = wall_s;
  const std::string line =
      progress_line(to_seconds(now), length_s_, wall_s - started_s_) + "; " + doing;
  if (terminal_) {
    std::fprintf(stderr, "\r\x1b[K%s", line.c_str());
    std::fflush(stderr);
    drawn_ = true;
  } else {
    std::fprintf(stderr, "%s\n", line.c_str());
  }
}

}  // namespace panoptes
