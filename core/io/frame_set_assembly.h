// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/io/dataset.h"
#include "core/io/dataset_table.h"

namespace panoptes {

/// What the wheels said at an instant of their own.
struct StampedOdometry {
  Time stamp;
  Odometry odometry;
};

/// Frame sets of cameras that nobody has synchronised: each picture of the fastest camera makes
/// one, and takes the nearest picture of every other camera within half the fastest one's period
/// (median). What is left, where the fastest lacks a picture, is gathered among itself. A set is of
/// the instant of its first camera's picture, and was perceived when its last picture was there.
std::vector<RecordedObservation> assemble_frame_sets(
    std::map<std::string, std::vector<RecordedPicture>> cameras);

/// The odometry of a dataset, ours or somebody else's, in the order of time: a row at least. Throws
/// ConfigError with the file and line for what is missing or wrong.
std::vector<StampedOdometry> recorded_odometry(const std::string& folder, const DatasetText& text,
                                               TableBy by);

/// Odometry at an instant between two rows: the pose on the arc between theirs, the velocity
/// between theirs. The instant lies within the rows, which are in the order of time.
Odometry odometry_at(const std::vector<StampedOdometry>& rows, Time stamp);

/// Rows that tell no velocity get the mean one of the tenth of a second about them.
void add_velocities(std::vector<StampedOdometry>& rows);

/// Reads the observations of somebody else's dataset: the frame sets gathered from the cameras of
/// `rig` (all where it has none of them), odometry interpolated at their instants; where pictures
/// pause, what the wheels say meanwhile. Time and odometry begin at the first frame set. Throws
/// ConfigError with the file and line for what is missing or wrong, and where odometry does not
/// reach over most of the frame sets; what it does not reach over at the ends is left out with a
/// remark.
void assemble_observations(Dataset& dataset, const Rig& rig, const DatasetText& text);

}  // namespace panoptes
