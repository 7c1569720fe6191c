// SPDX-License-Identifier: BSD-3-Clause
#include "tests/system/terminal.h"

#include <cstdlib>
#include <utility>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

namespace panoptes {

using namespace std::chrono_literals;

Terminal::Terminal(std::function<void(Terminal&)> somebody)
    : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
  EXPECT_EQ(::grantpt(master_), 0);
  EXPECT_EQ(::unlockpt(master_), 0);
  slave_ = ::open(::ptsname(master_), O_RDWR | O_NOCTTY | O_CLOEXEC);
  before_ = modes();
  reader_ = std::jthread([this](const std::stop_token& stop) { read(stop); });
  somebody_ = std::jthread([this, somebody = std::move(somebody)](const std::stop_token& stop) {
    while (!stop.stop_requested() && shown().find("end; Ctrl-C") == std::string::npos) {
      std::this_thread::sleep_for(5ms);
    }
    somebody(*this);
  });
}

Terminal::~Terminal() {
  somebody_ = {};
  reader_ = {};
  hang_up();
  ::close(slave_);
}

void Terminal::type(const std::string& keys) const {
  EXPECT_EQ(::write(master_, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
}

void Terminal::hold(const std::string& key, std::chrono::milliseconds time) const {
  for (auto held = 0ms; held < time; held += 50ms) {
    type(key);
    std::this_thread::sleep_for(50ms);
  }
}

void Terminal::hang_up() {
  reader_ = {};
  ::close(master_);
  master_ = -1;
}

std::string Terminal::shown() {
  const std::lock_guard lock(mutex_);
  return shown_;
}

bool Terminal::as_before() const {
  const termios now = modes();
  return now.c_lflag == before_.c_lflag && now.c_iflag == before_.c_iflag &&
         now.c_cc[VSUSP] == before_.c_cc[VSUSP] && now.c_cc[VQUIT] == before_.c_cc[VQUIT];
}

bool Terminal::echoes() const { return (modes().c_lflag & ECHO) != 0; }

termios Terminal::modes() const {
  termios modes{};
  EXPECT_EQ(::tcgetattr(slave_, &modes), 0);
  return modes;
}

void Terminal::read(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    pollfd asked{master_, POLLIN, 0};
    char bytes[256];
    if (::poll(&asked, 1, 20) == 1) {
      const ssize_t count = ::read(master_, bytes, sizeof bytes);
      const std::lock_guard lock(mutex_);
      shown_.append(bytes, count > 0 ? static_cast<std::size_t>(count) : 0);
    }
  }
}

}  // namespace panoptes
