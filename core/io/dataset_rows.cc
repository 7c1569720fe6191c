// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/dataset_rows.h"

#include <cmath>
#include <filesystem>
#include <system_error>

#include "core/io/digits.h"

namespace panoptes {

std::string in_folder(const std::string& folder, std::string_view file) {
  return (std::filesystem::path(folder) / file).string();
}

TableBy written_by(const std::string& folder) {
  std::error_code error;
  return std::filesystem::exists(in_folder(folder, "recording.yaml"), error) ? TableBy::kPanoptes
                                                                             : TableBy::kOthers;
}

std::string data_csv(const std::string& camera) { return "mav0/" + camera + "/data.csv"; }

ConfigError no_pictures(const std::string& folder, const std::string& camera) {
  return ConfigError(in_folder(folder, "mav0/" + camera) + ": has no data.csv");
}

std::vector<RecordedPicture> picture_rows(const DatasetTable& rows, const std::string& camera) {
  std::vector<RecordedPicture> pictures;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const Time stamp = rows.stamp(row, 0);
    const std::string& file = rows.text(row, 1);
    if (!pictures.empty() && stamp <= pictures.back().stamp) {
      throw rows.fault(
          row, "is not after the row before: put rows in the order of their stamps, each once");
    }
    if (file.empty() || file.find('/') != std::string::npos || file == "." || file == "..") {
      throw rows.fault(row, "must name a file of data/");
    }
    pictures.push_back({stamp, "mav0/" + camera + "/data/" + file, rows.place(row)});
  }
  return pictures;
}

Odometry odometry_row(const DatasetTable& rows, std::size_t row) {
  constexpr std::size_t kWithVelocity = 6;
  Odometry odometry;
  odometry.T_odom_body = {rows.bounded(row, 1, kFarthest_m), rows.bounded(row, 2, kFarthest_m),
                          rows.bounded(row, 3, kMostTurned_rad)};
  if (rows.columns() >= kWithVelocity) {
    odometry.twist_body = {rows.bounded(row, 4, kFastest_mps),
                           rows.bounded(row, 5, kFastest_radps)};
  }
  return odometry;
}

void check_speed(const DatasetTable& rows, std::size_t row, const Odometry& before,
                 const Odometry& here, Duration between) {
  constexpr double kJump_m = 1;  // what odometry may jump besides, where stamps are rough
  const double distance_m = (here.T_odom_body.position() - before.T_odom_body.position()).norm();
  const double time_s = std::abs(to_seconds(between));
  if (distance_m > kJump_m + kFastest_mps * time_s) {
    throw rows.fault(row, "jumps " + shortest(distance_m) + " m in " + shortest(time_s) +
                              " s; no robot on wheels is faster than " + shortest(kFastest_mps) +
                              " m/s: mend or remove what is wrong");
  }
}

}  // namespace panoptes
