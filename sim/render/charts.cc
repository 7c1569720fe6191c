// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "sim/render/lightmap.h"

namespace panoptes::sim {
namespace {

constexpr double kSame_m = 1e-4;             // corners closer than this are one
constexpr double kSamePlaneCosine = 0.9999;  // 0.8 degrees: flat to the eye
constexpr int kColumns = 1024;

using Key = std::array<long long, 3>;

Key key_of(const Vec3& p) {
  return {std::llround(p.x() / kSame_m), std::llround(p.y() / kSame_m),
          std::llround(p.z() / kSame_m)};
}

std::pair<Key, Key> edge_of(const Vec3& a, const Vec3& b) {
  const Key ka = key_of(a);
  const Key kb = key_of(b);
  return ka < kb ? std::pair(ka, kb) : std::pair(kb, ka);
}

struct Flat {
  LitTriangle triangle;
  Vec3 normal;
};

std::vector<Flat> flats_of(const Object& object) {
  std::vector<Flat> flats;
  for (const Triangle& t : object.triangles) {
    Flat flat;
    for (std::size_t i = 0; i < 3; ++i) {
      flat.triangle.p_scene[i] = object.T_scene_object * t.corners[i].p_object;
      flat.triangle.uv[i] = t.corners[i].uv;
    }
    flat.triangle.texture = t.texture;
    const auto& p = flat.triangle.p_scene;
    flat.normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    flats.push_back(flat);
  }
  return flats;
}

/// For each triangle the first one of its chart: those that share an edge and a plane.
std::vector<std::size_t> chart_roots(const std::vector<Flat>& flats) {
  std::vector<std::size_t> parent(flats.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&parent](std::size_t i) {
    while (parent[i] != i) {
      i = parent[i] = parent[parent[i]];
    }
    return i;
  };
  std::map<std::pair<Key, Key>, std::vector<std::size_t>> by_edge;
  for (std::size_t t = 0; t < flats.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& p = flats[t].triangle.p_scene;
      std::vector<std::size_t>& there = by_edge[edge_of(p[i], p[(i + 1) % 3])];
      for (const std::size_t other : there) {
        const std::size_t ra = root(t);
        const std::size_t rb = root(other);
        // Against the root's normal, so that a finely divided cylinder does not become one plane.
        if (flats[ra].normal.dot(flats[rb].normal) > kSamePlaneCosine) {
          parent[std::max(ra, rb)] = std::min(ra, rb);
        }
      }
      there.push_back(t);
    }
  }
  for (std::size_t t = 0; t < flats.size(); ++t) {
    parent[t] = root(t);
  }
  return parent;
}

void lay_frame(Chart& chart, double cell_m) {
  // Along the longest edge of its rim: a diagonal would waste half of the rectangle.
  std::map<std::pair<Key, Key>, int> uses;
  for (const LitTriangle& t : chart.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      ++uses[edge_of(t.p_scene[i], t.p_scene[(i + 1) % 3])];
    }
  }
  Vec3 longest = chart.triangles[0].p_scene[1] - chart.triangles[0].p_scene[0];
  double longest_m = 0;
  for (const LitTriangle& t : chart.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& a = t.p_scene[i];
      const Vec3& b = t.p_scene[(i + 1) % 3];
      // By a clear margin, so that roundoff does not choose between equal edges.
      if ((b - a).norm() > 1.001 * longest_m && uses[edge_of(a, b)] == 1) {
        longest = b - a;
        longest_m = longest.norm();
      }
    }
  }
  chart.u = (longest - chart.normal * chart.normal.dot(longest)).normalized();
  chart.v = chart.normal.cross(chart.u);
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high = -low;
  for (const LitTriangle& t : chart.triangles) {
    for (const Vec3& p : t.p_scene) {
      const Vec2 q(chart.u.dot(p), chart.v.dot(p));
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
  }
  chart.size_m = (high - low).cwiseMax(kSame_m);
  chart.origin_scene = chart.u * low.x() + chart.v * low.y() +
                       chart.normal * chart.normal.dot(chart.triangles[0].p_scene[0]);
  const auto count = [cell_m](double size_m) {
    return std::clamp(static_cast<int>(std::ceil(size_m / cell_m - 1e-6)) + 1, 2, kColumns);
  };
  chart.columns = count(chart.size_m.x());
  chart.rows = count(chart.size_m.y());
}

/// Shelves of falling height, filled from the left.
void pack(Charts& all) {
  std::vector<std::size_t> order(all.charts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const Chart& ca = all.charts[a];
    const Chart& cb = all.charts[b];
    return std::make_tuple(-ca.rows, -ca.columns, a) < std::make_tuple(-cb.rows, -cb.columns, b);
  });
  int column = 0;
  int row = 0;
  int shelf_rows = 0;
  for (const std::size_t i : order) {
    Chart& chart = all.charts[i];
    if (column + chart.columns > kColumns) {
      row += shelf_rows;
      column = shelf_rows = 0;
    }
    chart.column = column;
    chart.row = row;
    column += chart.columns;
    shelf_rows = std::max(shelf_rows, chart.rows);
  }
  all.columns = kColumns;
  all.rows = row + shelf_rows;
}

}  // namespace

Charts make_charts(const World& world, double cell_m) {
  Charts all;
  for (std::size_t o = 0; o < world.objects.size(); ++o) {
    const std::vector<Flat> flats = flats_of(world.objects[o]);
    const std::vector<std::size_t> roots = chart_roots(flats);
    std::map<std::size_t, std::size_t> chart_at;
    for (std::size_t t = 0; t < flats.size(); ++t) {
      const auto [entry, is_new] = chart_at.try_emplace(roots[t], all.charts.size());
      if (is_new) {
        all.charts.emplace_back();
        all.charts.back().object = static_cast<int>(o);
        all.charts.back().normal = flats[t].normal;
      }
      all.charts[entry->second].triangles.push_back(flats[t].triangle);
    }
  }
  for (Chart& chart : all.charts) {
    lay_frame(chart, cell_m);
  }
  pack(all);
  for (Chart& chart : all.charts) {
    const Vec2 texels_per_m((chart.columns - 1) / chart.size_m.x(),
                            (chart.rows - 1) / chart.size_m.y());
    for (LitTriangle& t : chart.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 p = t.p_scene[i] - chart.origin_scene;
        t.texel[i] = Vec2(chart.column, chart.row) +
                     Vec2(chart.u.dot(p), chart.v.dot(p)).cwiseProduct(texels_per_m);
      }
    }
  }
  return all;
}

}  // namespace panoptes::sim
