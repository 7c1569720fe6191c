// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace panoptes {

/// Throws ConfigError where the file that `flag` names cannot be written at the end: the user is
/// told before anything runs.
void check_out_file(const std::string& flag, const std::filesystem::path& file);

}  // namespace panoptes
