// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/recorded_wheels.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/io/dataset_rows.h"
#include "core/io/gaps.h"

namespace panoptes {

RecordedWheels::RecordedWheels(const std::string& dataset)
    : file_((std::filesystem::path(dataset) / kOdometryFile).string()),
      rows_(recorded_odometry(
          dataset,
          [&](const std::string& file) { return read_part(std::filesystem::path(dataset) / file); },
          written_by(dataset))) {
  add_velocities(rows_);
  constexpr int kPeriods = 4;
  std::vector<Time> stamps;
  for (const StampedOdometry& row : rows_) {
    stamps.push_back(row.stamp);
  }
  longest_gap_ = kPeriods * median_period(stamps);
}

std::optional<Odometry> RecordedWheels::at(Time instant) const {
  if (instant < rows_.front().stamp || instant > rows_.back().stamp) {
    return std::nullopt;
  }
  const auto after =
      std::lower_bound(rows_.begin(), rows_.end(), instant,
                       [](const StampedOdometry& row, Time at) { return row.stamp < at; });
  if (after != rows_.begin() && after->stamp - std::prev(after)->stamp > longest_gap_) {
    return std::nullopt;
  }
  return odometry_at(rows_, instant);
}

void RecordedWheels::check_reach(const std::vector<RecordedPicture>& pictures,
                                 const RigCamera& camera) const {
  const auto outside =
      std::count_if(pictures.begin(), pictures.end(), [&](const RecordedPicture& picture) {
        return !at(picture.stamp - from_seconds(camera.clock_offset_s));
      });
  if (2 * outside > static_cast<std::ptrdiff_t>(pictures.size())) {
    const auto span = [](Time from, Time to) {
      return fmt::format("{:.3f} to {:.3f} s", to_seconds(from.time_since_epoch()),
                         to_seconds(to.time_since_epoch()));
    };
    const bool is_apart =
        rows_.back().stamp < pictures.front().stamp || pictures.back().stamp < rows_.front().stamp;
    throw ConfigError(
        fmt::format("{}: is of {}, the camera's pictures of {}: it misses {} of {}; {}", file_,
                    span(rows_.front().stamp, rows_.back().stamp),
                    span(pictures.front().stamp, pictures.back().stamp), outside, pictures.size(),
                    is_apart ? "stamp both by one clock"
                             : "record it for as long as the pictures, or remove the file to "
                               "calibrate without a metre"));
  }
}

}  // namespace panoptes
