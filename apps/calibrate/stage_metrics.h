// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "apps/process/fault.h"

namespace panoptes {

/// Writes metrics.json of a stage, with what went wrong so far and what the process has used.
void write_metrics(const std::filesystem::path& folder, nlohmann::ordered_json figures,
                   Faults& faults);

/// The outcome that a folder's metrics.json tells. Empty where it has none.
std::optional<std::string> outcome_of(const std::filesystem::path& folder);

}  // namespace panoptes
