// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/time.h"

namespace panoptes {

/// What a platform states of its own time.
struct Timing {
  Duration period{};  ///< between two observations that somebody can decide on
  /// From the instant of an observation until the wheels begin to do what was decided on it, at
  /// the latest: delivery, a decision that takes no longer than a period, and the command's way.
  Duration worst_latency{};
};

}  // namespace panoptes
