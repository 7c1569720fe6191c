// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

#include "apps/process/fault.h"

namespace panoptes {

/// Writes metrics.json of a stage, with what went wrong so far and what the process has used.
void write_metrics(const std::filesystem::path& folder, nlohmann::ordered_json figures,
                   Faults& faults);

}  // namespace panoptes
