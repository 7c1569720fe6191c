// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/time.h"
#include "core/base/timing.h"
#include "core/camera/observation.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/geometry/body.h"

namespace panoptes {

inline constexpr std::string_view kDatasetSchema = "panoptes.dataset/1";

/// No robot on wheels is farther from the origin of its odometry or of its world (1000 km), or has
/// turned more (160 000 times): a map's cells of 1 mm are counted in 32 bits still.
inline constexpr double kFarthest_m = 1e6;
inline constexpr double kMostTurned_rad = 1e6;
/// Nor faster: 72 km/h, and wheels 1.3 m apart that run at that against each other.
inline constexpr double kFastest_mps = 20;
inline constexpr double kFastest_radps = 30;

/// recording.yaml of a dataset: what the run was.
struct RecordingInfo {
  std::string schema{kDatasetSchema};
  std::string version;
  std::string mission;  ///< the mission's name
  std::uint64_t seed = 1;
  std::optional<Timing> timing = std::nullopt;  ///< of the platform; older recordings do not say
};
void bind(Fields& f, Timing& o);
void bind(Fields& f, RecordingInfo& o);

/// A velocity that was asked for.
struct RecordedCommand {
  Time stamp;  ///< the platform's clock then
  Twist2 command_body;
  Duration valid_for{};
};

/// A picture of a recorded observation, still in its file.
struct RecordedPicture {
  Time stamp;
  std::string file;     ///< from the dataset's folder
  std::string mention;  ///< file:line of the row that names it
};

/// An observation without its pixels.
struct RecordedObservation {
  Time stamp;
  Time now;  ///< the platform's clock when it was handed over
  std::map<std::string, RecordedPicture> pictures;
  Odometry odometry;
  Health health;
};

/// What the robot believed when it was recorded, where the dataset says so.
struct RecordedBeliefs {
  std::optional<RecordingInfo> info;  ///< recording.yaml
  std::optional<Rig> rig;             ///< rig.yaml, its floor marks surveyed
  std::optional<Body> robot;          ///< robot.yaml
};

/// What a robot perceived and was told, in order. Pictures stay in their files.
struct Dataset {
  std::string folder;
  std::vector<std::string> cameras;
  std::vector<RecordedObservation> observations;
  std::vector<RecordedCommand> commands;
  RecordedBeliefs believed;
  std::vector<std::string> warnings;  ///< what a recording that was cut short lacks, in words
  Duration epoch{};                   ///< what its files call the instant that is 0 here
  bool ours = true;  ///< it says of itself what was perceived together; else that was gathered
  std::vector<Time> odometry_rows = {};  ///< of others: when the wheels were read
};

/// What the platform that was recorded stated of its time; where the dataset does not say, the
/// median between two observations, and its longest delivery with a period to decide in.
Timing recorded_timing(const Dataset& dataset);

/// The wall instant of time 0, since 1970, where the stamps of the files are of that clock.
std::optional<std::int64_t> start_unix_ns(const Dataset& dataset);

/// The files of a dataset as text, by their names from the dataset's folder; empty where there is
/// none.
using DatasetText = std::function<std::optional<std::string>(const std::string& file)>;

/// Reads the tables and settings of a dataset. `folder` is for messages, `cameras` are the names of
/// its folders of pictures. A recording of ours that was cut short is read to its last complete
/// frame set. A dataset that has no file of ours (recording.yaml, mav0/events.csv, mav0/cmd0), or
/// whose odometry is mostly of instants without a picture, is somebody else's: its frame sets are
/// gathered (core/io/frame_set_assembly.h) from the cameras of `rig` (all where it has none of
/// them), and the first of them is at 0. Throws ConfigError with the file and line for what is
/// missing or wrong: rows that are lost or swapped before the end, and odometry that no robot on
/// wheels has.
Dataset parse_dataset(const std::string& folder, const std::vector<std::string>& cameras,
                      const DatasetText& text, const Rig& rig = {});

/// The same from a folder. Throws IoError for files that the machine cannot read.
Dataset read_dataset(const std::filesystem::path& folder, const Rig& rig = {});

/// The folders of a dataset's mav0 that hold a camera's pictures: not the truth's, nor other
/// sensors'. In the order of their names.
std::vector<std::string> camera_folders(const std::filesystem::path& mav);

/// One camera's pictures in the order of time, on the clock of the files, whatever else the dataset
/// has. Throws ConfigError with the file and line for what is wrong.
std::vector<RecordedPicture> recorded_pictures(const std::filesystem::path& folder,
                                               const std::string& camera);

/// In words: that the last row of one of its tables was torn when the recording was cut short, and
/// is left out; empty where it is whole.
std::string torn_row(const std::filesystem::path& folder, const std::string& file);

/// Its settings alone. Throws ConfigError for what is no dataset of a robot with wheels.
RecordedBeliefs read_beliefs(const std::filesystem::path& folder);

/// The text of one of a dataset's files; empty where there is none. Throws ConfigError for what is
/// no file, IoError for one that the machine cannot read.
std::optional<std::string> read_part(const std::filesystem::path& file);

/// Looks at the first and last bytes of every picture: throws ConfigError with the place for one
/// that is missing, torn, of more than 8 bits, or of another size than the camera's in `rig`.
void check_pictures(const Dataset& dataset, const Rig& rig);

/// The same of one camera's, of a dataset that is not read as a whole.
void check_pictures(const std::filesystem::path& folder, const std::string& camera,
                    const Intrinsics& lens);

/// One picture, 8-bit BGR. Throws ConfigError with the place for one that cannot be read.
cv::Mat read_picture(const Dataset& dataset, const RecordedPicture& picture);

/// The same in greys, of a dataset that is not read as a whole.
cv::Mat read_grey_picture(const std::filesystem::path& folder, const RecordedPicture& picture);

}  // namespace panoptes
