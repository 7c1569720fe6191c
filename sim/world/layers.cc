// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

// Corners closer than this are one, and a part may bulge inwards by this much and still count as
// convex: far above the roundoff of single-precision meshes, far below a cell.
constexpr double kSame_m = 1e-4;
// Strictly above or below a height: a part that ends on it, as the floor does, is not in the slice.
constexpr double kTouch_m = 1e-9;
// A cell that is reached into by less stays free: meshes are read in single precision.
constexpr double kSliver_m = 1e-6;
// What a face bounds lies behind it: of two cells whose common edge it runs along, in the hinder.
constexpr double kBehind_m = 3 * kSliver_m;

using SceneTriangle = std::array<Vec3, 3>;

class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) {
      i = parent_[i] = parent_[parent_[i]];
    }
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);  // the root is the first of the set
  }

 private:
  std::vector<std::size_t> parent_;
};

/// The triangles of each connected part, parts in the order of their first triangle.
std::vector<std::vector<SceneTriangle>> connected_parts(const Object& object) {
  std::vector<SceneTriangle> triangles;
  std::map<std::array<long long, 3>, std::size_t> first_at;
  Sets sets(object.triangles.size());
  for (const Triangle& t : object.triangles) {
    SceneTriangle scene;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& p = t.corners[i].p_object;
      scene[i] = object.T_scene_object * p;
      const std::array<long long, 3> key{std::llround(p.x() / kSame_m),
                                         std::llround(p.y() / kSame_m),
                                         std::llround(p.z() / kSame_m)};
      const auto [entry, is_new] = first_at.try_emplace(key, triangles.size());
      if (!is_new) {
        sets.join(entry->second, triangles.size());
      }
    }
    triangles.push_back(scene);
  }
  std::map<std::size_t, std::vector<SceneTriangle>> by_root;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    by_root[sets.root(i)].push_back(triangles[i]);
  }
  std::vector<std::vector<SceneTriangle>> parts;
  parts.reserve(by_root.size());
  for (auto& [root, part] : by_root) {
    parts.push_back(std::move(part));
  }
  return parts;
}

/// Points sorted into boxes within boxes, to ask quickly whether any lies in front of a plane.
class PointTree {
 public:
  explicit PointTree(std::vector<Vec3> points) : points_(std::move(points)) {
    build(0, points_.size());
  }

  bool any_beyond(const Vec3& normal, double offset_m) const {
    return any_beyond(0, 0, points_.size(), normal, offset_m);
  }

 private:
  static constexpr std::size_t kLeaf = 16;
  struct Box {
    Vec3 middle;
    Vec3 half;
    std::size_t second = 0;  ///< the box of the second half, in boxes_; the first comes next
  };

  std::size_t build(std::size_t begin, std::size_t end) {
    Vec3 low = points_[begin];
    Vec3 high = low;
    for (std::size_t i = begin; i < end; ++i) {
      low = low.cwiseMin(points_[i]);
      high = high.cwiseMax(points_[i]);
    }
    const std::size_t index = boxes_.size();
    boxes_.push_back({(low + high) / 2, (high - low) / 2, 0});
    if (end - begin > kLeaf) {
      Eigen::Index axis = 0;
      (high - low).maxCoeff(&axis);
      const std::size_t half = begin + (end - begin) / 2;
      const auto at = [this](std::size_t i) {
        return points_.begin() + static_cast<std::ptrdiff_t>(i);
      };
      std::nth_element(at(begin), at(half), at(end),
                       [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; });
      build(begin, half);
      boxes_[index].second = build(half, end);
    }
    return index;
  }

  bool any_beyond(std::size_t index, std::size_t begin, std::size_t end, const Vec3& normal,
                  double offset_m) const {
    const Box& box = boxes_[index];
    if (normal.dot(box.middle) + normal.cwiseAbs().dot(box.half) <= offset_m) {
      return false;
    }
    if (end - begin <= kLeaf) {
      return std::any_of(points_.begin() + static_cast<std::ptrdiff_t>(begin),
                         points_.begin() + static_cast<std::ptrdiff_t>(end),
                         [&](const Vec3& p) { return normal.dot(p) > offset_m; });
    }
    const std::size_t half = begin + (end - begin) / 2;
    return any_beyond(index + 1, begin, half, normal, offset_m) ||
           any_beyond(box.second, half, end, normal, offset_m);
  }

  std::vector<Vec3> points_;
  std::vector<Box> boxes_;
};

/// True when no corner lies in front of any face.
bool is_convex(const std::vector<SceneTriangle>& part) {
  std::vector<Vec3> points;
  points.reserve(3 * part.size());
  for (const SceneTriangle& face : part) {
    points.insert(points.end(), face.begin(), face.end());
  }
  const PointTree tree(std::move(points));
  return std::none_of(part.begin(), part.end(), [&tree](const SceneTriangle& face) {
    const Vec3 normal = (face[1] - face[0]).cross(face[2] - face[0]).normalized();
    return tree.any_beyond(normal, normal.dot(face[0]) + kSame_m);
  });
}

bool is_flat(const std::vector<SceneTriangle>& part) {
  const SceneTriangle& first = part.front();
  const Vec3 normal = (first[1] - first[0]).cross(first[2] - first[0]).normalized();
  return std::all_of(part.begin(), part.end(), [&](const SceneTriangle& triangle) {
    return std::all_of(triangle.begin(), triangle.end(), [&](const Vec3& p) {
      return std::abs(normal.dot(p - first[0])) <= kSame_m;
    });
  });
}

void move_behind(const SceneTriangle& face, std::vector<Vec2>& corners) {
  const Vec2 ahead = (face[1] - face[0]).cross(face[2] - face[0]).head<2>();
  if (ahead.norm() > 0) {
    for (Vec2& corner : corners) {
      corner -= kBehind_m * ahead.normalized();
    }
  }
}

/// Sutherland and Hodgman's clip at one height.
std::vector<Vec3> clipped(const std::vector<Vec3>& polygon, double z_m, bool keep_above) {
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& a = polygon[i];
    const Vec3& b = polygon[(i + 1) % polygon.size()];
    const double da = keep_above ? a.z() - z_m : z_m - a.z();
    const double db = keep_above ? b.z() - z_m : z_m - b.z();
    if (da >= 0) {
      kept.push_back(a);
    }
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      kept.push_back(a + (b - a) * (da / (da - db)));
    }
  }
  return kept;
}

std::vector<Vec2> slice_corners(const SceneTriangle& t, double z_low_m, double z_high_m) {
  const auto [low, high] = std::minmax_element(
      t.begin(), t.end(), [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); });
  if (high->z() <= z_low_m + kTouch_m || low->z() >= z_high_m - kTouch_m) {
    return {};
  }
  std::vector<Vec3> polygon = clipped({t.begin(), t.end()}, z_low_m, true);
  polygon = clipped(polygon, z_high_m, false);
  std::vector<Vec2> corners;
  corners.reserve(polygon.size());
  for (const Vec3& p : polygon) {
    corners.push_back(p.head<2>());
  }
  return corners;
}

double cross(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Andrew's monotone chain, counter-clockwise; corners that bend by less than a nanometre are left
/// out.
std::vector<Vec2> convex_hull(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(), [](const Vec2& a, const Vec2& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Vec2> hull;
  const auto add_chain = [&hull](auto begin, auto end) {
    const std::size_t start = hull.size();
    for (auto p = begin; p != end; ++p) {
      if (hull.size() > start && (*p - hull.back()).norm() < kTouch_m) {
        continue;
      }
      while (hull.size() >= start + 2) {
        const Vec2& a = hull[hull.size() - 2];
        if (cross(a, hull.back(), *p) > kTouch_m * (*p - a).norm()) {
          break;
        }
        hull.pop_back();
      }
      hull.push_back(*p);
    }
    hull.pop_back();  // the next chain begins with it
  };
  if (points.empty() || (points.front() - points.back()).norm() < kTouch_m) {
    return {};
  }
  add_chain(points.begin(), points.end());
  add_chain(points.rbegin(), points.rend());
  return hull;
}

struct Bounds {
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high = -low;

  void add(const Vec2& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
};

Bounds bounds_of(const World& world) {
  Bounds bounds;
  for (const Object& object : world.objects) {
    for (const Triangle& t : object.triangles) {
      for (const Corner& corner : t.corners) {
        bounds.add((object.T_scene_object * corner.p_object).head<2>());
      }
    }
    for (const Pillar& pillar : object.pillars) {
      for (const Vec2& p : pillar.corners_object) {
        bounds.add((object.T_scene_object * Vec3(p.x(), p.y(), 0)).head<2>());
      }
    }
  }
  return bounds;
}

/// How far a convex outline reaches along x between two heights of y; low above high where it is
/// not there.
std::pair<double, double> reach(const std::vector<Vec2>& outline, double y_low, double y_high) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const auto add = [&](double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  };
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2& a = outline[i];
    const Vec2& b = outline[(i + 1) % outline.size()];
    if (a.y() >= y_low && a.y() <= y_high) {
      add(a.x());
    }
    for (const double y : {y_low, y_high}) {
      if ((a.y() < y) != (b.y() < y)) {
        add(a.x() + (b.x() - a.x()) * ((y - a.y()) / (b.y() - a.y())));
      }
    }
  }
  return {low, high};
}

/// Sets the cells that an outline reaches into. Within a row of cells it is convex, so there they
/// follow each other.
void fill(const std::vector<Vec2>& outline, int first_column, int first_row, TruthLayer& layer) {
  const double cell_m = layer.cell_m;
  const auto cell_of = [cell_m](double x) { return static_cast<int>(std::floor(x / cell_m)); };
  Bounds bounds;
  for (const Vec2& corner : outline) {
    bounds.add(corner);
  }
  const double sliver_m = outline.size() == 2 ? 0 : kSliver_m;  // a sheet has no depth to lose
  const int last = std::min(cell_of(bounds.high.y() - sliver_m), first_row + layer.rows - 1);
  for (int row = std::max(cell_of(bounds.low.y() + sliver_m), first_row); row <= last; ++row) {
    const auto [low, high] = reach(outline, std::max(row * cell_m, bounds.low.y()) + sliver_m,
                                   std::min((row + 1) * cell_m, bounds.high.y()) - sliver_m);
    if (low > high) {
      continue;
    }
    const int from = std::max(cell_of(low + sliver_m) - first_column, 0);
    const int to = std::min(cell_of(high - sliver_m) - first_column, layer.columns - 1);
    if (from <= to) {
      std::fill_n(&layer(from, row - first_row), to + 1 - from, 1);
    }
  }
}

}  // namespace

std::vector<Outline> outlines(const World& world, double z_low_m, double z_high_m) {
  PANOPTES_CHECK(z_low_m < z_high_m, "a slice has its top above its bottom");
  std::vector<Outline> found;
  for (std::size_t index = 0; index < world.objects.size(); ++index) {
    const Object& object = world.objects[index];
    if (object.kind == Object::Kind::kPerson) {
      continue;
    }
    const auto add = [&](std::vector<Vec2> corners) {
      std::vector<Vec2> hull = convex_hull(std::move(corners));
      if (hull.size() >= 2) {
        found.push_back({object.name, std::move(hull), index});
      }
    };
    for (const Pillar& pillar : object.pillars) {
      const double z_m = object.T_scene_object.translation.z();
      if (z_m + pillar.high_m > z_low_m + kTouch_m && z_m + pillar.low_m < z_high_m - kTouch_m) {
        std::vector<Vec2> corners;
        for (const Vec2& p : pillar.corners_object) {
          corners.emplace_back(
              (object.T_scene_object * Vec3(p.x(), p.y(), pillar.low_m)).head<2>());
        }
        add(std::move(corners));
      }
    }
    if (!object.pillars.empty()) {
      continue;
    }
    for (const std::vector<SceneTriangle>& part : connected_parts(object)) {
      const bool whole = is_convex(part);
      const bool flat = whole && is_flat(part);
      std::vector<Vec2> corners;
      for (const SceneTriangle& triangle : part) {
        std::vector<Vec2> more = slice_corners(triangle, z_low_m, z_high_m);
        if (!whole || flat) {
          move_behind(triangle, more);
        }
        corners.insert(corners.end(), more.begin(), more.end());
        if (!whole) {
          add(std::move(corners));
          corners.clear();
        }
      }
      add(std::move(corners));
    }
  }
  return found;
}

TruthLayer occupancy(const World& world, double z_low_m, double z_high_m, double cell_m) {
  PANOPTES_CHECK(cell_m > 0, "a cell has a size");
  const auto [low, high] = bounds_of(world);
  TruthLayer layer;
  layer.cell_m = cell_m;
  if (!(low.x() <= high.x())) {
    return layer;
  }
  // On whole cells of `scene`, so that a wall on a round coordinate fills whole cells.
  const auto cell_of = [cell_m](double x) { return static_cast<int>(std::floor(x / cell_m)); };
  const int first_column = cell_of(low.x()) - 1;
  const int first_row = cell_of(low.y()) - 1;
  layer.origin = cell_m * Vec2(first_column, first_row);
  layer.assign(cell_of(high.x()) + 2 - first_column, cell_of(high.y()) + 2 - first_row);
  for (const Outline& outline : outlines(world, z_low_m, z_high_m)) {
    fill(outline.corners_scene, first_column, first_row, layer);
  }
  return layer;
}

double truth_cell_m(const World& world) {
  const auto [low, high] = bounds_of(world);
  const Vec2 size = (high - low).cwiseMax(0);
  for (const double cell_m : {0.01, 0.02, 0.05, 0.1}) {
    if (size.x() / cell_m * (size.y() / cell_m) <= kMostTruthCells) {
      return cell_m;
    }
  }
  return 0.2;
}

}  // namespace panoptes::sim
