// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/base/time.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"

namespace panoptes::sim {

/// Cameras on one clock: those that take a picture at the same pulse of it take it at the same
/// nanosecond. A free-running camera is a group of its own.
struct TriggerGroup {
  std::vector<std::string> cameras;
  double offset_s = 0;      ///< its first pulse after time 0
  double period_error = 0;  ///< of its clock, relative: its periods are longer by this share
  double jitter_s = 0;      ///< standard deviation of each pulse, never over 0.4 periods
  double drops = 0;         ///< share of the pictures that are lost, each camera's by itself
};
void bind(Fields& f, TriggerGroup& o);

/// When the cameras take their pictures. Cameras that no group names are triggered together by a
/// clock without error.
struct TriggerOptions {
  double latency_s = 0;                        ///< a frame set is delivered so long after its stamp
  std::map<std::string, TriggerGroup> groups;  ///< by any name
};
void bind(Fields& f, TriggerOptions& o);

/// What does not go together in settings that speak of one another: the key (dotted), what is wrong
/// and what to do.
struct KeyFault {
  std::string key;
  std::string what;
};

/// All that does not go together in the groups and a rig.
std::vector<KeyFault> trigger_faults(const TriggerOptions& options, const Rig& rig);

/// A picture to be taken.
struct DuePicture {
  Time stamp;               ///< the middle of its exposure
  std::int64_t number = 0;  ///< counts the camera's pictures, lost ones as well
};

/// Pictures that are delivered together, by the cameras' names.
struct FrameSet {
  Time stamp;  ///< no picture's is later
  std::map<std::string, DuePicture> pictures;
};

/// The frame sets of a run. They come at the pulses of the fastest camera (of equals the first by
/// name), lost pictures or not. A set holds each camera's last picture since the set before; a
/// camera that has taken none or lost it is missing. A camera of 0 Hz takes pictures only when it
/// is asked to and is in no set. A rig without other cameras has 15 sets without pictures a second.
class Trigger {
 public:
  /// The groups and the rig go together.
  Trigger(const TriggerOptions& options, const Rig& rig, const Rng& rng);

  const FrameSet& next() const { return next_; }

  /// Between two sets, by the rate that the fastest camera is set to.
  Duration period() const;
  void advance();

 private:
  struct Clock {
    std::string camera;
    double rate_hz = 0;
    TriggerGroup group;
    double shortest_period_s = 0;  // of the group's cameras
    Rng jitter_rng;
    Rng drop_rng;
    std::int64_t next = 0;  // number of its next picture
  };

  static Time trigger_time(const Clock& clock, std::int64_t number);
  static bool dropped(const Clock& clock, std::int64_t number);
  FrameSet gather();

  std::vector<Clock> clocks_;  // in order of the cameras' names
  std::size_t lead_ = 0;
  FrameSet next_;
};

}  // namespace panoptes::sim
