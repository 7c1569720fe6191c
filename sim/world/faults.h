// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"

namespace panoptes::sim {

/// Everything that is wrong with a world, so that all of it is said at once.
class Faults {
 public:
  void user(const std::string& mention, const std::string& what) { add(mention, what, true); }
  void machine(const std::string& mention, const std::string& what) { add(mention, what, false); }

  template <class Make>
  void collect(const Make& make) {
    try {
      make();
    } catch (const ConfigError& error) {
      users_ = true;
      lines_.insert(lines_.end(), error.lines().begin(), error.lines().end());
    } catch (const IoError& error) {
      lines_.emplace_back(error.what());
    }
  }

  bool any() const { return !lines_.empty(); }

  void raise() const {
    if (users_) {
      throw ConfigError(lines_);
    }
    if (any()) {
      throw IoError(joined(lines_, "\n"));
    }
  }

 private:
  void add(const std::string& mention, const std::string& what, bool is_user) {
    users_ = users_ || is_user;
    lines_.push_back((mention.empty() ? "" : mention + ": ") + what);
  }

  std::vector<std::string> lines_;
  bool users_ = false;
};

}  // namespace panoptes::sim
