// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string_view>

namespace panoptes {

/// Writes the bytes to an open file, again where a signal cut in; returns how many. Fewer than all:
/// errno says why.
std::size_t write_all(int descriptor, std::string_view bytes);

}  // namespace panoptes
