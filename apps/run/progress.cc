// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/progress.h"

#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "apps/run/stage_clock.h"

namespace panoptes {
namespace {

constexpr double kRedraw_s = 0.25;
constexpr double kPlainLine_s = 30;
// The first moments make what the rest uses; a pace judged by them is off by many times.
constexpr double kSettled = 0.02;

// What of a line fits on the terminal: a longer one could not be drawn over.
std::string fitting(const std::string& text) {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return known ? text.substr(0, size.ws_col - 1U) : text;
}

std::string minutes(double seconds) {
  const long whole = std::lround(seconds);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

std::string progress_line(double now_s, double length_s, double wall_s) {
  std::string line =
      fmt::format("{} of {} ({:.0f} %)", minutes(now_s), minutes(length_s), 100 * now_s / length_s);
  if (now_s >= kSettled * length_s && wall_s > 0) {
    line += fmt::format(", {} left", minutes((length_s - now_s) * wall_s / now_s));
  }
  return line;
}

std::string share_line(const std::string& what, double done, double wall_s) {
  std::string line = fmt::format("{}: {:.0f} %", what, 100 * done);
  if (done >= kSettled) {
    line += fmt::format(", {} left", minutes((1 - done) * wall_s / done));
  }
  return line;
}

ProgressLine::ProgressLine(bool quiet)
    : quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      started_s_(steady_s()),
      shown_s_(started_s_) {}

ProgressLine::~ProgressLine() {
  if (drawn_) {
    std::fputc('\n', stderr);
  }
}

bool ProgressLine::due() const {
  return !quiet_ && steady_s() - shown_s_ >= (terminal_ ? kRedraw_s : kPlainLine_s);
}

void ProgressLine::show(const std::string& text) {
  shown_s_ = steady_s();
  if (terminal_) {
    std::fprintf(stderr, "\r\x1b[K%s", fitting(text).c_str());
    std::fflush(stderr);
    drawn_ = true;
  } else {
    std::fprintf(stderr, "%s\n", text.c_str());
  }
}

double ProgressLine::wall_s() const { return steady_s() - started_s_; }

Progress::Progress(Duration length, bool quiet) : length_s_(to_seconds(length)), line_(quiet) {}

void Progress::show(Time now, const std::string& doing) {
  if (line_.due()) {
    line_.show(progress_line(to_seconds(now), length_s_, line_.wall_s()) + "; " + doing);
  }
}

}  // namespace panoptes
