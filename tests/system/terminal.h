// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include <termios.h>

namespace panoptes {

/// A terminal with somebody before it, who starts once the program has said what its keys do.
class Terminal {
 public:
  explicit Terminal(std::function<void(Terminal&)> somebody);
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  int slave() const { return slave_; }

  void type(const std::string& keys) const;
  /// As terminals do it: again and again.
  void hold(const std::string& key, std::chrono::milliseconds time) const;
  /// The window is closed.
  void hang_up();

  std::string shown();
  bool as_before() const;
  bool echoes() const;

 private:
  termios modes() const;
  void read(const std::stop_token& stop);

  std::atomic<int> master_;
  int slave_ = -1;
  termios before_{};
  std::mutex mutex_;
  std::string shown_;
  std::jthread reader_;
  std::jthread somebody_;
};

}  // namespace panoptes
