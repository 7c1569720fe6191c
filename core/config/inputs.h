// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace panoptes {

/// From now on the process keeps in mind what it reads, and nothing of before: for who wants to
/// know what a result was made of.
void keep_inputs();

/// Called by whoever reads a file that settings, or the files they name, mention. The first reading
/// of a file counts. Next to nothing until somebody keeps inputs.
void note_input(const std::filesystem::path& file, std::string_view bytes);
void note_input(const std::filesystem::path& file);  ///< reads it; none where it cannot

/// Every file by its full name, with the SHA-256 of what was in it.
std::map<std::string, std::string> inputs();

/// As `sha256sum` writes them, a line a file, and reads them (`sha256sum -c`).
std::string inputs_text(const std::map<std::string, std::string>& inputs);
/// Lines that are none are left out.
std::map<std::string, std::string> parse_inputs(std::string_view text);

}  // namespace panoptes
