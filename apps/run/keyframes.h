// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/graph/loop_closer.h"
#include "core/map/keyframe_grid.h"

namespace panoptes {

class Navigator;

/// What is kept of a keyframe, so that a later run can find itself in this one's map.
struct KeptKeyframe {
  Time stamp;
  Pose2 T_map_keyframe;  ///< after the last relaxation
  LoopPlace place;
  std::shared_ptr<const GridCrop> grid;
};

std::vector<KeptKeyframe> kept_keyframes(const Navigator& navigator);

/// Writes `run_dir`/keyframes, numbers in little endian:
///  - signatures.bin: a keyframe after the other, its 256 cumulative shares (see
///    PlaceSignature) as 32-bit floats;
///  - features.bin: a keyframe after the other, first the front picture's points and then the
///    back's, at most 240 of each; 36 bytes each: x and y in eighths of a pixel as 16-bit integers,
///    256 bits of descriptor;
///  - maps.bin: a grey PNG a keyframe, top row first: 128 + evidence in eighths of a nat, free is
///    bright;
///  - keyframes.csv: a row a keyframe: its pose in `map`, how many points each picture has, the
///    cell's side, the lattice cell (column, row) in the frame of the keyframe of the PNG's lower
///    left pixel, and the PNG's bytes.
void write_keyframes(const std::filesystem::path& run_dir,
                     const std::vector<KeptKeyframe>& keyframes);

}  // namespace panoptes
