// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/place_recogniser.h"

#include <algorithm>
#include <string>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/vision/grey.h"

namespace panoptes {
namespace {

// As coarse as a few features a part allow.
constexpr int kPartsAcross = 6;
constexpr int kPartsDown = 4;
constexpr float kMoved = 0.25F;  // of the picture's width and height

PictureParts part_at(const PlaceView& view, const Eigen::Vector2f& px) {
  const auto cell = [](float at_px, float middle_px, int count) {
    const float share = at_px / (2 * middle_px + 1);
    return std::clamp(static_cast<int>(share * static_cast<float>(count)), 0, count - 1);
  };
  const int column = cell(px.x(), view.middle_px.x(), kPartsAcross);
  const int row = cell(px.y(), view.middle_px.y(), kPartsDown);
  return PictureParts{1} << static_cast<unsigned>(row * kPartsAcross + column);
}

}  // namespace

PictureParts parts_with_features(const PlaceView& view) {
  PictureParts parts = 0;
  for (const Eigen::Vector2f& px : view.features.px) {
    parts |= part_at(view, px);
  }
  return parts;
}

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
  view.signature = place_signature(options.signature, {equalised});
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
  const std::vector<FeatureMatch> matches =
      match_features(options_.features, view.features, earlier.features);
  std::vector<PixelPair> pairs;
  pairs.reserve(matches.size());
  for (const FeatureMatch& match : matches) {
    pairs.push_back({view.features.px[match.a] - view.middle_px,
                     earlier.features.px[match.b] - earlier.middle_px});
  }
  const LevelAgreement agreement =
      level_agreement(options_.motion, pairs, rng_.fork(std::to_string(place)));
  PlaceCandidate candidate{place, emd_grey(view.signature, earlier.signature), agreement.inliers,
                           agreement.log_chance};
  for (const int i : agreement.agreeing) {
    const Eigen::Array2f moved_px = (pairs[i].a_px - pairs[i].b_px).array().abs();
    if ((moved_px <= kMoved * 2 * view.middle_px.array()).all()) {
      candidate.again_in_view |= part_at(view, view.features.px[matches[i].a]);
      candidate.again_in_place |= part_at(earlier, earlier.features.px[matches[i].b]);
    }
  }
  return candidate;
}

}  // namespace panoptes
