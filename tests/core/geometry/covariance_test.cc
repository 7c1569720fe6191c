// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/covariance.h"

#include <limits>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

Mat3 diagonal(double x, double y, double theta) { return Vec3(x, y, theta).asDiagonal(); }

TEST(Covariance, SigmasAreCountedByTheCovariance) {
  constexpr double kRoundoff = 1e-12;
  EXPECT_NEAR(squared_sigmas({0.2, 0, 0.03}, diagonal(0.01, 1, 0.0001)), 4 + 9, kRoundoff);
  EXPECT_EQ(squared_sigmas(Vec3::Zero(), diagonal(1, 1, 1)), 0);
}

TEST(Covariance, WhatIsUnknownHasNoNumbersBesideTheDiagonal) {
  EXPECT_EQ(unknown_covariance()(0, 0), kInfinity);
  EXPECT_EQ(unknown_covariance()(0, 1), 0);
}

TEST(Covariance, NothingPassesAGateByWhatIsNotKnown) {
  Mat3 indefinite = diagonal(1, 1, 1);
  indefinite(0, 1) = indefinite(1, 0) = 2;
  for (const Mat3& covariance :
       {unknown_covariance(), diagonal(kNoNumber, 1, 1), diagonal(1, 1, kInfinity),
        diagonal(1, 1, 0), diagonal(1, 1, -1), indefinite, Mat3(Mat3::Identity() * kInfinity),
        diagonal(1, 1, 5e-324)}) {
    EXPECT_EQ(squared_sigmas({0.1, 0, 0}, covariance), kInfinity) << covariance;
    EXPECT_FALSE(inverse_of(covariance)) << covariance;
  }
  EXPECT_EQ(squared_sigmas({kNoNumber, 0, 0}, diagonal(1, 1, 1)), kInfinity);
}

}  // namespace
}  // namespace panoptes
