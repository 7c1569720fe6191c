// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/sha256.h"

#include <array>
#include <cstddef>

#include <fmt/format.h>
#include <openssl/evp.h>

#include "core/base/check.h"

namespace panoptes {

std::string sha256(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  const int done =
      EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr);
  PANOPTES_CHECK(done == 1, "libcrypto knows SHA-256");
  std::string text;
  for (std::size_t i = 0; i < size; ++i) {
    text += fmt::format("{:02x}", digest[i]);
  }
  return text;
}

}  // namespace panoptes
