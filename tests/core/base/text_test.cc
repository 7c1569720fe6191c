// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/text.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(Text, NaturalOrderIsThatOfNumbers) {
  const std::vector<std::string> ordered{"",
                                         "1.jpg",
                                         "2.jpg",
                                         "010.jpg",
                                         "10.jpg",
                                         "a",
                                         "a2b1",
                                         "a2b10",
                                         "a10b2",
                                         "b",
                                         "f99999999999999999999",
                                         "f100000000000000000000"};
  for (std::size_t i = 0; i < ordered.size(); ++i) {
    for (std::size_t j = 0; j < ordered.size(); ++j) {
      EXPECT_EQ(natural_less(ordered[i], ordered[j]), i < j) << ordered[i] << " " << ordered[j];
    }
  }
}

TEST(Text, OneThingIsNoneOfMany) {
  EXPECT_EQ(counted(1, "picture"), "1 picture");
  EXPECT_EQ(counted(0, "picture"), "0 pictures");
}

TEST(Text, WhatXmlTakesForItsOwnIsEscaped) {
  EXPECT_EQ(xml_text("a<b>&\"c\"\x01\n"), "a&lt;b&gt;&amp;&quot;c&quot; \n");
}

TEST(Text, BetweenQuotesKeepsQuotesAndBackslashes) {
  EXPECT_EQ(in_quotes("a b"), "\"a b\"");
  EXPECT_EQ(in_quotes("a\"\\"), "\"a\\\"\\\\\"");
}

}  // namespace
}  // namespace panoptes
