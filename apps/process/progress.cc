// SPDX-License-Identifier: BSD-3-Clause
#include "apps/process/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "apps/process/stage_clock.h"

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

// What a run that has taken so long still takes: as much as those did, from there on, that took
// longer.
std::optional<double> rest_s(const std::vector<double>& took_s, double so_far_s) {
  double sum_s = 0;
  int longer = 0;
  for (const double one_s : took_s) {
    if (one_s > so_far_s) {
      sum_s += one_s - so_far_s;
      ++longer;
    }
  }
  return longer > 0 ? std::optional(sum_s / longer) : std::nullopt;
}

}  // namespace

std::string minutes_text(double seconds) {
  const long whole = std::lround(seconds);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

std::optional<double> time_left_s(const std::vector<double>& took_s,
                                  const std::vector<double>& running_s, std::size_t waiting,
                                  int jobs) {
  const std::optional<double> each_s = rest_s(took_s, 0);
  bool known = waiting > 0;
  std::vector<double> free_in_s(static_cast<std::size_t>(jobs), 0.0);  // each place of a run
  for (std::size_t i = 0; i < running_s.size(); ++i) {
    const std::optional<double> left_s = rest_s(took_s, running_s[i]);
    known = known || left_s.has_value();
    free_in_s[i % free_in_s.size()] += left_s.value_or(0);
  }
  if (!each_s || !known) {
    return std::nullopt;
  }
  for (std::size_t i = 0; i < waiting; ++i) {
    *std::min_element(free_in_s.begin(), free_in_s.end()) += *each_s;
  }
  return *std::max_element(free_in_s.begin(), free_in_s.end());
}

std::string progress_line(double now_s, double length_s, double wall_s) {
  const double share = length_s > 0 ? now_s / length_s : 1;  // a recording may be of one instant
  std::string line =
      fmt::format("{} of {} ({:.0f} %)", minutes_text(now_s), minutes_text(length_s), 100 * share);
  if (share >= kSettled && now_s > 0 && wall_s > 0) {
    line += fmt::format(", {} left", minutes_text((length_s - now_s) * wall_s / now_s));
  }
  return line;
}

std::string share_line(const std::string& what, double done, double wall_s) {
  std::string line = fmt::format("{}: {:.0f} %", what, 100 * done);
  if (done >= kSettled) {
    line += fmt::format(", {} left", minutes_text((1 - done) * wall_s / done));
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
