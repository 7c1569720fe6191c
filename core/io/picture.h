// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace panoptes {

struct PictureSize {
  int width_px = 0;
  int height_px = 0;
};

/// The size of a PNG, JPEG, BMP or PNM (PGM, PPM) file, from its header alone; empty for anything
/// else.
std::optional<PictureSize> picture_size(std::string_view bytes);

/// The pictures in a folder, by the endings of their names and in the order of these, 10 after 9.
std::vector<std::string> pictures_in(const std::filesystem::path& folder);

/// Of pictures that somebody hands in: as much as a camera may have, and decoded 0.2 GB.
inline constexpr int kMostPictureSide_px = 8192;

enum class PictureColours { kBgr, kGrey };

/// The pixels of such a file, 8 bits a channel. Its size is looked at before anything is decoded,
/// and its frame is checked before a decoder sees it, so that nothing is written to the terminal.
/// Throws ConfigError for what is none, is cut short or damaged, or is wider or higher than
/// `most_side_px`; the message says what is wrong and what to do, and the caller of which file.
cv::Mat decode_picture(std::string_view bytes, int most_side_px, PictureColours colours);

}  // namespace panoptes
