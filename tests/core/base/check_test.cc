// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/check.h"

#include <string>

#include <gmock/gmock.h>

namespace panoptes {
namespace {

TEST(Check, PassesWhatHolds) { EXPECT_NO_THROW(PANOPTES_CHECK(1 + 1 == 2, "sums hold")); }

TEST(Check, SaysWhatMustHoldAndWhere) {
  std::string said;
  try {
    PANOPTES_CHECK(1 + 1 == 3, "sums hold");
  } catch (const CheckError& e) {
    said = e.what();
  }
  EXPECT_THAT(said, testing::HasSubstr("sums hold"));
  EXPECT_THAT(said, testing::HasSubstr("check_test.cc"));
}

}  // namespace
}  // namespace panoptes
