// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "apps/mission/mission.h"
#include "apps/mission/open_robot.h"
#include "apps/mission/stop_condition.h"
#include "apps/pilots/pilot.h"
#include "apps/process/stage_clock.h"
#include "apps/report/recorder.h"
#include "core/eval/run_result.h"
#include "core/io/keyframe_files.h"
#include "core/nav/slam.h"
#include "sim/render/renderer.h"

namespace panoptes {

/// Times slam's and the navigator's stages.
StageListener listener(StageClock& clock);

/// Throws ConfigError, with the place where the user gave it, for a start that a robot which can
/// still be kept from moving must not move from.
void refuse_bad_start(const ExploreMission& mission, const Slam* slam);

/// Whoever drives says when there is nothing left to do; a recording ends, and a navigator that
/// would have driven elsewhere has no say in when.
bool finished(const Pilot& pilot, const OpenRobot& open);
std::size_t keyframe_count(const Slam* slam);

/// What the recorder needs to know before and after.
RunInfo run_info(const std::string& command, const ExploreMission& mission);
RunResult run_result(const Slam* slam);
KeptKeyframes kept_keyframes(const Slam* slam);
RunEnd run_end(const StopCondition& stop_condition, const ExploreMission& mission, const Slam* slam,
               const Pilot& pilot, const OpenRobot& open);

/// Drawing that tells how far the light is where it is not known yet, and stops when the user does.
sim::RendererOptions patient_renderer(const StopCondition& stop_condition, bool quiet);

/// The summary and the pictures' names on stdout.
void print(const RunReport& report);

}  // namespace panoptes
