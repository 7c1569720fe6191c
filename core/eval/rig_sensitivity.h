// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/camera/rig.h"
#include "core/eval/rig_scores.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// How far cameras may be from where a drawing has them: standard deviations about and along each
/// of the body's axes, of each camera by itself.
struct RigSensitivityOptions {
  double rotation_rad = deg_to_rad(2);
  double position_m = 0.01;
  int draws = 40;
  std::uint64_t seed = 1;
};

/// Where nine of ten such rigs have a score.
struct ScoreSpread {
  double low = 0;
  double high = 0;
};

/// What a rig's scores become when its cameras are mounted so far off.
struct RigSensitivity {
  RigSensitivityOptions off;
  /// Of each of named_scores in their order; empty where the rig, or one of those that are drawn,
  /// has not the score.
  std::vector<std::optional<ScoreSpread>> spreads;
};

/// The same draws for the same names of cameras, so that rigs compare.
RigSensitivity rig_sensitivity(const RigSensitivityOptions& options, const RigScoreOptions& scores,
                               const Rig& rig, const Body& body);

}  // namespace panoptes
