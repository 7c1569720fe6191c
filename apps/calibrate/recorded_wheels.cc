// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/recorded_wheels.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/io/dataset_rows.h"

namespace panoptes {

RecordedWheels::RecordedWheels(const std::string& dataset)
    : rows_(recorded_odometry(
          dataset,
          [&](const std::string& file) { return read_part(std::filesystem::path(dataset) / file); },
          written_by(dataset))) {
  add_velocities(rows_);
}

std::optional<Odometry> RecordedWheels::at(Time instant) const {
  return instant >= rows_.front().stamp && instant <= rows_.back().stamp
             ? std::optional<Odometry>(odometry_at(rows_, instant))
             : std::nullopt;
}

void RecordedWheels::check_reach(const std::vector<RecordedPicture>& pictures,
                                 const RigCamera& camera) const {
  const auto outside =
      std::count_if(pictures.begin(), pictures.end(), [&](const RecordedPicture& picture) {
        return !at(picture.stamp - from_seconds(camera.clock_offset_s));
      });
  if (2 * outside > static_cast<std::ptrdiff_t>(pictures.size())) {
    throw ConfigError(
        fmt::format("{}: is not of the time of the camera's pictures, of which it "
                    "misses {} of {}; are both by one clock?",
                    kOdometryFile, outside, pictures.size()));
  }
}

}  // namespace panoptes
