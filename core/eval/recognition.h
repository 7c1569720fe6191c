// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace panoptes {

enum class SamePlace : unsigned char { kNo, kNotCounted, kYes };

/// Which pictures of a run truly show one place.
class PlaceTruth {
 public:
  explicit PlaceTruth(int pictures);

  int size() const { return size_; }
  void set(int a, int b, SamePlace same);  ///< and b, a
  SamePlace at(int a, int b) const;

  /// Some earlier picture shows the same place, and one between them another.
  bool is_revisit(int picture) const;

 private:
  std::size_t index(int a, int b) const;

  int size_;
  std::vector<SamePlace> same_;
};

/// What a picture is said to show.
struct PlaceAnswer {
  int earlier = -1;  ///< -1: no place seen before
  double confidence = 0;
  bool accepted = false;
};

struct RecognitionFigures {
  int revisits = 0;
  int right = 0;  ///< of the answers that are accepted,
  int wrong = 0;
  int not_counted = 0;
  double precision = 1;
  double recall = 0;
  double recall_at_full_precision = 0;  ///< were those accepted that are surer than any wrong one
};

/// An answer for each picture against the truth. Where the truth does not count a pair, an answer
/// is neither right nor wrong, and neither is a right one where nothing was revisited.
RecognitionFigures recognition_figures(const std::vector<PlaceAnswer>& answers,
                                       const PlaceTruth& truth);

}  // namespace panoptes
