// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <csignal>
#include <optional>
#include <string>
#include <utility>

#include "apps/mission/mission.h"
#include "core/base/error.h"
#include "core/base/time.h"
#include "core/camera/observation.h"

namespace panoptes {

/// The exit status of what the user interrupted: 128 and SIGINT's number.
inline constexpr int kInterrupted = 130;

/// Ends a run: its duration, its number of keyframes, a lost device, a rig that is not the file's,
/// or the user (Ctrl-C, SIGTERM, SIGHUP). A second signal asks to leave out what can be made again
/// from the files of the run; a third one ends the process at once.
class StopCondition {
 public:
  explicit StopCondition(const StopOptions& options);
  ~StopCondition();
  StopCondition(const StopCondition&) = delete;
  StopCondition& operator=(const StopCondition&) = delete;

  bool reached(Time now, std::size_t keyframes) const;
  bool interrupted() const;
  bool hurried() const;  ///< the user has asked again

  /// A device stopped answering: the run ends, and what it did until then is kept.
  void lose_device(const DeviceError& error) { device_fault_ = error.what(); }
  const std::string& device_fault() const { return device_fault_; }  ///< empty: none is lost

  /// Why the odometry tells nothing at `now`; empty when it does. Where it is silent for longer
  /// than somebody takes to switch a base on again, it is a lost device.
  void watch_odometry(Time now, const std::string& fault);

  /// Something holds the robot, and nobody is there to see to it: `outcome` of a run that ends so,
  /// and what it was.
  void hold(const Health& health);
  const std::string& held_by() const { return held_by_; }  ///< empty: nothing
  const char* held_outcome() const { return bumped_ ? "collision" : "failed"; }

  /// Who drives has touched something and has no way on: what it was, in words.
  void collide(std::string touched) { touched_ = std::move(touched); }
  const std::string& touched() const { return touched_; }  ///< empty: nothing

  /// The rig file is wrong in kind: whoever drives, no map of it would be right.
  void refuse_rig(std::string fault) { rig_fault_ = std::move(fault); }
  const std::string& rig_fault() const { return rig_fault_; }  ///< empty: nothing is

  std::string end_reason(Time now, std::size_t keyframes) const;  ///< "duration" or "keyframes"

 private:
  StopOptions options_;
  std::array<struct sigaction, 3> before_ = {};
  std::string device_fault_;
  std::optional<Time> odometry_silent_since_;
  std::string held_by_;
  std::string touched_;
  std::string rig_fault_;
  bool bumped_ = false;
};

}  // namespace panoptes
