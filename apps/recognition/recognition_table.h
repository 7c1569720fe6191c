// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "apps/recognition/recognition_study.h"

namespace panoptes {

/// Ways to tell places apart as they did in one world, or some runs of it taken together.
struct RecognitionWorld {
  std::string name;
  std::vector<RecognitionRow> rows;
};

/// Adds the counts of another run of the same combinations; of others it takes the rows over.
void add_rows(RecognitionWorld& world, const std::vector<RecognitionRow>& rows);

/// A line for each combination, the best mean recall over the worlds first, its cells aligned: for
/// each world the recall of keyframes, then of revisits of the same and of the opposite heading, in
/// percent.
std::vector<std::string> recognition_table(const std::vector<RecognitionWorld>& worlds);

/// The recalls as fields of a map: a panel a world, a column a distance, a row a histogram of some
/// pictures. 8-bit BGR.
cv::Mat draw_recognition_table(const std::vector<RecognitionWorld>& worlds);

}  // namespace panoptes
