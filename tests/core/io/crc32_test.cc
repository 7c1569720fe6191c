// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/crc32.h"

#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(Crc32, IsThatOfPngAndZlib) {
  EXPECT_EQ(crc32("123456789"), 0xcbf43926U);  // the check value of its specification
  EXPECT_EQ(crc32(""), 0U);
}

TEST(Crc32, GoesOnFromTheBytesBefore) {
  const std::string all = "a picture and what follows";
  for (std::size_t at = 0; at <= all.size(); ++at) {
    EXPECT_EQ(crc32(std::string_view(all).substr(at), crc32(all.substr(0, at))), crc32(all)) << at;
  }
  EXPECT_EQ(crc32({}, 7), 7U);
}

}  // namespace
}  // namespace panoptes
