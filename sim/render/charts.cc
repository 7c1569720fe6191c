// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "sim/render/lightmap.h"

namespace panoptes::sim {
namespace {

constexpr double kSame_m = 1e-4;             // corners closer than this are one
constexpr double kSamePlaneCosine = 0.9999;  // 0.8 degrees: flat to the eye
constexpr double kFlat_m = 2e-5;             // roundoff of meshes kept as floats
constexpr double kSameArea = 1e-4;
constexpr int kLeastColumns = 1024;  // of the lightmap
constexpr int kMostSide = 8192;      // of a lightmap that every OpenGL 4.5 takes
// A texel costs some 70 rays: a million of them are baked in about a minute on one core.
constexpr double kMostTexels = 1 << 20;
constexpr double kCoarser = 1.1;
// What spans less than this share of a cell is lit evenly.
constexpr double kEven = 0.5;

using Key = std::array<std::int64_t, 3>;
struct KeyHash {
  std::size_t operator()(const Key& key) const {
    std::uint64_t h = 0;
    for (const std::int64_t k : key) {
      h = (h ^ static_cast<std::uint64_t>(k)) * 0x9E3779B97F4A7C15ULL;
      h ^= h >> 32;
    }
    return h;
  }
};

/// The two corners of an edge, the smaller number first.
using Edge = std::pair<std::uint32_t, std::uint32_t>;

struct Flat {
  LitTriangle triangle;
  Vec3 normal;
  std::array<Edge, 3> edges;    ///< the i-th from corner i
  std::array<bool, 3> forward;  ///< whether it runs from the smaller number to the larger
};

std::vector<Flat> flats_of(const Object& object) {
  std::vector<Flat> flats;
  flats.reserve(object.triangles.size());
  std::unordered_map<Key, std::uint32_t, KeyHash> corners;
  const bool moves = object.kind != Object::Kind::kFixed;
  for (const Triangle& t : object.triangles) {
    Flat flat;
    std::array<std::uint32_t, 3> numbers{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 p = moves ? t.corners[i].p_object : object.T_scene_object * t.corners[i].p_object;
      flat.triangle.p[i] = p;
      flat.triangle.uv[i] = t.corners[i].uv;
      const Key key{std::llround(p.x() / kSame_m), std::llround(p.y() / kSame_m),
                    std::llround(p.z() / kSame_m)};
      numbers[i] =
          corners.try_emplace(key, static_cast<std::uint32_t>(corners.size())).first->second;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      flat.edges[i] = std::minmax(numbers[i], numbers[(i + 1) % 3]);
      flat.forward[i] = numbers[i] < numbers[(i + 1) % 3];
    }
    flat.triangle.texture = t.texture;
    const auto& p = flat.triangle.p;
    flat.normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    if (!flat.normal.isZero(0)) {  // a line cannot be seen
      flats.push_back(flat);
    }
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
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> by_edge;
  by_edge.reserve(2 * flats.size());
  for (std::size_t t = 0; t < flats.size(); ++t) {
    for (const Edge& edge : flats[t].edges) {
      // Different charts alone are kept: a thousand triangles on one edge are not compared
      // pairwise.
      std::vector<std::size_t>& there = by_edge[std::uint64_t{edge.first} << 32U | edge.second];
      std::size_t mine = root(t);
      bool is_there = false;
      for (std::size_t& other : there) {
        other = root(other);
        // Against the root's normal, so that a finely divided cylinder does not become one plane.
        if (flats[mine].normal.dot(flats[other].normal) > kSamePlaneCosine) {
          parent[std::max(mine, other)] = std::min(mine, other);
          mine = other = std::min(mine, other);
        }
        is_there = is_there || other == mine;
      }
      if (!is_there) {
        there.push_back(mine);
      }
    }
  }
  for (std::size_t t = 0; t < flats.size(); ++t) {
    parent[t] = root(t);
  }
  return parent;
}

/// Along the longest edge of its rim: a diagonal would waste half of the rectangle.
Vec3 longest_rim(const std::vector<const Flat*>& flats) {
  std::vector<Edge> edges;
  edges.reserve(3 * flats.size());
  for (const Flat* flat : flats) {
    edges.insert(edges.end(), flat->edges.begin(), flat->edges.end());
  }
  std::sort(edges.begin(), edges.end());
  Vec3 longest = flats[0]->triangle.p[1] - flats[0]->triangle.p[0];
  double longest_m = 0;
  for (const Flat* flat : flats) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& a = flat->triangle.p[i];
      const Vec3& b = flat->triangle.p[(i + 1) % 3];
      // By a clear margin, so that roundoff does not choose between equal edges.
      if ((b - a).norm() > 1.001 * longest_m) {
        const auto [first, end] = std::equal_range(edges.begin(), edges.end(), flat->edges[i]);
        if (end - first == 1) {
          longest = b - a;
          longest_m = longest.norm();
        }
      }
    }
  }
  return longest;
}

void lay_frame(Chart& chart, const Vec3& along) {
  chart.u = (along - chart.normal * chart.normal.dot(along)).normalized();
  chart.v = chart.normal.cross(chart.u);
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high = -low;
  for (const LitTriangle& t : chart.triangles) {
    for (const Vec3& p : t.p) {
      const Vec2 q(chart.u.dot(p), chart.v.dot(p));
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
  }
  chart.size_m = (high - low).cwiseMax(kSame_m);
  chart.origin = chart.u * low.x() + chart.v * low.y() +
                 chart.normal * chart.normal.dot(chart.triangles[0].p[0]);
}

/// Whether triangles that all face one way fill their chart's rectangle: what is not the rim of two
/// of them lies on the rectangle's own rim, so that all of its points are covered as often, and
/// the area says that this is once.
bool fills(const Chart& chart, const std::vector<const Flat*>& flats) {
  struct Side {
    Edge edge;
    int sign;
    Vec3 a;
    Vec3 b;
  };
  std::vector<Side> sides;
  sides.reserve(3 * flats.size());
  double area_m2 = 0;
  for (const Flat* flat : flats) {
    const auto& p = flat->triangle.p;
    area_m2 += 0.5 * chart.normal.dot((p[1] - p[0]).cross(p[2] - p[0]));
    for (std::size_t i = 0; i < 3; ++i) {
      sides.push_back({flat->edges[i], flat->forward[i] ? 1 : -1, p[i], p[(i + 1) % 3]});
    }
  }
  if (std::abs(area_m2 - chart.size_m.prod()) > kSameArea * chart.size_m.prod()) {
    return false;
  }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return a.edge < b.edge; });
  const auto on_rim = [&chart](const Side& side) {
    const Vec3 from_a = side.a - chart.origin;
    const Vec3 from_b = side.b - chart.origin;
    const auto on_line = [](double a, double b, double at) {
      return std::abs(a - at) < kFlat_m && std::abs(b - at) < kFlat_m;
    };
    const double ua = chart.u.dot(from_a);
    const double ub = chart.u.dot(from_b);
    const double va = chart.v.dot(from_a);
    const double vb = chart.v.dot(from_b);
    return on_line(ua, ub, 0) || on_line(ua, ub, chart.size_m.x()) || on_line(va, vb, 0) ||
           on_line(va, vb, chart.size_m.y());
  };
  for (std::size_t i = 0; i < sides.size();) {
    int net = 0;
    std::size_t end = i;
    for (; end < sides.size() && sides[end].edge == sides[i].edge; ++end) {
      net += sides[end].sign;
    }
    if (net != 0 && !on_rim(sides[i])) {
      return false;
    }
    i = end;
  }
  return true;
}

bool is_flat(const Chart& chart) {
  for (const LitTriangle& t : chart.triangles) {
    for (const Vec3& p : t.p) {
      if (std::abs(chart.normal.dot(p - chart.origin)) > kFlat_m) {
        return false;
      }
    }
  }
  return true;
}

int texels_along(double size_m, double cell_m) {
  return size_m < kEven * cell_m
             ? 1
             : static_cast<int>(std::min(std::ceil(size_m / cell_m - 1e-6) + 1.0, 1.0 * kMostSide));
}

/// As fine as asked for, or as the number of texels allows.
double affordable_cell(const std::vector<Chart>& charts, double cell_m) {
  const auto texels = [&charts](double cell) {
    double sum = 0;
    for (const Chart& chart : charts) {
      sum += 1.0 * texels_along(chart.size_m.x(), cell) * texels_along(chart.size_m.y(), cell);
    }
    return sum;
  };
  // Every chart has one at least; those are more than fit only where triangles are millions.
  const double most = std::max(kMostTexels, 2.0 * static_cast<double>(charts.size()));
  while (texels(cell_m) > most) {
    cell_m *= kCoarser;
  }
  return cell_m;
}

/// Shelves of falling height, filled from the left; what may move in shelves of its own, object by
/// object.
void pack(Charts& all) {
  std::vector<std::size_t> order(all.charts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto shelf_order = [&](std::size_t i) {
    const Chart& chart = all.charts[i];
    return std::make_tuple(chart.moves ? chart.object + 1 : 0, -chart.rows, -chart.columns, i);
  };
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return shelf_order(a) < shelf_order(b); });
  double texels = 0;
  all.columns = kLeastColumns;
  for (const Chart& chart : all.charts) {
    texels += 1.0 * chart.columns * chart.rows;
    while (all.columns < chart.columns) {
      all.columns *= 2;
    }
  }
  while (all.columns < kMostSide && texels > 2.0 * all.columns * all.columns) {
    all.columns *= 2;
  }
  int column = 0;
  int row = 0;
  int shelf_rows = 0;
  std::size_t shelf_of = 0;
  for (const std::size_t i : order) {
    Chart& chart = all.charts[i];
    const std::size_t mover = chart.moves ? chart.object + 1 : 0;
    if (column + chart.columns > all.columns || mover != shelf_of) {
      row += shelf_rows;
      column = shelf_rows = 0;
      shelf_of = mover;
    }
    chart.column = column;
    chart.row = row;
    column += chart.columns;
    shelf_rows = std::max(shelf_rows, chart.rows);
  }
  all.rows = row + shelf_rows;
}

void add_charts(const World& world, bool moving, std::vector<Chart>& charts) {
  for (std::size_t o = 0; o < world.objects.size(); ++o) {
    const Object& object = world.objects[o];
    if ((object.kind != Object::Kind::kFixed) != moving) {
      continue;
    }
    const std::vector<Flat> flats = flats_of(object);
    const std::vector<std::size_t> roots = chart_roots(flats);
    std::vector<std::vector<const Flat*>> parts;
    std::vector<std::size_t> part_of(flats.size());
    for (std::size_t t = 0; t < flats.size(); ++t) {
      if (roots[t] == t) {  // a root comes before the others of its chart
        part_of[t] = parts.size();
        parts.emplace_back();
      }
      parts[part_of[roots[t]]].push_back(&flats[t]);
    }
    for (const std::vector<const Flat*>& part : parts) {
      Chart& chart = charts.emplace_back();
      chart.object = o;
      chart.moves = moving;
      chart.normal = part[0]->normal;
      chart.triangles.reserve(part.size());
      for (const Flat* flat : part) {
        chart.triangles.push_back(flat->triangle);
      }
      lay_frame(chart, longest_rim(part));
      chart.flat = is_flat(chart);
      chart.full = chart.flat && fills(chart, part);
    }
  }
}

}  // namespace

Vec3 Chart::point(double column_of_chart, double row_of_chart) const {
  const double x = columns > 1 ? column_of_chart / (columns - 1) : 0.5;
  const double y = rows > 1 ? row_of_chart / (rows - 1) : 0.5;
  return origin + u * (x * size_m.x()) + v * (y * size_m.y());
}

Charts make_charts(const World& world, double cell_m) {
  Charts all;
  add_charts(world, false, all.charts);
  add_charts(world, true, all.charts);
  all.cell_m = affordable_cell(all.charts, cell_m);
  for (Chart& chart : all.charts) {
    chart.columns = texels_along(chart.size_m.x(), all.cell_m);
    chart.rows = texels_along(chart.size_m.y(), all.cell_m);
  }
  pack(all);
  for (Chart& chart : all.charts) {
    const Vec2 texels_per_m((chart.columns - 1) / chart.size_m.x(),
                            (chart.rows - 1) / chart.size_m.y());
    for (LitTriangle& t : chart.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 p = t.p[i] - chart.origin;
        t.texel[i] = Vec2(chart.column, chart.row) +
                     Vec2(chart.u.dot(p), chart.v.dot(p)).cwiseProduct(texels_per_m);
      }
    }
  }
  return all;
}

}  // namespace panoptes::sim
