// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/run_recognition.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "tests/support/wall_pictures.h"

namespace panoptes {
namespace {

// Along the wall, and at each step how far from its beginning.
std::vector<PlaceView> views_at(const std::vector<int>& at_px, std::uint64_t seed) {
  std::vector<PlaceView> views;
  for (std::size_t i = 0; i < at_px.size(); ++i) {
    views.push_back(place_view({}, wall_picture(at_px[i], Rng(seed).fork(std::to_string(i)))));
  }
  return views;
}

std::vector<int> lap(int count, double step_px = kWallStep_px) {
  std::vector<int> at_px;
  for (int i = 0; i < count; ++i) {
    at_px.push_back(static_cast<int>(i * step_px));
  }
  return at_px;
}

std::vector<int> then(std::vector<int> first, const std::vector<int>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

int accepted(const RunRecognition& run) {
  return static_cast<int>(std::count_if(run.pictures.begin(), run.pictures.end(),
                                        [](const Recognised& one) { return one.accepted; }));
}

constexpr int kLap = 20;

TEST(RunRecognition, FindsEveryPlaceOfASecondLapWhateverItsSpeed) {
  for (const double speed : {0.6, 1.0, 1.7}) {
    const std::vector<int> at_px =
        then(lap(kLap), lap(static_cast<int>((kLap - 1) / speed), speed * kWallStep_px));
    const RunRecognition run = recognise_run({}, views_at(at_px, 1), Rng(1));
    for (int i = 0; i < kLap; ++i) {
      EXPECT_FALSE(run.pictures[i].accepted) << speed << " " << i;
    }
    for (std::size_t i = kLap; i < at_px.size(); ++i) {
      const Recognised& found = run.pictures[i];
      EXPECT_TRUE(found.accepted) << speed << " " << i;
      EXPECT_LE(std::abs(at_px[i] - at_px[found.earlier]), kWallStep_px) << speed << " " << i;
    }
  }
}

TEST(RunRecognition, FindsNothingOnOneLap) {
  EXPECT_EQ(accepted(recognise_run({}, views_at(lap(2 * kLap), 3), Rng(1))), 0);
}

// As of a row of cupboards: along another wall, half of each picture is as on the first lap.
TEST(RunRecognition, HalfOfAPictureSeenBeforeIsNoReturn) {
  constexpr int kElsewhere_px = 10000;
  std::vector<PlaceView> views = views_at(lap(kLap), 1);
  for (int i = 0; i < kLap; ++i) {
    const int at_px = i * kWallStep_px;
    const Rng rng = Rng(5).fork(std::to_string(i));
    cv::Mat picture = wall_picture(kElsewhere_px + at_px, rng);
    const cv::Rect half(0, 0, picture.cols / 2, picture.rows);
    wall_picture(at_px, rng)(half).copyTo(picture(half));
    views.push_back(place_view({}, picture));
  }
  EXPECT_EQ(accepted(recognise_run({}, std::move(views), Rng(1))), 0);
}

TEST(RunRecognition, StandingOrCreepingIsNoReturn) {
  const std::vector<int> standing(15, kLap * kWallStep_px);
  EXPECT_EQ(accepted(recognise_run({}, views_at(then(lap(kLap), standing), 1), Rng(1))), 0);
  EXPECT_EQ(accepted(recognise_run({}, views_at(lap(2 * kLap, kWallStep_px / 8.0), 1), Rng(1))), 0);
}

TEST(RunRecognition, LearnsHowFarPicturesOverlap) {
  const int usual = recognise_run({}, views_at(lap(kLap), 1), Rng(1)).horizon;
  const int dense =
      recognise_run({}, views_at(lap(2 * kLap, kWallStep_px / 2.0), 1), Rng(1)).horizon;
  EXPECT_GE(usual, 2);
  EXPECT_LE(usual, 5);
  EXPECT_GE(dense, 2 * usual - 2);
}

// What a camera takes that is covered, looks at a wall, into the sun, or is jolted.
cv::Mat showing_nothing(PictureFault fault, const cv::Mat& grey, Rng rng) {
  cv::Mat picture(grey.size(), CV_8U, cv::Scalar(fault == PictureFault::kDark ? 4 : 130));
  if (fault == PictureFault::kOverExposed) {
    grey.convertTo(picture, CV_8U, 10, 150);
  } else if (fault == PictureFault::kBlurred) {
    cv::GaussianBlur(grey, picture, cv::Size(), 6);
  }
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      auto& pixel = picture.at<std::uint8_t>(row, column);
      const double shade = fault == PictureFault::kBlank ? 0.1 * column : 0;
      pixel = cv::saturate_cast<std::uint8_t>(pixel + shade + rng.normal(0, 2));
    }
  }
  return picture;
}

TEST(RunRecognition, PicturesThatShowNothingChangeNothing) {
  const std::vector<int> at_px = then(lap(kLap), lap(kLap));
  const RunRecognition alone = recognise_run({}, views_at(at_px, 1), Rng(1));
  ASSERT_GE(accepted(alone), kLap - 1);
  for (const PictureFault fault : {PictureFault::kBlank, PictureFault::kDark,
                                   PictureFault::kOverExposed, PictureFault::kBlurred}) {
    for (const int every : {5}) {
      std::vector<PlaceView> views = views_at(at_px, 1);
      std::vector<int> at;  // in the mixture, of each that shows something
      std::vector<PlaceView> mixed;
      int nothing = 0;
      for (std::size_t i = 0; i < views.size(); ++i) {
        if (i % every == 3) {
          const cv::Mat grey = wall_picture(at_px[i], Rng(i));
          mixed.push_back(place_view({}, showing_nothing(fault, grey, Rng(i).fork("nothing"))));
          ++nothing;
        }
        at.push_back(static_cast<int>(mixed.size()));
        mixed.push_back(std::move(views[i]));
      }
      const RunRecognition run = recognise_run({}, mixed, Rng(1));
      EXPECT_EQ(run.threshold, alone.threshold);
      EXPECT_EQ(std::count_if(run.pictures.begin(), run.pictures.end(),
                              [fault](const Recognised& one) { return one.fault == fault; }),
                nothing)
          << static_cast<int>(fault);
      for (std::size_t i = 0; i < at.size(); ++i) {
        const Recognised& found = run.pictures[at[i]];
        EXPECT_EQ(found.fault, PictureFault::kNone);
        EXPECT_EQ(found.accepted, alone.pictures[i].accepted);
        const int earlier = alone.pictures[i].earlier;
        EXPECT_EQ(found.earlier, earlier < 0 ? -1 : at[earlier]);
      }
    }
  }
}

TEST(RunRecognition, ACoveredOrFrozenCameraRecognisesNothing) {
  std::vector<PlaceView> covered;
  const cv::Mat black(240, 320, CV_8U, cv::Scalar(3));
  for (int i = 0; i < kLap; ++i) {
    covered.push_back(place_view({}, black));
  }
  EXPECT_EQ(accepted(recognise_run({}, covered, Rng(1))), 0);
  const std::vector<PlaceView> frozen(kLap, place_view({}, wall_picture(0, Rng(1))));
  EXPECT_EQ(accepted(recognise_run({}, frozen, Rng(1))), 0);
}

TEST(RunRecognition, TooFewPicturesTeachNothing) {
  for (const int count : {0, 1, 2, 8}) {
    const RunRecognition run = recognise_run({}, views_at(lap(count), 1), Rng(1));
    EXPECT_FALSE(run.learned());
    EXPECT_EQ(accepted(run), 0);
    EXPECT_EQ(run.pictures.size(), static_cast<std::size_t>(count));
  }
}

TEST(RunRecognition, SaysTheSameAgain) {
  const std::vector<PlaceView> views = views_at(then(lap(kLap), lap(kLap)), 2);
  const RunRecognition a = recognise_run({}, views, Rng(1));
  const RunRecognition b = recognise_run({}, views, Rng(1));
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(a.pictures[i].earlier, b.pictures[i].earlier);
    EXPECT_EQ(a.pictures[i].confidence, b.pictures[i].confidence);
  }
}

TEST(PlaceRecogniser, FindsAPlaceAmongOthersWithoutAnyPrior) {
  PlaceRecogniser recogniser({}, Rng(1));
  for (PlaceView& view : views_at(lap(kLap), 1)) {
    recogniser.add(std::move(view));
  }
  const PlaceView again = place_view({}, wall_picture(10 * kWallStep_px, Rng(5)));
  const std::vector<PlaceCandidate> found = recogniser.query(again, recogniser.size());
  ASSERT_EQ(found.size(), static_cast<std::size_t>(RecogniserOptions().shortlist));
  const auto best = std::max_element(
      found.begin(), found.end(),
      [](const PlaceCandidate& a, const PlaceCandidate& b) { return a.inliers < b.inliers; });
  EXPECT_EQ(best->place, 10);
  EXPECT_TRUE(std::is_sorted(
      found.begin(), found.end(),
      [](const PlaceCandidate& a, const PlaceCandidate& b) { return a.emd_grey < b.emd_grey; }));
  EXPECT_EQ(recogniser.query(again, 4).size(), 4U);
  EXPECT_TRUE(recogniser.query(again, 0).empty());
}

TEST(PlaceView, IsOfAnySize) {
  const cv::Mat small = wall_picture(0, Rng(1));
  cv::Mat large;
  cv::resize(small, large, cv::Size(), 4, 4, cv::INTER_CUBIC);
  const PlaceView view = place_view({}, large);
  EXPECT_EQ(view.middle_px, Eigen::Vector2f(319.5F, 239.5F));
  EXPECT_FALSE(view.features.px.empty());
}

}  // namespace
}  // namespace panoptes
