// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/crc32.h"

#include <zlib.h>

namespace panoptes {

std::uint32_t crc32(std::string_view bytes, std::uint32_t before) {
  if (bytes.empty()) {
    return before;  // zlib takes a null pointer for the wish to begin
  }
  return static_cast<std::uint32_t>(
      ::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace panoptes
