// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/geometry/pose2.h"

namespace panoptes {

struct CameraHealthOptions {
  double missing_periods = 2.5;  ///< of the camera's: two pictures lost in a row are no lost
                                 ///< camera, three are
  double jitter_periods = 0.5;   ///< by which a picture may come early
  double moved_px = 0.5;         ///< the least motion that must change a picture: of a turn,
  double room_m = 4;             ///< or of what stands so far away, a room's width
  double noise_sigmas = 5;       ///< of a cell's second difference: one cell in a million by chance
  double min_contrast_grey = 1;  ///< likewise, where there is no noise: a step of 8 bits
  int blank_cells = 3;           ///< of 40 x 30, by chance: a picture with no more shows nothing
  int min_cells = 12;            ///< 1 %: fewer are a speck, and their going says nothing
  double dark_grey = 8;          ///< the mean below which a picture without structure is dark,
  double dark_share = 0.4;    ///< or so much of it is 0: noise about no light is that half the time
  int white_grey = 250;       ///< saturated: 255 but for noise
  double white_share = 0.95;  ///< of a picture, but for what vignetting darkens
  double going_s = 0.5;       ///< for a hand to pass over a lens
  double nearest_m = 0.3;     ///< what a camera on the robot can have before it
  int clock_pictures = 30;    ///< the first ones, that tell another clock from a slow bus
  double good_again_s = 0.1;  ///< it shows something, after it was covered: three pictures at 15 Hz
};
void bind(Fields& f, CameraHealthOptions& o);

enum class CameraState {
  kGood,
  kMissing,    ///< no picture for longer than a few lost ones explain
  kLate,       ///< its pictures are as old as that when they come
  kFrozen,     ///< the same bits again, though the robot has moved
  kDark,       ///< nothing but the sensor's own noise
  kSaturated,  ///< white all over
  kCovered     ///< all that it showed went at once, faster than the robot's motion explains
};
std::string_view name_of(CameraState state);

/// How a camera is, and how it was.
struct CameraReport {
  CameraState state = CameraState::kGood;
  Time since{};     ///< it is good, or not
  int missing = 0;  ///< pictures, by its rate
  int late = 0;     ///< pictures counted so, each once
  int frozen = 0;
  int dark = 0;
  int saturated = 0;
  int covered = 0;
  Duration lost{};        ///< time in any state but good
  bool is_floor = false;  ///< by its roles: what is lost with it
  bool is_loop = false;
};
using CameraReports = std::map<std::string, CameraReport>;

/// Cameras that are not good, in words: "camera floor: frozen; ..."; empty when all are.
std::string told(const CameraReports& cameras);

/// Watches every camera of a rig that takes pictures by itself. Knows no robot and no clock: only
/// what was observed. A camera is judged by what it shows and by the motion that the wheels measure
/// meanwhile: a plain wall close ahead, which fills the picture little by little, is no fault, nor
/// are equal pictures of a robot that stands.
class CameraHealth {
 public:
  explicit CameraHealth(const Rig& rig, const CameraHealthOptions& options = {});

  /// Once an observation, in their order.
  const CameraReports& check(const Observation& seen);

  const CameraReports& reports() const { return reports_; }

  /// A camera whose every picture was as old when it came, in words; empty where there is none. No
  /// bus does that from the start on: its clock is another one than the odometry's.
  std::string wrong_clock() const;

  /// The observation without the pictures of cameras that are not good.
  Observation accepted(const Observation& seen) const;

 private:
  /// What a picture shows, on a coarse grid.
  struct PictureSummary {
    Time stamp;
    Pose2 T_odom_body;
    cv::Mat shows;  // CV_8U, a cell each: 255 where there is more than noise and even shading
    int shown = 0;  // cells
  };
  struct Watched {
    double period_s = 0;
    double fx_px = 0;
    double clock_offset_s = 0;  // of the rig file
    Time since{};               // it is watched, or its last picture
    std::optional<Time> last_stamp;
    int pictures = 0;
    double least_age_s = std::numeric_limits<double>::infinity();  // when they came
    double most_age_s = 0;
    int missed = 0;                        // pictures since then
    std::optional<Picture> last;           // other bits than the one before
    Pose2 T_odom_last;                     // when that first came
    std::deque<PictureSummary> summaries;  // the last few that showed something
    std::optional<Time> shows_since;       // something again, without a break, while covered
    // headings, of the wheels, in which nothing has been seen, in a row
    double blank_rad = 0;
    double least_blank_rad = 0;
    double most_blank_rad = 0;
  };

  void count_missing(const Observation& seen, const Picture* picture, Watched& camera,
                     CameraReport& report) const;
  CameraState judge(const Observation& seen, const Picture& picture, Watched& camera,
                    CameraState before) const;

  CameraHealthOptions options_;
  std::map<std::string, Watched> watched_;
  CameraReports reports_;
  std::optional<Time> last_;
  std::optional<double> heading_rad_;
  double turned_rad_ = 0;
};

}  // namespace panoptes
