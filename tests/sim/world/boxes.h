// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "sim/world/world.h"

namespace panoptes::sim {

/// A closed part with eight corners, the lower four and then the upper four, each counter-clockwise
/// from above. Each of its sides shows the whole texture.
inline std::vector<Triangle> hexahedron(const std::array<Vec3, 8>& p, int texture = 0) {
  constexpr std::array<std::array<std::size_t, 4>, 6> kSides{
      {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}, {4, 5, 6, 7}, {3, 2, 1, 0}}};
  std::vector<Triangle> triangles;
  for (const auto& side : kSides) {
    const Corner a{p[side[0]], {0, 1}};  // lower left, as seen from its front
    const Corner b{p[side[1]], {1, 1}};
    const Corner c{p[side[2]], {1, 0}};
    const Corner d{p[side[3]], {0, 0}};
    triangles.push_back({{a, b, c}, texture});
    triangles.push_back({{a, c, d}, texture});
  }
  return triangles;
}

inline std::vector<Triangle> box(const Vec3& low, const Vec3& high, int texture = 0) {
  std::array<Vec3, 8> p;
  for (std::size_t i = 0; i < 8; ++i) {
    const std::size_t k = i % 4;
    p[i] = Vec3(k == 1 || k == 2 ? high.x() : low.x(), k >= 2 ? high.y() : low.y(),
                i >= 4 ? high.z() : low.z());
  }
  return hexahedron(p, texture);
}

/// A floor of 10 x 10 m about the origin, its front upwards at z = 0.
inline std::vector<Triangle> floor_sheet(int texture = 0) {
  const Corner a{{-5, -5, 0}, {0, 1}};
  const Corner b{{5, -5, 0}, {1, 1}};
  const Corner c{{5, 5, 0}, {1, 0}};
  const Corner d{{-5, 5, 0}, {0, 0}};
  return {{{a, b, c}, texture}, {{a, c, d}, texture}};
}

}  // namespace panoptes::sim
