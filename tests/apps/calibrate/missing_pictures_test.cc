// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/missing_pictures.h"

#include <gmock/gmock.h>

namespace panoptes {
namespace {

using testing::HasSubstr;

std::vector<Time> at(const std::vector<double>& seconds) {
  std::vector<Time> stamps;
  for (const double s : seconds) {
    stamps.push_back(Time() + from_seconds(s));
  }
  return stamps;
}

TEST(MissingPictures, AreNoneWherePicturesComeEvenly) {
  EXPECT_EQ(missing_pictures("left", at({0, 0.1, 0.2, 0.305, 0.395, 0.5})), "");
  EXPECT_EQ(missing_pictures("left", at({0, 1})), "");
  EXPECT_EQ(missing_pictures("left", {}), "");
}

TEST(MissingPictures, AreCountedAndTheLongestGapIsNamed) {
  const std::string said =
      missing_pictures("left", at({0, 0.1, 0.2, 0.3, 0.5, 0.6, 0.7, 0.8, 1.3, 1.4, 1.5, 1.6}));
  EXPECT_THAT(said, HasSubstr("left: 5 of 17 pictures are missing"));
  EXPECT_THAT(said, HasSubstr("the longest gap is 0.5 s, from 0.8 s on"));
}

TEST(MissingPictures, AreNotToldWhereNothingIsEven) {
  EXPECT_EQ(missing_pictures("left", at({0, 0.1, 0.5, 0.6, 1.5, 1.9, 2.0, 4.0})), "");
}

}  // namespace
}  // namespace panoptes
