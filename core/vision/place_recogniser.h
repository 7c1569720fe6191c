// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/base/rng.h"
#include "core/vision/level_motion.h"
#include "core/vision/local_features.h"
#include "core/vision/picture_content.h"
#include "core/vision/place_signature.h"

namespace panoptes {

struct RecogniserOptions {
  SignatureOptions signature;
  FeatureOptions features;
  LevelMotionOptions motion;
  int most_side_px = 640;  ///< larger pictures are shrunk to this
  int shortlist = 10;      ///< places whose features are compared, a query
};

/// What one picture of a place is remembered by.
struct PlaceView {
  PlaceSignature signature;
  LocalFeatures features;
  Eigen::Vector2f middle_px;
  PictureContent content;
};

/// From an 8-bit picture, BGR or grey. The signature is of equalised greys: another exposure does
/// not make another place.
PlaceView place_view(const RecogniserOptions& options, const cv::Mat& picture);

/// Parts of a picture, a bit each, of a grid over all of it.
using PictureParts = std::uint32_t;

/// The parts with features of their own.
PictureParts parts_with_features(const PlaceView& view);

/// A remembered place, compared with a view.
struct PlaceCandidate {
  int place = 0;
  double emd_grey = 0;
  int inliers = 0;        ///< matched features that agree with one motion of a level camera
  double log_chance = 0;  ///< ln of how often as many would by chance (LevelAgreement)
  /// Parts of the view, and of the place's picture, with features that agree and are at most a
  /// quarter of the picture from where the other has them.
  PictureParts again_in_view = 0;
  PictureParts again_in_place = 0;
};

/// Remembers places by one picture each, and says without any prior which a view is most like.
class PlaceRecogniser {
 public:
  PlaceRecogniser(const RecogniserOptions& options, const Rng& rng);

  void add(PlaceView view);
  int size() const { return static_cast<int>(places_.size()); }
  const PlaceView& place(int index) const { return places_.at(static_cast<std::size_t>(index)); }

  /// The places before `until` whose signatures are nearest, nearest first, with their features
  /// compared. Cost grows with `until` only by the signatures.
  std::vector<PlaceCandidate> query(const PlaceView& view, int until) const;

  PlaceCandidate compare(const PlaceView& view, int place) const;

 private:
  RecogniserOptions options_;
  Rng rng_;
  std::vector<PlaceView> places_;
};

}  // namespace panoptes
