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

/// What a folder's metrics.json tells under this key, where that is a word: "outcome", "command".
/// Empty where it tells none.
std::optional<std::string> told_in_metrics(const std::filesystem::path& folder,
                                           const std::string& key);

}  // namespace panoptes
