// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "apps/run/mission.h"
#include "apps/run/open_robot.h"
#include "apps/run/recorder.h"
#include "apps/run/stage_clock.h"
#include "apps/run/until.h"
#include "core/eval/run_result.h"
#include "core/nav/navigator.h"
#include "hw/robot.h"
#include "sim/render/renderer.h"

namespace panoptes {

/// A person drives. On a recording nobody can: it is driven as it was then.
bool by_hand(const ExploreMission& mission);

/// The steps of the one loop, timed. Where the rig lacks what a navigator needs there is none:
/// nothing is mapped, and somebody else drives.
StageListener listener(StageClock& clock);
Observation observe(hw::Robot& robot, const ExploreMission& mission, StageClock& clock);
/// Where somebody else drives, the navigator maps along and has no say: no command, no goal.
NavStep navigate(std::optional<Navigator>& navigator, const Observation& seen,
                 const DriveOptions& drive, StageClock& clock);

/// The step with a person's command for the navigator's.
NavStep driven_by_hand(NavStep step, const Twist2& command_body);
/// How long a command may hold: no longer than a key that is not repeated, where a person drives.
Duration command_valid_for(const ExploreMission& mission);

/// Throws ConfigError, with the place where the user gave it, for a start that a robot which can
/// still be kept from moving must not move from.
void refuse_bad_start(const ExploreMission& mission, const std::optional<Navigator>& navigator);

/// Whoever the mission lets drive says when there is nothing left to do; a recording ends, and a
/// navigator that would have driven elsewhere has no say in when.
bool finished(const DriveOptions& drive, const std::optional<Navigator>& navigator,
              const OpenRobot& open);
std::string doing(const std::optional<Navigator>& navigator, const NavStep& step);
std::size_t keyframe_count(const std::optional<Navigator>& navigator);

/// What the recorder needs to know before and after.
RunInfo run_info(const std::string& command, const ExploreMission& mission);
RunResult run_result(const std::optional<Navigator>& navigator);
RunEnd run_end(const Until& until, const ExploreMission& mission,
               const std::optional<Navigator>& navigator, const OpenRobot& open);

/// Drawing that tells how far the light is where it is not known yet, and stops when the user does.
sim::RendererOptions patient_renderer(const Until& until, bool quiet);

/// The summary and the pictures' names on stdout.
void print(const RunReport& report);

}  // namespace panoptes
