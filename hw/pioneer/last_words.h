// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace panoptes::hw {

/// A line with a robot at its end that may be driven. While it lives, say_last_words() reaches it.
class LastWords {
 public:
  LastWords(int fd, bool serial);
  ~LastWords();
  LastWords(const LastWords&) = delete;
  LastWords& operator=(const LastWords&) = delete;

 private:
  int slot_ = -1;  // none is free: that robot is left to its watchdog
};

/// Tells every such robot to stop and lets go of its port. For where the program ends and nothing
/// is done in order any more: it takes no memory and no lock, and a signal's handler may call it.
void say_last_words() noexcept;

}  // namespace panoptes::hw
