// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/place_recogniser.h"

#include <algorithm>
#include <string>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/vision/grey.h"

namespace panoptes {

PlaceView place_view(const RecogniserOptions& options, const cv::Mat& picture) {
  cv::Mat grey = grey_of(picture);
  const int side_px = std::max(grey.cols, grey.rows);
  if (side_px > options.most_side_px) {
    const double scale = static_cast<double>(options.most_side_px) / side_px;
    cv::Mat smaller;
    cv::resize(grey, smaller, cv::Size(), scale, scale, cv::INTER_AREA);
    grey = smaller;
  }
  cv::Mat equalised;
  cv::equalizeHist(grey, equalised);
  PlaceView view;
  view.signature = place_signature(options.signature, equalised, equalised);
  view.features = local_features(options.features, grey);
  view.middle_px =
      0.5F * Eigen::Vector2f(static_cast<float>(grey.cols - 1), static_cast<float>(grey.rows - 1));
  view.content = picture_content(grey);
  return view;
}

PlaceRecogniser::PlaceRecogniser(const RecogniserOptions& options, const Rng& rng)
    : options_(options), rng_(rng) {}

void PlaceRecogniser::add(PlaceView view) { places_.push_back(std::move(view)); }

std::vector<PlaceCandidate> PlaceRecogniser::query(const PlaceView& view, int until) const {
  PANOPTES_CHECK(until <= size(), "places that are remembered");
  std::vector<PlaceCandidate> nearest;
  nearest.reserve(std::max(0, until));
  for (int place = 0; place < until; ++place) {
    nearest.push_back({place, emd_grey(view.signature, places_[place].signature)});
  }
  const auto kept = std::min<std::ptrdiff_t>(options_.shortlist, std::ssize(nearest));
  std::partial_sort(nearest.begin(), nearest.begin() + kept, nearest.end(),
                    [](const PlaceCandidate& a, const PlaceCandidate& b) {
                      return a.emd_grey != b.emd_grey ? a.emd_grey < b.emd_grey : a.place < b.place;
                    });
  nearest.resize(kept);
  for (PlaceCandidate& candidate : nearest) {
    candidate = compare(view, candidate.place);
  }
  return nearest;
}

PlaceCandidate PlaceRecogniser::compare(const PlaceView& view, int place) const {
  const PlaceView& earlier = this->place(place);
  std::vector<PixelPair> pairs;
  for (const FeatureMatch& match :
       match_features(options_.features, view.features, earlier.features)) {
    pairs.push_back({view.features.px[match.a] - view.middle_px,
                     earlier.features.px[match.b] - earlier.middle_px});
  }
  const LevelAgreement agreement =
      level_agreement(options_.motion, pairs, rng_.fork(std::to_string(place)));
  return {place, emd_grey(view.signature, earlier.signature), agreement.inliers,
          agreement.log_chance};
}

}  // namespace panoptes
