// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/lens_correction.h"

#include <optional>

#include <Eigen/Core>
#include <Eigen/QR>

namespace panoptes {
namespace {

constexpr int kStepsAcross = 16;  // each way over the picture: enough for what is as smooth as this

/// `pair_at` of pixels all over the picture, where it has something to say.
template <class PairAt>
std::vector<SeenDirection> all_over(const Intrinsics& picture, const PairAt& pair_at) {
  std::vector<SeenDirection> all;
  for (int row = 0; row <= kStepsAcross; ++row) {
    for (int column = 0; column <= kStepsAcross; ++column) {
      const Vec2 px(column * (picture.width_px - 1.0) / kStepsAcross,
                    row * (picture.height_px - 1.0) / kStepsAcross);
      if (const std::optional<SeenDirection> pair = pair_at(px)) {
        all.push_back(*pair);
      }
    }
  }
  return all;
}

}  // namespace

Intrinsics corrected(Intrinsics lens, const LensCorrection& by) {
  lens.fx_px *= 1 + by.focal_ratio;
  lens.fy_px *= 1 + by.focal_ratio;
  lens.cx_px += by.centre_px.x();
  lens.cy_px += by.centre_px.y();
  return lens;
}

LensCorrection fitted_correction(const Intrinsics& lens, const std::vector<SeenDirection>& seen) {
  if (seen.size() < 2) {
    return {};
  }
  const Vec2 centre_px(lens.cx_px, lens.cy_px);
  Eigen::MatrixXd A(2 * static_cast<Eigen::Index>(seen.size()), 3);
  Eigen::VectorXd b(A.rows());
  Eigen::Index row = 0;
  for (const SeenDirection& one : seen) {
    const Vec2 px = lens.project(one.direction);
    A.block<2, 1>(row, 0) = px - centre_px;
    A.block<2, 2>(row, 1).setIdentity();
    b.segment<2>(row) = one.px - px;
    row += 2;
  }
  const Vec3 x = A.colPivHouseholderQr().solve(b);
  return {x[0], x.tail<2>()};
}

LensCorrection of_lens(const LensCorrection& straight, const Intrinsics& pinhole,
                       const Intrinsics& lens) {
  const Intrinsics meant = corrected(pinhole, straight);
  return fitted_correction(
      lens, all_over(pinhole, [&](const Vec2& px) {
        return std::optional(SeenDirection{meant.ray(px), lens.project(pinhole.ray(px))});
      }));
}

LensCorrection straight_correction(const Intrinsics& pinhole, const Intrinsics& believed,
                                   const Intrinsics& truth) {
  return fitted_correction(pinhole,
                           all_over(pinhole, [&](const Vec2& px) -> std::optional<SeenDirection> {
                             const auto d = truth.direction(believed.project(pinhole.ray(px)));
                             if (!d || d->z() <= 0) {
                               return std::nullopt;
                             }
                             return SeenDirection{*d, px};
                           }));
}

}  // namespace panoptes
