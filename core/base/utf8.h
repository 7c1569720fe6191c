// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace panoptes {

/// Where the first byte stands that is no part of UTF-8 text; npos where all of it is.
std::size_t first_not_utf8(std::string_view text);

/// What follows the byte order mark that editors and spreadsheets begin a file with.
std::string_view without_byte_order_mark(std::string_view text);

/// The same as UTF-8: bytes that are no part of it as `\xE9`.
std::string as_utf8(std::string_view text);

}  // namespace panoptes
