// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/truth.h"

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(TruthLayer, AnswersFromTheLowerLeftCorner) {
  const TruthLayer layer{0.5, {1, 2}, 2, 2, {0, 1, 0, 0}};  // set: x 1.5 to 2, y 2 to 2.5
  EXPECT_TRUE(layer.at({1.6, 2.1}));
  EXPECT_FALSE(layer.at({1.4, 2.1}));
  EXPECT_FALSE(layer.at({1.6, 2.6}));
  EXPECT_FALSE(layer.at({0.9, 2.1}));  // outside
  EXPECT_FALSE(layer.at({2.1, 2.1}));
}

}  // namespace
}  // namespace panoptes
