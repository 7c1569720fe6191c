// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "core/base/time.h"
#include "core/camera/observation.h"

namespace panoptes::hw {

/// Pictures of one instant, as cameras deliver them.
struct CameraSet {
  Time stamp;
  std::map<std::string, Picture> pictures;
};

/// Where a robot's pictures come from (hw/physical), whoever makes the cameras. One thread calls
/// it; it may have threads of its own, which have ended when it is destroyed.
class CameraSource {
 public:
  virtual ~CameraSource() = default;

  /// From here on there are sets. They are stamped by `now`, as the base's reports are, and
  /// `arrived` is called after each that next() has for the taking. Both may be called on any
  /// thread until the source is destroyed. Called once.
  virtual void start(std::function<Time()> now, std::function<void()> arrived) = 0;

  /// The next set that has arrived, in order of time; empty when none has. Never waits.
  virtual std::optional<CameraSet> next() = 0;

 protected:
  CameraSource() = default;
  CameraSource(const CameraSource&) = delete;
  CameraSource& operator=(const CameraSource&) = delete;
};

}  // namespace panoptes::hw
