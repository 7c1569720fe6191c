// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

namespace panoptes {

/// The checksum of PNG and zlib; `before`: that of the bytes before these, if there are any.
std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0);

}  // namespace panoptes
