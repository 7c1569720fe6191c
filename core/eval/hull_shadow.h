// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "core/geometry/body.h"

namespace panoptes {

/// What a robot of any shape hides from one of its cameras: how far off the nearest face is in each
/// direction, on the sides of a cube about the optical centre. A shadow map (Williams, "Casting
/// curved shadows on curved surfaces", 1978) of a light that shines all around; a cell of it is
/// 0.35 degrees wide. Faces within 3 cm of the centre are taken for the camera's own housing.
class HullShadow {
 public:
  HullShadow(const std::vector<Face>& faces, const Vec3& eye_body);

  /// Whether a face stands between the two; both of its sides hide.
  bool hides(const Vec3& p_body) const;

 private:
  static constexpr int kSides = 6;
  static constexpr int kCells = 256;  // along an edge of the cube

  /// Across a side of the cube, between the tangents -1 and 1: where a cell lies.
  static constexpr double middle(int cell) { return (2 * cell + 1.0) / kCells - 1; }
  static constexpr double cell_at(double tangent) { return 0.5 * kCells * (tangent + 1); }

  static void draw(const Face& face, std::vector<float>& depths_m);

  Vec3 eye_body_;
  std::array<std::vector<float>, kSides> depths_m_;  ///< along each side's normal
};

/// Whether a camera would be inside of a robot whose faces enclose it, its own housing apart.
bool inside_hull(const std::vector<Face>& faces, const Vec3& eye_body);

}  // namespace panoptes
