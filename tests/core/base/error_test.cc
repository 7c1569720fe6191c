// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/error.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(ConfigError, HoldsEveryLine) {
  const ConfigError error(std::vector<std::string>{"a.yaml:1:1: x: wrong", "a.yaml:2:1: y: wrong"});
  EXPECT_EQ(error.lines().size(), 2U);
  EXPECT_STREQ(error.what(), "a.yaml:1:1: x: wrong\na.yaml:2:1: y: wrong");
  EXPECT_STREQ(ConfigError("one").what(), "one");
}

}  // namespace
}  // namespace panoptes
