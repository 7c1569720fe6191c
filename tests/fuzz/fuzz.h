// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace panoptes::fuzz {

/// What a fuzz target gives: reads the bytes as if they came from a user. It may throw what the
/// user is told (ConfigError, IoError) and nothing else. Each target's own .cc defines it.
void read_input(std::string_view bytes);

/// Words that mean something to the reader, to put in. Each target's own .cc defines it.
std::vector<std::string> words();

/// With what means something in any yaml.
std::vector<std::string> with_yaml(std::vector<std::string> words);

/// The files inside of one input: each begins with a line `=== name`. Names have letters, digits,
/// dots, dashes, slashes and underscores and lead nowhere else; what has another is left out.
std::map<std::string, std::string> files_in(std::string_view bytes);

/// Writes them into a folder of this process that is emptied first.
std::filesystem::path written_files(std::string_view bytes);

}  // namespace panoptes::fuzz
