// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/calibrate/camera_pictures.h"
#include "core/calib/board.h"
#include "core/calib/lens_fit.h"

namespace panoptes {

/// What a camera's pictures of a board tell of its lens.
struct LensByBoards {
  std::string camera;
  std::size_t pictures = 0;             ///< of the camera
  std::vector<std::string> looked_at;   ///< files
  std::vector<std::size_t> with_board;  ///< of them, in order: fit.views is of these
  std::vector<BoardCorners> corners;    ///< of each of these
  int width_px = 0;
  int height_px = 0;
  LensFit fit;
};

struct LensByBoardsOptions {
  Board board;
  std::optional<LensModel> model;  ///< empty: the one that explains the corners better
  int most_pictures = 300;         ///< of more, so many are looked at, evenly
  int num_threads = 2;
  LensFitOptions fit;
};

/// Looks for the board in every picture and fits a lens. `progress` is told the share that is done.
/// Throws ConfigError for what is no picture and for pictures that differ in size, IoError for
/// files that the machine cannot read.
LensByBoards lens_by_boards(const LensByBoardsOptions& options, const CameraPictures& pictures,
                            const std::function<void(double)>& progress);

}  // namespace panoptes
