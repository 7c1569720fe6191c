// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/place_signature.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/check.h"
#include "core/vision/grey.h"

namespace panoptes {
namespace {

constexpr int kLevels = 256;
constexpr double kMiddle_grey = 128;  // where the mean is moved to
constexpr int kColumns = 4;           // of a grid's cells in a picture,
constexpr int kRows = 2;
constexpr int kCells = kColumns * kRows;
// and their bins: as many numbers as a mosaic has levels, and one distance for both, since a bin is
// as many levels wide as there are cells to take the mean of
constexpr int kBins = kLevels / (2 * kCells);

using Counts = std::array<std::int64_t, kLevels>;

void count_greys(const cv::Mat& grey, Counts& count) {
  for (int row = 0; row < grey.rows; ++row) {
    const std::uint8_t* pixels = grey.ptr<std::uint8_t>(row);
    for (int column = 0; column < grey.cols; ++column) {
      ++count[pixels[column]];
    }
  }
}

cv::Mat cell_of(const cv::Mat& picture, int cell) {
  const int column = cell % kColumns;
  const int row = cell / kColumns;
  return picture(
      cv::Range(row * picture.rows / kRows, (row + 1) * picture.rows / kRows),
      cv::Range(column * picture.cols / kColumns, (column + 1) * picture.cols / kColumns));
}

// The cumulative shares of `bins` bins of equal width, every grey moved up by `shift`.
void accumulate(const Counts& count, double shift, int bins, float* cumulative) {
  std::int64_t total = 0;
  for (const std::int64_t of_level : count) {
    total += of_level;
  }
  std::array<double, kLevels> share{};
  const double width = static_cast<double>(kLevels) / bins;
  for (int grey = 0; grey < kLevels; ++grey) {
    // a fraction of a bin is split between two
    const double at = std::clamp((grey + shift + 0.5) / width - 0.5, 0.0, bins - 1.0);
    const int below = static_cast<int>(std::floor(at));
    const double above_share = at - below;
    const double mass = static_cast<double>(count[grey]) / static_cast<double>(total);
    share[below] += mass * (1 - above_share);
    share[std::min(below + 1, bins - 1)] += mass * above_share;
  }
  double up_to = 0;
  for (int bin = 0; bin < bins; ++bin) {
    up_to += share[bin];
    cumulative[bin] = static_cast<float>(up_to);
  }
}

}  // namespace

void bind(Fields& f, SignatureOptions& o) {
  f.word("method", o.method,
         {{"grid", SignatureMethod::kGrid}, {"mosaic", SignatureMethod::kMosaic}});
  f("subtract_mean", o.subtract_mean);
}

PlaceSignature place_signature(const SignatureOptions& options, const cv::Mat& front,
                               const cv::Mat& back) {
  const std::array<cv::Mat, 2> pictures{grey_of(front), grey_of(back)};
  PlaceSignature signature;
  signature.grid = options.method == SignatureMethod::kGrid;
  std::array<Counts, 2 * kCells> of_cell{};
  Counts of_all{};
  for (int cell = 0; cell < 2 * kCells; ++cell) {
    const cv::Mat& picture = pictures[static_cast<std::size_t>(cell / kCells)];
    PANOPTES_CHECK(picture.cols >= kColumns && picture.rows >= kRows, "a picture has cells");
    count_greys(cell_of(picture, cell % kCells), of_cell[cell]);
    for (int grey = 0; grey < kLevels; ++grey) {
      of_all[grey] += of_cell[cell][grey];
    }
  }
  std::int64_t total = 0;
  std::int64_t sum = 0;
  for (int grey = 0; grey < kLevels; ++grey) {
    total += of_all[grey];
    sum += grey * of_all[grey];
  }
  const double shift = options.subtract_mean
                           ? kMiddle_grey - static_cast<double>(sum) / static_cast<double>(total)
                           : 0;
  if (!signature.grid) {
    accumulate(of_all, shift, kLevels, signature.cumulative.data());
    return signature;
  }
  for (int cell = 0; cell < 2 * kCells; ++cell) {
    accumulate(of_cell[cell], shift, kBins, signature.cumulative.data() + cell * kBins);
  }
  return signature;
}

double emd_grey(const PlaceSignature& a, const PlaceSignature& b, bool opposite) {
  const int exchange = opposite && a.grid ? kLevels / 2 : 0;  // back's for front's
  // eight sums side by side, so that the order is fixed and yet runs in vector registers
  std::array<float, 8> sums{};
  for (int half = 0; half < kLevels; half += kLevels / 2) {
    const float* of_a = a.cumulative.data() + half;
    const float* of_b = b.cumulative.data() + (half ^ exchange);
    for (int i = 0; i < kLevels / 2; i += 8) {
      for (int lane = 0; lane < 8; ++lane) {
        sums[lane] += std::abs(of_a[i + lane] - of_b[i + lane]);
      }
    }
  }
  float total = 0;
  for (const float sum : sums) {
    total += sum;
  }
  return total;
}

}  // namespace panoptes
