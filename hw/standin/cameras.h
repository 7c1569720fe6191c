// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <utility>

#include "hw/camera_source.h"

namespace panoptes::hw {

/// A stand-in's pictures, which travel in memory: in the same thread, and stamped by the robot that
/// has taken them, whose time is the link's (StandInLink).
class StandInCameras final : public CameraSource {
 public:
  void add(const Observation& seen) {
    if (arrived_) {  // else there is nobody to see them yet
      sets_.push_back({seen.stamp, seen.pictures});
      arrived_();
    }
  }

  void start(std::function<Time()> /*now*/, std::function<void()> arrived) override {
    arrived_ = std::move(arrived);
  }

  std::optional<CameraSet> next() override {
    if (sets_.empty()) {
      return std::nullopt;
    }
    CameraSet set = std::move(sets_.front());
    sets_.pop_front();
    return set;
  }

 private:
  std::function<void()> arrived_;
  std::deque<CameraSet> sets_;
};

}  // namespace panoptes::hw
