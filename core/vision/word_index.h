// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/rng.h"
#include "core/camera/loop_cameras.h"
#include "core/vision/local_features.h"

namespace panoptes {

/// Remembers which typical descriptors, words, the pictures of each place have (Sivic and Zisserman
/// 2003; binary words as Galvez-Lopez and Tardos 2012), so that places are compared by what is to
/// be seen without comparing their features. The vocabulary is learned from the places themselves,
/// once they have enough descriptors and again whenever these have doubled, which enters all places
/// anew: that one call is as dear as all before it together. Until it is learned no place shares
/// anything with any.
class WordIndex {
 public:
  /// A place has so many pictures, one for each loop camera.
  WordIndex(int words, int cameras, Rng rng);

  /// The descriptors are shared, not copied, and must stay as they are.
  void add(const PlaceFeatures& features);

  int size() const { return static_cast<int>(descriptors_.size()) / cameras_; }

  /// For each place before `until` and each facing, how much of what `place` shows it shows as
  /// well, 0 to 1: the words both have, a rare one counting more, of the cameras that the facing
  /// pairs.
  std::vector<std::vector<double>> shared(int place, int until,
                                          const std::vector<Facing>& facings) const;

 private:
  struct Entry {
    int picture = 0;  ///< of each place as many as there are cameras
    int count = 0;    ///< of the word in it
  };

  void learn();
  void enter(int picture);

  int count_;
  int cameras_;
  Rng rng_;
  cv::Mat words_;                                  ///< a row a word, empty until learned
  std::vector<cv::Mat> descriptors_;               ///< of each picture
  std::vector<std::vector<std::uint16_t>> shown_;  ///< by each picture: a word a descriptor
  std::vector<std::vector<Entry>> pictures_with_;  ///< each word, in order
  int known_ = 0;                                  ///< descriptors
  int learned_ = 0;                                ///< descriptors known when last learned
};

}  // namespace panoptes
