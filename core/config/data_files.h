// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace panoptes {

/// Where the files that belong to Panoptes lie, `scenes` and `assets` inside: $PANOPTES_DATA, else
/// the source tree it was built from, else `../share/panoptes` beside the program.
std::string data_root();

/// A file name that opens, from a name as written: `data:worlds/office.yaml` is looked for in
/// `scenes` and `assets` of the data root; another relative one beside `mentioned_in`.
std::string resolve_path(const std::string& written, const std::string& mentioned_in);

/// The inverse, for writing: `data:...` for a file of the data root, else its absolute name.
std::string portable_path(const std::string& file);

/// Whether it is one of Panoptes's own: a machine without it lacks something, while any other file
/// that is missing or damaged was named by the user.
bool is_shipped(const std::string& file);

}  // namespace panoptes
