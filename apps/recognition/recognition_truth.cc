// SPDX-License-Identifier: BSD-3-Clause
#include "apps/recognition/recognition_truth.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/io/csv.h"
#include "core/io/digits.h"
#include "core/io/file.h"
#include "core/io/picture.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

constexpr std::uint8_t kWhite = 255;

std::optional<int> picture_of(const std::string& field, const std::vector<std::string>& pictures) {
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (fs::path(pictures[i]).filename() == field) {
      return static_cast<int>(i);
    }
  }
  const std::optional<double> number = parse_number(field);
  if (number && *number >= 0 && *number < static_cast<double>(pictures.size()) &&
      *number == static_cast<int>(*number)) {
    return static_cast<int>(*number);
  }
  return std::nullopt;
}

PlaceTruth truth_of_table(const std::string& file, const std::vector<std::string>& pictures) {
  PlaceTruth truth(static_cast<int>(pictures.size()));
  CsvTable table;
  std::array<std::size_t, 2> columns{};
  try {
    table = read_csv(file);
    columns[0] = table.column("picture");
    columns[1] = table.column("earlier");
  } catch (const IoError& error) {
    const std::string what = error.what();
    throw ConfigError((what.starts_with(file) ? what : file + ": " + what) +
                      "; give a table that begins with the line picture,earlier");
  }
  std::vector<std::string> faults;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    std::array<std::optional<int>, 2> pair;
    for (int side = 0; side < 2; ++side) {
      const std::string& field = table.rows[row][columns[side]];
      pair[side] = picture_of(field, pictures);
      if (!pair[side]) {
        faults.push_back(fmt::format(
            "{}:{}: {}: {} is no picture of the run; name a file of it, or a number from 0 to {}",
            file, row + 2, side == 0 ? "picture" : "earlier", field, pictures.size() - 1));
      }
    }
    if (pair[0] && pair[1]) {
      truth.set(*pair[0], *pair[1], SamePlace::kYes);
    }
  }
  if (!faults.empty()) {
    throw ConfigError(faults);
  }
  return truth;
}

PlaceTruth truth_of_picture(const std::string& file, const std::string& bytes, int pictures) {
  cv::Mat grey;
  try {
    grey = decode_picture(bytes, kMostPictureSide_px, PictureColours::kGrey);
  } catch (const ConfigError& error) {
    throw ConfigError(file + ": " + error.what());
  }
  if (grey.cols != pictures || grey.rows != pictures) {
    throw ConfigError(fmt::format(
        "{}: is {} x {} pixels and there are {} pictures; it needs a pixel for each pair", file,
        grey.cols, grey.rows, pictures));
  }
  PlaceTruth truth(pictures);
  for (int a = 0; a < pictures; ++a) {
    for (int b = 0; b < a; ++b) {
      // half of it may be left black
      const auto pixel = std::max(grey.at<std::uint8_t>(a, b), grey.at<std::uint8_t>(b, a));
      truth.set(a, b,
                pixel == kWhite ? SamePlace::kYes
                : pixel == 0    ? SamePlace::kNo
                                : SamePlace::kNotCounted);
    }
  }
  return truth;
}

}  // namespace

PlaceTruth read_recognition_truth(const std::string& file,
                                  const std::vector<std::string>& pictures) {
  if (!fs::is_regular_file(file)) {
    throw ConfigError(file + ": no such file; give a table or a picture of which pictures match");
  }
  const std::string bytes = read_file(file);
  return picture_size(bytes) ? truth_of_picture(file, bytes, static_cast<int>(pictures.size()))
                             : truth_of_table(file, pictures);
}

}  // namespace panoptes
