// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"
#include "core/io/dataset.h"
#include "core/io/dataset_table.h"

namespace panoptes {

// What the rows of a dataset are like, whoever has written it.

inline constexpr std::string_view kOdometryFile = "mav0/odom0/data.csv";

/// Between two rows of one drive: a robot of ours answers within a minute (frame_deadline_s).
inline constexpr Duration kLongestGap = std::chrono::hours(1);

/// `folder` and a file of it, for messages.
std::string in_folder(const std::string& folder, std::string_view file);

/// Who has written a dataset: `panoptes record`, which says so in recording.yaml, or others.
TableBy written_by(const std::string& folder);

/// A camera's table, from the dataset's folder; and what is said where it is missing.
std::string data_csv(const std::string& camera);
ConfigError no_pictures(const std::string& folder, const std::string& camera);

/// The rows of a camera's data.csv; throws ConfigError for pictures that are not in the order of
/// time, and for what names no file.
std::vector<RecordedPicture> picture_rows(const DatasetTable& rows, const std::string& camera);

/// The pose and velocity of a row of odometry; no velocity where the table has none.
Odometry odometry_row(const DatasetTable& rows, std::size_t row);

/// Throws ConfigError where no robot on wheels gets from one row to this one in the time between.
void check_speed(const DatasetTable& rows, std::size_t row, const Odometry& before,
                 const Odometry& here, Duration between);

}  // namespace panoptes
