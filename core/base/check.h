// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace panoptes {

/// One of our own assumptions does not hold: a bug of ours, never the user's fault (exit status 4).
class CheckError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] void check_failed(const char* condition, const std::string& must, const char* file,
                               int line);

}  // namespace panoptes

/// States what must hold at this point, in words; on in every build.
#define PANOPTES_CHECK(condition, must)                                 \
  do {                                                                  \
    if (!(condition)) {                                                 \
      ::panoptes::check_failed(#condition, (must), __FILE__, __LINE__); \
    }                                                                   \
  } while (false)
