// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/mission/mission.h"
#include "apps/mission/open_robot.h"
#include "apps/mission/stop_condition.h"
#include "apps/process/stage_clock.h"
#include "core/base/rng.h"
#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/nav/pilot_step.h"
#include "core/nav/slam.h"
#include "hw/robot.h"

namespace panoptes {

/// Who drives a mission: chosen once, asked at each step.
class Pilot {
 public:
  virtual ~Pilot() = default;

  virtual PilotStep step(const Observation& seen, const SlamStep& at) = 0;

  /// Nothing is left to do.
  virtual bool done() const = 0;
  /// By what it says itself all has been explored.
  virtual bool explored() const { return false; }

  /// What has become of the places that it was told to drive to; none where it was told of none.
  virtual std::vector<GoalProgress> goals() const { return {}; }

  /// Sees to what holds the robot, or ends the run.
  virtual void handle_hold(const Health& health, const PilotStep& step, hw::Robot& robot,
                           StopCondition& stop_condition);

  /// What the user ought to know before it drives, in words.
  virtual std::vector<std::string> warnings() const { return {}; }

  /// What it leaves undone if the run ends now, in words; empty where there is nothing to tell.
  virtual std::string unfinished() const { return {}; }

  /// How long it drives, about, where it knows beforehand.
  virtual Duration length() const { return Duration::max(); }

  /// The longest that it waits for pictures, and that a command of its may hold.
  virtual Duration longest_wait() const { return Duration::max(); }
  virtual Duration longest_command() const { return Duration::max(); }

  /// It shows how the run goes itself.
  virtual bool shows_progress() const { return false; }

  /// The run is over: the terminal is its owner's again.
  virtual void leave() {}
};

/// Who drives takes the terminal for a person. On a recording nobody can drive: it is driven as it
/// was then.
bool takes_terminal(const ExploreMission& mission);

class TeleopConsole;

/// What a pilot may be made of. `slam` is null where the rig lacks what it needs, but for a pilot
/// that says kSlam; `console` where who drives does not take the terminal. What is given outlives
/// it.
struct PilotParts {
  const ExploreMission& mission;
  const OpenRobot& open;
  Slam* slam;
  std::unique_ptr<TeleopConsole>& console;
  const Rng& rng;
  StageListener& listener;
};

/// The mission's. `drive: NAME` is driven by what the file NAME.cc of this room makes with
/// `std::unique_ptr<Pilot> make_NAME_pilot(PilotParts& parts)`; apps/CMakeLists.txt lists them,
/// with what each cannot drive without.
std::unique_ptr<Pilot> make_pilot(const ExploreMission& mission, const OpenRobot& open, Slam* slam,
                                  std::unique_ptr<TeleopConsole> console, const Rng& rng,
                                  StageListener listener);

/// How the run goes, in words: what is mapped, and what who drives is doing.
std::string doing(const Slam* slam, const PilotStep& step);

}  // namespace panoptes
