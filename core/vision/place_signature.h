// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/camera/loop_cameras.h"
#include "core/config/fields.h"

namespace panoptes {

/// What is counted in a signature.
enum class SignatureMethod {
  kGrid,   ///< the greys of each of eight cells of each picture, in 16 bins
  kMosaic  ///< the thesis's own (6.3.2): the greys of both pictures together
};

struct SignatureOptions {
  SignatureMethod method = SignatureMethod::kGrid;
  bool subtract_mean = true;  ///< a change of brightness by c grey levels would cost c otherwise
};
void bind(Fields& f, SignatureOptions& o);

/// A coarse descriptor of a place: cumulative grey histograms of its pictures.
struct PlaceSignature {
  /// The share of pixels up to each grey level of all pictures together; or, of a grid, picture by
  /// picture, up to the end of each bin in each cell: four columns by two rows, row by row.
  std::vector<float> cumulative;
  bool grid = false;
};

/// How many shares a signature of so many pictures has.
std::size_t signature_shares(bool grid, std::size_t pictures);

/// From 8-bit pictures, BGR or grey, in the order of the loop cameras.
PlaceSignature place_signature(const SignatureOptions& options,
                               const std::vector<cv::Mat>& pictures);

/// Earth mover's distance in grey levels, the mean over the cells of a grid: in one dimension the
/// L1 distance of the cumulatives. Each picture is compared with itself.
double emd_grey(const PlaceSignature& a, const PlaceSignature& b);

/// The same between pictures that show the same in this facing, `b` being now; of one that has
/// turned about its axis all cells together. A mosaic is the same in every facing.
double emd_grey(const PlaceSignature& a, const PlaceSignature& b, const Facing& facing);

}  // namespace panoptes
