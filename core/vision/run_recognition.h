// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "core/base/rng.h"
#include "core/vision/place_recogniser.h"

namespace panoptes {

/// What a picture of a run was found to show.
struct Recognised {
  int earlier = -1;       ///< the most likely picture of the same place; -1 where none is likely
  double emd_grey = 0;    ///< to it
  int inliers = 0;        ///< with it
  int support = 0;        ///< inliers of the pictures before and after with those about `earlier`
  double seen_again = 0;  ///< the share of each picture that the other shows too, the least of both
  double confidence = 0;  ///< 1 and more is accepted
  bool accepted = false;
  PictureFault fault = PictureFault::kNone;  ///< why it shows nothing, and is compared with nothing
};

struct RunRecognition {
  std::vector<Recognised> pictures;
  int horizon = 0;       ///< pictures so few apart may show the same things without coming back
  double threshold = 0;  ///< inliers, and with support, that pictures of different places
  double threshold_support = 0;  ///< do not reach; infinite where too few pictures tell

  bool learned() const;
};

/// Finds for each picture of one camera an earlier one of the same place and heading, without
/// odometry or calibration: shortlist by signature, then matched features that agree with one
/// motion; the pictures before and after lend support, at any relative speed between a half and
/// two. What pictures of different places reach is learned from pictures so far apart that they
/// hardly overlap and so close in time that the robot cannot have come back; what they reach once
/// in a hundred runs is accepted, unless the pictures' own features, matched at random among
/// themselves, would agree as well that often: repeated texture has many that do. And each must
/// show most of the other again: one cupboard of a row, or things seen from farther off, agree as
/// well as the same place does, but not all over the picture. Pictures that
/// show nothing (picture_faults) are left out first, as if they had not been taken. `progress`
/// hears the share done.
RunRecognition recognise_run(const RecogniserOptions& options, std::vector<PlaceView> views,
                             const Rng& rng, const std::function<void(double)>& progress = {});

}  // namespace panoptes
