// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/recognition.h"

#include <algorithm>
#include <limits>

#include "core/base/check.h"

namespace panoptes {

PlaceTruth::PlaceTruth(int pictures)
    : size_(pictures),
      same_(static_cast<std::size_t>(pictures) * static_cast<std::size_t>(pictures),
            SamePlace::kNo) {}

std::size_t PlaceTruth::index(int a, int b) const {
  PANOPTES_CHECK(a >= 0 && b >= 0 && a < size_ && b < size_, "pictures of the run");
  return static_cast<std::size_t>(a) * static_cast<std::size_t>(size_) +
         static_cast<std::size_t>(b);
}

void PlaceTruth::set(int a, int b, SamePlace same) {
  same_[index(a, b)] = same;
  same_[index(b, a)] = same;
}

SamePlace PlaceTruth::at(int a, int b) const { return same_[index(a, b)]; }

bool PlaceTruth::is_revisit(int picture) const {
  bool been_away = false;
  for (int earlier = picture - 1; earlier >= 0; --earlier) {
    been_away = been_away || at(picture, earlier) == SamePlace::kNo;
    if (been_away && at(picture, earlier) == SamePlace::kYes) {
      return true;
    }
  }
  return false;
}

RecognitionFigures recognition_figures(const std::vector<PlaceAnswer>& answers,
                                       const PlaceTruth& truth) {
  PANOPTES_CHECK(static_cast<int>(answers.size()) == truth.size(), "an answer a picture");
  RecognitionFigures figures;
  double surest_wrong = -std::numeric_limits<double>::infinity();
  std::vector<double> right;
  for (int picture = 0; picture < truth.size(); ++picture) {
    const bool revisit = truth.is_revisit(picture);
    figures.revisits += revisit ? 1 : 0;
    const PlaceAnswer& answer = answers[picture];
    if (answer.earlier < 0) {
      continue;
    }
    const SamePlace same = truth.at(picture, answer.earlier);
    if (same == SamePlace::kNo) {
      surest_wrong = std::max(surest_wrong, answer.confidence);
      figures.wrong += answer.accepted ? 1 : 0;
    } else if (same == SamePlace::kYes && revisit) {
      right.push_back(answer.confidence);
      figures.right += answer.accepted ? 1 : 0;
    } else {
      figures.not_counted += answer.accepted ? 1 : 0;
    }
  }
  if (figures.right + figures.wrong > 0) {
    figures.precision = static_cast<double>(figures.right) / (figures.right + figures.wrong);
  }
  if (figures.revisits > 0) {
    const auto surer = std::count_if(right.begin(), right.end(),
                                     [&](double confidence) { return confidence > surest_wrong; });
    figures.recall = static_cast<double>(figures.right) / figures.revisits;
    figures.recall_at_full_precision = static_cast<double>(surer) / figures.revisits;
  }
  return figures;
}

}  // namespace panoptes
