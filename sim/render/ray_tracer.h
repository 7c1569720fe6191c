// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/geometry/pose3.h"

namespace panoptes::sim {

/// Triangles to cast rays against: a tree of boxes, four at a time (Wald 2007's binned splits). In
/// plain IEEE arithmetic, so that every processor finds the same hits; a library that asks the
/// processor what it can do would not.
class RayTracer {
 public:
  /// The corners of a triangle, counter-clockwise from its front.
  using Corners = std::array<Vec3, 3>;

  explicit RayTracer(const std::vector<Corners>& triangles);

  struct Hit {
    double distance_m = std::numeric_limits<double>::infinity();
    bool back = false;  ///< the ray came from behind
  };

  /// The nearest triangle between `from_m` and `reach_m` along a direction of unit length.
  Hit first_hit(const Vec3& from, const Vec3& direction, double from_m, double reach_m) const;

  /// Whether there is one.
  bool blocked(const Vec3& from, const Vec3& direction, double from_m, double reach_m) const;

 private:
  static constexpr std::size_t kWide = 4;
  using Lanes = float __attribute__((vector_size(16)));
  using LaneBits = std::int32_t __attribute__((vector_size(16)));

  struct Node {
    std::array<Lanes, 6> bounds;               ///< low and high x, y, z of four boxes
    std::array<std::int32_t, kWide> children;  ///< a node, or the complement of a leaf
  };
  struct Leaf {
    std::array<Lanes, 3> corner;
    std::array<Lanes, 3> edge_1;
    std::array<Lanes, 3> edge_2;
  };
  struct Ray;
  class Builder;

  template <bool kAny>
  Hit walk(const Vec3& from, const Vec3& direction, double from_m, double reach_m) const;
  static LaneBits meets(const Leaf& leaf, const Ray& ray, Lanes& distance, Lanes& facing);

  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
};

}  // namespace panoptes::sim
