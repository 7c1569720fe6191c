// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/camera/rig.h"
#include "core/eval/rig_figures.h"
#include "core/eval/truth.h"
#include "core/geometry/body.h"

namespace panoptes {

/// By how much the cameras that a robot believes in truly are mounted, draw and tell the time
/// otherwise: truth minus belief. Cameras that the truth does not know are left out, and the
/// distortion of one whose lens is believed to be of another kind.
nlohmann::ordered_json camera_errors(const Rig& truth, const Rig& believed);

/// By how much its wheels are larger and farther apart.
nlohmann::ordered_json wheel_errors(const TrueWheels& truth, const Body& believed);

/// What a run has learned: each number with its `_sigma` and, with truth, its `_error`. What it
/// does not know of is absent.
nlohmann::ordered_json rig_json(const std::map<std::string, LearnedCamera>& cameras);
nlohmann::ordered_json wheels_json(const LearnedWheels& wheels);

/// What was said of wheels, its errors against this truth in the place of any other.
void put_wheel_errors(nlohmann::ordered_json& wheels, const TrueWheels& truth);

}  // namespace panoptes
