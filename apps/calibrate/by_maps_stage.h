// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "apps/calibrate/rig_stage.h"

namespace panoptes {

/// The rest of the rig's stage, by the cameras' maps alone (calibrate_by_maps), once each camera
/// has its map: writes what it finds to `out`, and metrics.json of `figures` and more, with the
/// `warnings` of the recording. The exit status.
int calibrate_rig_by_maps(const RigStage& args, const std::filesystem::path& out,
                          const std::vector<MappedCamera>& cameras, const FramePicture& picture,
                          const std::vector<std::string>& warnings, nlohmann::ordered_json figures,
                          const std::function<void(double)>& progress);

}  // namespace panoptes
