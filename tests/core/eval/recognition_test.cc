// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/recognition.h"

#include <gtest/gtest.h>

namespace panoptes {
namespace {

// Pictures 4 to 7 show what 0 to 3 do; neighbours are not counted.
PlaceTruth two_laps() {
  PlaceTruth truth(8);
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < i; ++j) {
      const int apart = (i - j) % 4;
      truth.set(i, j,
                apart == 0                 ? SamePlace::kYes
                : apart == 1 || apart == 3 ? SamePlace::kNotCounted
                                           : SamePlace::kNo);
    }
  }
  return truth;
}

TEST(Recognition, KnowsWhatIsARevisit) {
  const PlaceTruth truth = two_laps();
  for (int picture = 0; picture < 8; ++picture) {
    EXPECT_EQ(truth.is_revisit(picture), picture >= 4) << picture;
  }
  EXPECT_EQ(truth.at(4, 0), SamePlace::kYes);
  EXPECT_EQ(truth.at(0, 4), SamePlace::kYes);
}

TEST(Recognition, StayingIsNoRevisit) {
  PlaceTruth truth(3);
  truth.set(0, 1, SamePlace::kYes);
  truth.set(1, 2, SamePlace::kYes);
  truth.set(0, 2, SamePlace::kYes);
  for (int picture = 0; picture < 3; ++picture) {
    EXPECT_FALSE(truth.is_revisit(picture));
  }
}

TEST(Recognition, CountsWhatIsRightWrongAndNeither) {
  std::vector<PlaceAnswer> answers(8);
  answers[2] = {0, 1.5, true};   // wrong
  answers[4] = {0, 3, true};     // right
  answers[5] = {1, 2, true};     // right
  answers[6] = {3, 2, true};     // not counted
  answers[7] = {3, 1.2, false};  // right, not believed, less sure than the wrong one
  const RecognitionFigures figures = recognition_figures(answers, two_laps());
  EXPECT_EQ(figures.revisits, 4);
  EXPECT_EQ(figures.right, 2);
  EXPECT_EQ(figures.wrong, 1);
  EXPECT_EQ(figures.not_counted, 1);
  EXPECT_DOUBLE_EQ(figures.precision, 2.0 / 3);
  EXPECT_DOUBLE_EQ(figures.recall, 0.5);
  EXPECT_DOUBLE_EQ(figures.recall_at_full_precision, 0.5);
}

TEST(Recognition, ARightAnswerAsSureAsAWrongOneIsNoneAtFullPrecision) {
  std::vector<PlaceAnswer> answers(8);
  answers[2] = {0, 1, false};
  answers[4] = {0, 1, false};
  EXPECT_EQ(recognition_figures(answers, two_laps()).recall_at_full_precision, 0);
  answers[4].confidence = 1.1;
  EXPECT_EQ(recognition_figures(answers, two_laps()).recall_at_full_precision, 0.25);
}

TEST(Recognition, NothingSaidIsNothingWrong) {
  const RecognitionFigures figures = recognition_figures(std::vector<PlaceAnswer>(8), two_laps());
  EXPECT_EQ(figures.precision, 1);
  EXPECT_EQ(figures.recall, 0);
}

}  // namespace
}  // namespace panoptes
