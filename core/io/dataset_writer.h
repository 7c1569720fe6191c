// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <opencv2/core/mat.hpp>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/camera/rig.h"
#include "core/geometry/body.h"
#include "core/io/dataset.h"
#include "core/io/growing_file.h"

namespace panoptes {

/// A camera's folder of a dataset, mav0/<name>: data/<ns>.png and a row for each in data.csv, once
/// the picture is whole.
class PictureFolder {
 public:
  enum class Kind { kNoisy, kFlat };  ///< how it is packed; lossless in any case

  PictureFolder(std::filesystem::path folder, Kind kind);
  void add(Time stamp, const cv::Mat& picture);  ///< 8 or 16 bit

 private:
  std::filesystem::path folder_;
  Kind kind_;
  GrowingFile rows_;
};

/// Depth as datasets keep it: 16 bit, 0 where nothing is, 65535 where it is that far or farther.
cv::Mat millimetres(const cv::Mat& depth_m);

/// How to read it, for a camera with this lens.
std::string depth_comment(const Intrinsics& lens);

/// The table that names the numbers of labels: of a world's objects from 1, in order; 0 is nothing.
std::string things_csv(const std::vector<std::string>& things);

/// Writes a dataset in the layout of EuRoC (Burri et al. 2016) while a robot drives: whatever kills
/// the recording, all that was added before is readable. Not for many threads at once.
class DatasetWriter {
 public:
  /// `folder` is there and empty, but for files that no dataset has. `rig` is what the robot
  /// believes, its floor marks surveyed.
  DatasetWriter(std::filesystem::path folder, const RecordingInfo& info, const Rig& rig,
                const Body& robot);

  /// `now` is the platform's clock. Its row of odometry is written last: an observation without it
  /// is not complete.
  void add(const Observation& seen, Time now);
  void add(const RecordedCommand& command);

  /// A row of mav0/events.csv that the observation does not hold by itself.
  void add_event(Time stamp, std::string_view kind, std::string_view subject,
                 std::string_view value);

 private:
  void add_events(const Observation& seen, Time now);

  std::filesystem::path folder_;
  std::map<std::string, RigCamera> rig_;
  std::map<std::string, PictureFolder> cameras_;
  std::optional<GrowingFile> odometry_;
  std::optional<GrowingFile> commands_;
  std::optional<GrowingFile> events_;
  Health health_;
  std::map<std::string, Time> last_picture_;
};

/// Makes a folder and those above it. Throws IoError.
void make_folder(const std::filesystem::path& folder);

}  // namespace panoptes
