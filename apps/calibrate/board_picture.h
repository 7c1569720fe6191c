// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "apps/calibrate/lens_by_boards.h"

namespace panoptes {

/// Where in the picture corners were seen, and by how much each misses the lens that was found,
/// fifty times enlarged; parts of the picture without corners are shaded. 8-bit BGR.
cv::Mat draw_boards(const LensByBoards& told, const Board& board);

}  // namespace panoptes
