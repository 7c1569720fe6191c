// SPDX-License-Identifier: BSD-3-Clause
#include "apps/teleop/keyboard.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <exception>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "core/base/check.h"

namespace panoptes {
namespace {

/// What may end the program before it gives the terminal back.
constexpr std::array kDeadly = {SIGINT, SIGTERM, SIGQUIT, SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL};

struct Before {  // what a signal's handler puts back
  termios terminal{};
  std::array<struct sigaction, kDeadly.size()> actions{};
  struct sigaction hangup {};
};
Before g_before;
std::atomic<bool> g_hung_up = false;
static_assert(std::atomic<bool>::is_always_lock_free);

// Keys that nobody has read are no commands to the shell.
void give_back() {
  ::tcflush(STDIN_FILENO, TCIFLUSH);
  ::tcsetattr(STDIN_FILENO, TCSANOW, &g_before.terminal);
}

extern "C" void on_deadly(int signal) {
  const int error = errno;
  give_back();
  for (std::size_t i = 0; i < kDeadly.size(); ++i) {
    if (kDeadly[i] == signal) {
      ::sigaction(signal, &g_before.actions[i], nullptr);
    }
  }
  ::raise(signal);  // to whom it would have gone, once this has returned
  errno = error;
}

extern "C" void on_hangup(int /*signal*/) { g_hung_up = true; }

}  // namespace

/// Reads on a thread of its own, so that a key counts from when it came and not from when a busy
/// program looked.
class Keyboard::Listener {
 public:
  std::vector<KeyPress> take() {
    const std::lock_guard lock(mutex_);
    if (thrown_) {
      std::rethrow_exception(std::exchange(thrown_, nullptr));
    }
    return std::exchange(pressed_, {});
  }
  bool closed() const { return closed_ || g_hung_up; }

 private:
  void listen(const std::stop_token& stop) {
    constexpr int kLook_ms = 50;
    KeyReader reader;
    while (!stop.stop_requested()) {
      pollfd asked{STDIN_FILENO, POLLIN, 0};
      if (::poll(&asked, 1, kLook_ms) <= 0) {
        continue;
      }
      std::array<char, 256> bytes{};
      const ssize_t count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
      if (count < 0 && (errno == EINTR || errno == EAGAIN)) {
        continue;
      }
      if (count <= 0) {
        closed_ = true;
        return;
      }
      const WallTime now = std::chrono::steady_clock::now();
      const std::lock_guard lock(mutex_);
      try {
        for (const TeleopKey key : reader.read({bytes.data(), static_cast<std::size_t>(count)})) {
          pressed_.push_back({key, now});
        }
      } catch (...) {  // no memory, or a bug
        thrown_ = std::current_exception();
        return;
      }
    }
  }

  std::mutex mutex_;
  std::vector<KeyPress> pressed_;
  std::exception_ptr thrown_;
  std::atomic<bool> closed_ = false;
  std::jthread thread_{[this](const std::stop_token& stop) { listen(stop); }};  // last: uses all
};

std::string Keyboard::fault() {
  if (::isatty(STDIN_FILENO) == 0) {
    return "stdin is no terminal";
  }
  return ::tcgetpgrp(STDIN_FILENO) == ::getpgrp() ? "" : "it runs in the background";
}

Keyboard::Keyboard() {
  PANOPTES_CHECK(::tcgetattr(STDIN_FILENO, &g_before.terminal) == 0, "stdin is a terminal");
  g_hung_up = false;
  struct sigaction action = {};
  action.sa_handler = on_deadly;
  for (std::size_t i = 0; i < kDeadly.size(); ++i) {
    ::sigaction(kDeadly[i], &action, &g_before.actions[i]);
  }
  action.sa_handler = on_hangup;
  ::sigaction(SIGHUP, &action, &g_before.hangup);
  termios raw = g_before.terminal;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO | IEXTEN);
  raw.c_iflag &= ~static_cast<tcflag_t>(IXON);  // Ctrl-S would stop the program at its next line
  raw.c_cc[VMIN] = 1;
  raw.c_cc[VTIME] = 0;
  raw.c_cc[VSUSP] = _POSIX_VDISABLE;
  raw.c_cc[VQUIT] = _POSIX_VDISABLE;
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &raw);
  listener_ = std::make_unique<Listener>();
}

Keyboard::~Keyboard() {
  listener_.reset();
  give_back();
  for (std::size_t i = 0; i < kDeadly.size(); ++i) {
    struct sigaction now = {};
    ::sigaction(kDeadly[i], nullptr, &now);
    if (now.sa_handler == on_deadly) {  // else it was raised, and is with whom it belongs to
      ::sigaction(kDeadly[i], &g_before.actions[i], nullptr);
    }
  }
  ::sigaction(SIGHUP, &g_before.hangup, nullptr);
}

std::vector<KeyPress> Keyboard::take() { return listener_->take(); }

bool Keyboard::closed() const { return listener_->closed(); }

}  // namespace panoptes
