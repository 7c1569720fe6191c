// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/keyframes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <system_error>

#include <opencv2/imgcodecs.hpp>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/io/csv.h"
#include "core/io/file.h"
#include "core/nav/navigator.h"

namespace panoptes {
namespace {

void put_16(std::string& bytes, std::uint16_t value) {
  bytes += static_cast<char>(value & 0xFFU);
  bytes += static_cast<char>(value >> 8U);
}

void put_32(std::string& bytes, std::uint32_t value) {
  put_16(bytes, static_cast<std::uint16_t>(value & 0xFFFFU));
  put_16(bytes, static_cast<std::uint16_t>(value >> 16U));
}

std::uint16_t eighths(float px) {
  return static_cast<std::uint16_t>(std::clamp(std::lround(8 * px), 0L, 0xFFFFL));
}

std::string bytes_of(const PlaceSignature& signature) {
  std::string bytes;
  for (const float share : signature.cumulative) {
    put_32(bytes, std::bit_cast<std::uint32_t>(share));
  }
  return bytes;
}

// Enough to find a place again; with all of them a run of 600 s would take 50 MB instead of 40.
constexpr std::size_t kPoints = 240;

std::size_t points_kept(const LocalFeatures& features) {
  return std::min(features.px.size(), kPoints);
}

// Of more points every so manyth: they come sorted by size.
std::string bytes_of(const LocalFeatures& features) {
  std::string bytes;
  const std::size_t kept = points_kept(features);
  for (std::size_t n = 0; n < kept; ++n) {
    const std::size_t i = n * features.px.size() / kept;
    put_16(bytes, eighths(features.px[i].x()));
    put_16(bytes, eighths(features.px[i].y()));
    const cv::Mat descriptor = features.descriptors.row(static_cast<int>(i));
    bytes.append(descriptor.ptr<char>(), static_cast<std::size_t>(descriptor.cols));
  }
  return bytes;
}

/// A grid as a picture, and where it lies.
struct Drawn {
  int first_column = 0;
  std::string png;
};

Drawn drawn(const GridCrop& grid) {
  Drawn out;
  int end_column = 0;
  bool any = false;
  for (const GridCrop::Row& row : grid.rows) {
    if (row.begin < row.end) {
      out.first_column = any ? std::min(out.first_column, row.begin) : row.begin;
      end_column = any ? std::max(end_column, row.end) : row.end;
      any = true;
    }
  }
  const int rows = std::max<int>(1, static_cast<int>(grid.rows.size()));
  cv::Mat picture(rows, std::max(1, end_column - out.first_column), CV_8UC1, cv::Scalar(128));
  for (std::size_t r = 0; r < grid.rows.size(); ++r) {
    const GridCrop::Row& row = grid.rows[r];
    auto* pixels = picture.ptr<std::uint8_t>(rows - 1 - static_cast<int>(r));
    for (int column = row.begin; column < row.end; ++column) {
      const std::int8_t evidence =
          grid.cells[row.offset + static_cast<std::size_t>(column - row.begin)];
      // adds 128 to what two's complement holds
      pixels[column - out.first_column] = static_cast<std::uint8_t>(evidence) ^ 0x80U;
    }
  }
  std::vector<std::uint8_t> png;
  const std::vector<int> fast{cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_RLE};
  PANOPTES_CHECK(cv::imencode(".png", picture, png, fast), "a grey picture becomes a PNG");
  out.png.assign(png.begin(), png.end());
  return out;
}

}  // namespace

std::vector<KeptKeyframe> kept_keyframes(const Navigator& navigator) {
  std::vector<KeptKeyframe> kept;
  for (const PlacedGrid& placed : navigator.grids()) {
    const std::size_t k = kept.size();
    kept.push_back({navigator.keyframes()[k].stamp, placed.T_map_keyframe,
                    navigator.place(static_cast<int>(k)), placed.grid});
  }
  return kept;
}

void write_keyframes(const std::filesystem::path& run_dir,
                     const std::vector<KeptKeyframe>& keyframes) {
  const std::filesystem::path folder = run_dir / "keyframes";
  std::error_code fault;
  std::filesystem::create_directories(folder, fault);
  if (fault) {
    throw IoError(folder.string() + ": cannot be made: " + fault.message());
  }
  AtomicFile signatures(folder / "signatures.bin");
  AtomicFile features(folder / "features.bin");
  AtomicFile maps(folder / "maps.bin");
  CsvWriter table(folder / "keyframes.csv",
                  {"keyframe", "stamp_s", "x_m", "y_m", "theta_deg", "front_features",
                   "back_features", "cell_m", "first_column", "first_row", "map_bytes"});
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const KeptKeyframe& keyframe = keyframes[k];
    signatures.append(bytes_of(keyframe.place.signature));
    table << static_cast<int>(k) << keyframe.stamp << keyframe.T_map_keyframe.x_m
          << keyframe.T_map_keyframe.y_m << rad_to_deg(keyframe.T_map_keyframe.theta_rad);
    for (const LocalFeatures& picture : keyframe.place.features) {
      features.append(bytes_of(picture));
      table << static_cast<int>(points_kept(picture));
    }
    const Drawn map = drawn(*keyframe.grid);
    maps.append(map.png);
    table << keyframe.grid->cell_m << map.first_column << keyframe.grid->first_row
          << static_cast<int>(map.png.size());
    table.end_row();
  }
  signatures.commit();
  features.commit();
  maps.commit();
  table.finish();
}

}  // namespace panoptes
