// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/camera/rig.h"

namespace panoptes {

/// By how much a lens is otherwise than it is believed to be, as far as its focal lengths and its
/// principal point can say it.
struct LensCorrection {
  double focal_ratio = 0;  ///< share of both focal lengths
  Vec2 centre_px = Vec2::Zero();
};

Intrinsics corrected(Intrinsics lens, const LensCorrection& by);

/// A direction and where a camera shows it.
struct SeenDirection {
  Vec3 direction;  ///< in the camera's frame
  Vec2 px = Vec2::Zero();
};

/// The correction with which `lens` shows these directions nearest to where they are seen: linear
/// least squares. Nothing is corrected by fewer than two of them.
LensCorrection fitted_correction(const Intrinsics& lens, const std::vector<SeenDirection>& seen);

/// What a correction found in straightened pictures, those of `pinhole`, is of the lens that they
/// were straightened by: fitted all over the picture. Of a pinhole it is the same. Of a lens that
/// bends strongly a shift of the one is not wholly a shift of the other: with 100 degrees of view a
/// quarter of it is left in places.
LensCorrection of_lens(const LensCorrection& straight, const Intrinsics& pinhole,
                       const Intrinsics& lens);

/// What shows in the pictures of `pinhole`, straightened as if the lens were the believed one, of
/// how the true one differs: fitted likewise.
LensCorrection straight_correction(const Intrinsics& pinhole, const Intrinsics& believed,
                                   const Intrinsics& truth);

}  // namespace panoptes
