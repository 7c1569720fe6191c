// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/utf8.h"

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(Utf8, IsToldFromOtherBytes) {
  for (const char* good : {"", "plain", "caf\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\xa4\x96"}) {
    EXPECT_EQ(first_not_utf8(good), std::string::npos) << good;
    EXPECT_EQ(as_utf8(good), good);
  }
  // Latin-1, cut short, overlong, half of a surrogate pair, beyond the last character
  for (const char* bad :
       {"\xe9", "\xc3", "\xc0\xaf", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xff"}) {
    EXPECT_EQ(first_not_utf8(std::string("ab") + bad), 2U) << bad;
    EXPECT_EQ(first_not_utf8(as_utf8(bad)), std::string::npos);
  }
  EXPECT_EQ(as_utf8("caf\xe9 au lait"), "caf\\xE9 au lait");
}

}  // namespace
}  // namespace panoptes
