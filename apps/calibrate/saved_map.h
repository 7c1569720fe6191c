// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/calib/mono_map.h"

namespace panoptes {

/// One camera's map as a file, so that a calibration that was interrupted need not make it again.
/// `made_of` says what it was made of and how; descriptors are left out. Throws IoError.
void write_map(const std::filesystem::path& path, const std::string& made_of, const MonoMap& map);

/// Empty where there is none, or not one of this. `lens` is of the camera.
std::optional<MonoMap> read_map(const std::filesystem::path& path, const std::string& made_of,
                                const Intrinsics& lens);

}  // namespace panoptes
