// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/loops/loop_closer.h"
#include "core/map/keyframe_grid.h"

namespace panoptes {

/// What is kept of a keyframe, so that a later run can find itself in this one's map.
struct KeptKeyframe {
  Time stamp;
  Pose2 T_map_keyframe;  ///< after the last relaxation
  LoopPlace place;
  std::shared_ptr<const GridCrop> grid;
};

struct KeptKeyframes {
  std::vector<std::string> looks{"front", "back"};  ///< of each loop camera, as its role says
  std::vector<KeptKeyframe> all;  ///< each with as many pictures' features as there are cameras
};

/// The bytes of a folder of keyframes, numbers in little endian.
struct KeyframeFiles {
  /// keyframes.csv: a row a keyframe: its pose in `map`, the signature's method, how many points
  /// each loop camera's picture has (front_features, back_features, ...), the cell's side, the
  /// lattice cell (column, row) in the frame of the keyframe of the PNG's lower left pixel, the
  /// PNG's bytes, and the CRC-32 of the first line, of the row before this column's comma and then
  /// of the keyframe's signature, features and map.
  std::string table;
  /// signatures.bin: a keyframe after the other, its cumulative shares (see PlaceSignature), 128 a
  /// loop camera of a grid and 256 of a mosaic, as
  /// 32-bit floats.
  std::string signatures;
  /// features.bin: a keyframe after the other, the points of its pictures in the order of the
  /// table's columns, at most 240 of each; 36 bytes each: x and y in eighths of a pixel as 16-bit
  /// integers, 256 bits of descriptor.
  std::string features;
  /// maps.bin: a grey PNG a keyframe, top row first: 128 + evidence in eighths of a nat, free is
  /// bright.
  std::string maps;
};

KeyframeFiles keyframe_files(const KeptKeyframes& keyframes);

/// The reverse, but for points beyond 240 a picture and fractions of an eighth of a pixel. Throws
/// ConfigError with the file in `folder`, line or byte, what is wrong and what to do.
KeptKeyframes parse_keyframes(const std::string& folder, const KeyframeFiles& files);

/// To and from `run_dir`/keyframes.
void write_keyframes(const std::filesystem::path& run_dir, const KeptKeyframes& keyframes);
KeptKeyframes read_keyframes(const std::filesystem::path& run_dir);

}  // namespace panoptes
