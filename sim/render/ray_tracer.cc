// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/ray_tracer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <utility>

namespace panoptes::sim {
namespace {

constexpr std::size_t kBins = 16;
constexpr int kDeepest = 40;  // splits by area; below that by number, which halves
// Four million triangles take 22 more halvings; a node leaves three of its children to be visited.
constexpr std::size_t kStack = 3 * (kDeepest + 22) + 1;
constexpr float kEdge = 1e-5F;  // triangles reach that share over their edges: no ray slips through
constexpr float kWider = 1e-6F;   // boxes reach that share farther than roundoff takes from them
constexpr float kSteep = 1e-12F;  // less than this part of a direction is none

struct Box {
  std::array<float, 3> low{kFar, kFar, kFar};
  std::array<float, 3> high{-kFar, -kFar, -kFar};

  void add(const Box& other) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], other.low[i]);
      high[i] = std::max(high[i], other.high[i]);
    }
  }
  float area() const {
    const float x = high[0] - low[0];
    const float y = high[1] - low[1];
    const float z = high[2] - low[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
  }
  float middle(std::size_t axis) const { return 0.5F * (low[axis] + high[axis]); }

  static constexpr float kFar = std::numeric_limits<float>::infinity();
};

/// Whether any lane is set.
template <class LaneBits>
bool any(const LaneBits& lanes) {
  std::array<std::uint64_t, 2> halves{};
  static_assert(sizeof halves == sizeof lanes);
  std::memcpy(halves.data(), &lanes, sizeof lanes);
  return (halves[0] | halves[1]) != 0;
}

}  // namespace

struct RayTracer::Ray {
  std::array<float, 3> from;
  std::array<float, 3> direction;
  std::array<float, 3> inverse;
  float from_m;
  float reach_m;
};

class RayTracer::Builder {
 public:
  Builder(const std::vector<Corners>& triangles, RayTracer& out)
      : triangles_(triangles), out_(out) {
    parts_.reserve(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      Part part{{}, t};
      for (const Vec3& p : triangles[t]) {
        for (std::size_t i = 0; i < 3; ++i) {
          const auto x = static_cast<float>(p[static_cast<Eigen::Index>(i)]);
          part.box.low[i] = std::min(part.box.low[i], x);
          part.box.high[i] = std::max(part.box.high[i], x);
        }
      }
      parts_.push_back(part);
    }
    if (!parts_.empty()) {
      add_node({0, parts_.size()}, 0);
    }
  }

 private:
  struct Part {
    Box box;
    std::size_t triangle;
  };
  using Range = std::pair<std::size_t, std::size_t>;

  Box box_of(const Range& range) const {
    Box box;
    for (std::size_t i = range.first; i < range.second; ++i) {
      box.add(parts_[i].box);
    }
    return box;
  }

  std::int32_t add_node(const Range& range, int depth) {
    std::array<Range, kWide> ranges{range};
    std::size_t count = 1;
    while (count < kWide) {
      std::size_t largest = count;
      float most = -1;
      for (std::size_t i = 0; i < count; ++i) {
        const float weight =
            ranges[i].second - ranges[i].first > kWide ? box_of(ranges[i]).area() : -1;
        if (weight > most) {
          most = weight;
          largest = i;
        }
      }
      if (largest == count) {
        break;
      }
      const std::size_t middle = split(ranges[largest], depth);
      ranges[count] = {middle, ranges[largest].second};
      ranges[largest].second = middle;
      ++count;
    }
    const auto index = out_.nodes_.size();
    out_.nodes_.emplace_back();
    for (std::size_t i = 0; i < kWide; ++i) {
      const Box box = i < count ? box_of(ranges[i]) : Box{};  // an empty box meets no ray
      std::int32_t child = 0;
      if (i < count) {
        child = ranges[i].second - ranges[i].first > kWide ? add_node(ranges[i], depth + 1)
                                                           : add_leaf(ranges[i]);
      }
      Node& node = out_.nodes_[index];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node.bounds[2 * axis][i] = box.low[axis];
        node.bounds[2 * axis + 1][i] = box.high[axis];
      }
      node.children[i] = child;
    }
    return static_cast<std::int32_t>(index);
  }

  std::int32_t add_leaf(const Range& range) {
    Leaf leaf{};
    for (std::size_t i = range.first; i < range.second; ++i) {
      const Corners& p = triangles_[parts_[i].triangle];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<Eigen::Index>(axis);
        leaf.corner[axis][i - range.first] = static_cast<float>(p[0][a]);
        leaf.edge_1[axis][i - range.first] = static_cast<float>(p[1][a] - p[0][a]);
        leaf.edge_2[axis][i - range.first] = static_cast<float>(p[2][a] - p[0][a]);
      }
    }
    out_.leaves_.push_back(leaf);
    return ~static_cast<std::int32_t>(out_.leaves_.size() - 1);
  }

  /// Where the range is best cut in two, and sorts it so.
  std::size_t split(const Range& range, int depth) {
    Box middles;
    for (std::size_t i = range.first; i < range.second; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float m = parts_[i].box.middle(axis);
        middles.low[axis] = std::min(middles.low[axis], m);
        middles.high[axis] = std::max(middles.high[axis], m);
      }
    }
    float least = Box::kFar;
    std::size_t best_axis = 3;
    std::size_t best_bin = 0;
    for (std::size_t axis = 0; axis < 3 && depth < kDeepest; ++axis) {
      const auto [cost, bin] = cheapest(range, middles, axis);
      if (cost < least) {
        least = cost;
        best_axis = axis;
        best_bin = bin;
      }
    }
    const auto begin = parts_.begin() + static_cast<std::ptrdiff_t>(range.first);
    const auto end = parts_.begin() + static_cast<std::ptrdiff_t>(range.second);
    if (best_axis < 3) {
      const auto middle = std::stable_partition(begin, end, [&](const Part& part) {
        return bin_of(part, middles, best_axis) < best_bin;
      });
      return static_cast<std::size_t>(middle - parts_.begin());
    }
    std::size_t widest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis) {
      if (middles.high[axis] - middles.low[axis] > middles.high[widest] - middles.low[widest]) {
        widest = axis;
      }
    }
    std::sort(begin, end, [widest](const Part& a, const Part& b) {
      return std::pair(a.box.middle(widest), a.triangle) <
             std::pair(b.box.middle(widest), b.triangle);
    });
    return (range.first + range.second) / 2;
  }

  static std::size_t bin_of(const Part& part, const Box& middles, std::size_t axis) {
    const float share =
        (part.box.middle(axis) - middles.low[axis]) / (middles.high[axis] - middles.low[axis]);
    return std::min(kBins - 1, static_cast<std::size_t>(share * static_cast<float>(kBins)));
  }

  /// The least sum of area times number over cuts across an axis, and the first bin behind the cut.
  std::pair<float, std::size_t> cheapest(const Range& range, const Box& middles,
                                         std::size_t axis) const {
    if (!(middles.high[axis] > middles.low[axis])) {
      return {Box::kFar, 0};
    }
    std::array<Box, kBins> boxes{};
    std::array<float, kBins> numbers{};
    for (std::size_t i = range.first; i < range.second; ++i) {
      const std::size_t bin = bin_of(parts_[i], middles, axis);
      boxes[bin].add(parts_[i].box);
      numbers[bin] += 1;
    }
    std::array<float, kBins> behind{};
    Box box;
    float number = 0;
    for (std::size_t bin = kBins - 1; bin > 0; --bin) {
      box.add(boxes[bin]);
      number += numbers[bin];
      behind[bin] = number > 0 ? box.area() * number : Box::kFar;
    }
    std::pair<float, std::size_t> best{Box::kFar, 0};
    box = {};
    number = 0;
    for (std::size_t bin = 1; bin < kBins; ++bin) {
      box.add(boxes[bin - 1]);
      number += numbers[bin - 1];
      const float cost = number > 0 ? box.area() * number + behind[bin] : Box::kFar;
      if (cost < best.first) {
        best = {cost, bin};
      }
    }
    return best;
  }

  const std::vector<Corners>& triangles_;
  RayTracer& out_;
  std::vector<Part> parts_;
};

RayTracer::RayTracer(const std::vector<Corners>& triangles) { Builder(triangles, *this); }

/// Moeller and Trumbore 1997, four triangles at a time.
RayTracer::LaneBits RayTracer::meets(const Leaf& leaf, const Ray& ray, Lanes& distance,
                                     Lanes& facing) {
  const auto& d = ray.direction;
  const auto& e1 = leaf.edge_1;
  const auto& e2 = leaf.edge_2;
  const std::array<Lanes, 3> p{d[1] * e2[2] - d[2] * e2[1], d[2] * e2[0] - d[0] * e2[2],
                               d[0] * e2[1] - d[1] * e2[0]};
  facing = e1[0] * p[0] + e1[1] * p[1] + e1[2] * p[2];
  const Lanes inverse = 1.0F / facing;
  const std::array<Lanes, 3> s{ray.from[0] - leaf.corner[0], ray.from[1] - leaf.corner[1],
                               ray.from[2] - leaf.corner[2]};
  const Lanes u = (s[0] * p[0] + s[1] * p[1] + s[2] * p[2]) * inverse;
  const std::array<Lanes, 3> q{s[1] * e1[2] - s[2] * e1[1], s[2] * e1[0] - s[0] * e1[2],
                               s[0] * e1[1] - s[1] * e1[0]};
  const Lanes v = (d[0] * q[0] + d[1] * q[1] + d[2] * q[2]) * inverse;
  distance = (e2[0] * q[0] + e2[1] * q[1] + e2[2] * q[2]) * inverse;
  return (facing != 0.0F) & (u >= -kEdge) & (v >= -kEdge) & (u + v <= 1.0F + kEdge) &
         (distance > ray.from_m) & (distance < ray.reach_m);
}

template <bool kAny>
RayTracer::Hit RayTracer::walk(const Vec3& from, const Vec3& direction, double from_m,
                               double reach_m) const {
  Hit best;
  if (nodes_.empty()) {
    return best;
  }
  Ray ray{};
  std::array<std::size_t, 3> near{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    ray.from[i] = static_cast<float>(from[axis]);
    ray.direction[i] = static_cast<float>(direction[axis]);
    const float steep = std::max(std::abs(ray.direction[i]), kSteep);
    ray.inverse[i] = std::copysign(1.0F / steep, ray.direction[i]);
    near[i] = 2 * i + (std::signbit(ray.direction[i]) ? 1 : 0);
  }
  ray.from_m = static_cast<float>(from_m);
  ray.reach_m = static_cast<float>(reach_m);

  const auto larger = [](Lanes a, Lanes b) { return a > b ? a : b; };
  const auto smaller = [](Lanes a, Lanes b) { return a < b ? a : b; };
  struct Visit {
    std::int32_t child;
    float distance;
  };
  std::array<Visit, kStack> stack;  // NOLINT(cppcoreguidelines-pro-type-member-init): a hot path
  std::size_t height = 0;
  stack[height++] = {0, ray.from_m};
  while (height > 0) {
    const Visit visit = stack[--height];
    if (visit.distance >= ray.reach_m) {
      continue;
    }
    if (visit.child < 0) {
      Lanes distance;
      Lanes facing;
      const LaneBits met =
          meets(leaves_[static_cast<std::size_t>(~visit.child)], ray, distance, facing);
      if (!any(met)) {
        continue;
      }
      for (std::size_t i = 0; i < kWide; ++i) {
        if (met[i] != 0 && distance[i] < ray.reach_m) {
          ray.reach_m = distance[i];
          best = {distance[i], facing[i] < 0};
          if (kAny) {
            return best;
          }
        }
      }
      continue;
    }
    const Node& node = nodes_[static_cast<std::size_t>(visit.child)];
    Lanes enter = Lanes{} + ray.from_m;
    Lanes leave = Lanes{} + ray.reach_m;
    for (std::size_t i = 0; i < 3; ++i) {
      enter = larger((node.bounds[near[i]] - ray.from[i]) * ray.inverse[i], enter);
      leave = smaller((node.bounds[near[i] ^ 1U] - ray.from[i]) * ray.inverse[i], leave);
    }
    const LaneBits met = enter <= leave * (1.0F + kWider);
    if (!any(met)) {
      continue;
    }
    const std::size_t first = height;
    for (std::size_t i = 0; i < kWide; ++i) {
      if (met[i] == 0) {
        continue;
      }
      const Visit next{node.children[i], enter[i]};
      std::size_t place = height++;  // the nearest on top
      for (; !kAny && place > first && stack[place - 1].distance < next.distance; --place) {
        stack[place] = stack[place - 1];
      }
      stack[place] = next;
    }
  }
  return best;
}

RayTracer::Hit RayTracer::first_hit(const Vec3& from, const Vec3& direction, double from_m,
                                    double reach_m) const {
  return walk<false>(from, direction, from_m, reach_m);
}

bool RayTracer::blocked(const Vec3& from, const Vec3& direction, double from_m,
                        double reach_m) const {
  return walk<true>(from, direction, from_m, reach_m).distance_m <
         std::numeric_limits<double>::infinity();
}

}  // namespace panoptes::sim
