// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>

#include "core/io/dataset.h"
#include "hw/replay/truth_files.h"

namespace panoptes::hw {

/// What a dataset tells of the truth: our own truth0; else state_groundtruth_estimate0, as EuRoC
/// has it, at the instants of the observations (between its poses, straight), of which no contacts
/// and no layers are known. Where it begins late or ends early, the wheels lead to it as long as
/// they went no farther than 10 cm and 6 degrees, which they tell to a few percent; beyond that
/// there is no truth. What is left out, and why, is added to the dataset's warnings. Throws
/// ConfigError with the file and line for what is wrong.
std::optional<RecordedTruth> truth_of(const std::filesystem::path& folder, Dataset& dataset);

}  // namespace panoptes::hw
