// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace panoptes {

/// What the program answered.
struct Said {
  int status = -1;  ///< the exit status; -1 when a signal ended it
  std::string out;
  std::string err;
};

}  // namespace panoptes
