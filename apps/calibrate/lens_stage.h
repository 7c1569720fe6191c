// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

namespace panoptes {

struct LensStage {
  std::string pictures;
  std::string board;
  std::string lens = "auto";
  std::string rig;
  std::string out;
  std::optional<int> threads;
  bool quiet = false;
};

/// Lenses from pictures of a chessboard. The exit status.
int calibrate_lenses(const LensStage& args);

}  // namespace panoptes
