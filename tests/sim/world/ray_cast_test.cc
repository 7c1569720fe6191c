// SPDX-License-Identifier: BSD-3-Clause
// The true map against one found another way: by rays through the triangles themselves.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/world/layers.h"
#include "sim/world/load.h"

namespace panoptes::sim {
namespace {

constexpr double kMast_m = 0.8;
constexpr double kHeightStep_m = 0.05;
constexpr double kEnds_m = 1e-6;  // rays keep this far from ends and edges of things

/// Where a ray at one height meets a triangle, and whether it goes in or comes out there.
struct Crossing {
  double at_m = 0;
  int inwards = 0;
};

/// Marks the cells that lie in something, or on its surface, by level rays along both axes through
/// every row and column of cells: five to each, the outermost along its edges.
class RayCast {
 public:
  explicit RayCast(const TruthLayer& like) : found_(like) {
    std::fill(found_.cells.begin(), found_.cells.end(), 0);
  }

  void add(const Object& object, double z_low_m, double z_high_m) {
    std::vector<std::array<Vec3, 3>> triangles;
    for (const Triangle& t : object.triangles) {
      std::array<Vec3, 3> p;
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = object.T_scene_object * t.corners[i].p_object;
      }
      triangles.push_back(p);
    }
    std::vector<double> heights{z_low_m + kEnds_m, z_high_m - kEnds_m};
    std::set<long> seen_um;  // above and below each corner, so that no board lies between two rays
    for (const std::array<Vec3, 3>& t : triangles) {
      for (const Vec3& p : t) {
        if (seen_um.insert(std::lround(1e6 * p.z())).second) {
          heights.push_back(p.z() - kEnds_m);
          heights.push_back(p.z() + kEnds_m);
        }
      }
    }
    std::erase_if(heights, [&](double z_m) { return z_m <= z_low_m || z_m >= z_high_m; });
    for (double z_m = z_low_m + kHeightStep_m / 2; z_m < z_high_m; z_m += kHeightStep_m) {
      heights.push_back(z_m);
    }
    drop(triangles, z_low_m + kEnds_m, z_high_m - kEnds_m);
    for (const double z_m : heights) {
      cast(triangles, z_m, 0);
      cast(triangles, z_m, 1);
    }
  }

  const TruthLayer& found() const { return found_; }

 private:
  static constexpr int kRays = 5;

  /// Plumb rays: they find what has a top and no side, as hidden sides are left out of meshes.
  void drop(const std::vector<std::array<Vec3, 3>>& triangles, double z_low_m, double z_high_m) {
    for (const std::array<Vec3, 3>& t : triangles) {
      const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
      if (std::abs(normal.z()) < 1e-6 * normal.norm()) {
        continue;
      }
      const auto ray_of = [&](double x, int axis) {
        return static_cast<int>((x - found_.origin[axis]) / found_.cell_m * kRays);
      };
      const auto [x0, x1] = std::minmax({t[0].x(), t[1].x(), t[2].x()});
      const auto [y0, y1] = std::minmax({t[0].y(), t[1].y(), t[2].y()});
      for (int i = std::max(ray_of(x0, 0) - 1, 0); i <= ray_of(x1, 0) + 1; ++i) {
        for (int j = std::max(ray_of(y0, 1) - 1, 0); j <= ray_of(y1, 1) + 1; ++j) {
          const Vec2 p(line_m(1, i), line_m(0, j));
          const auto side = [&](std::size_t k) {
            const Vec2 a = t[k].head<2>();
            const Vec2 b = t[(k + 1) % 3].head<2>();
            return (b - a).x() * (p - a).y() - (b - a).y() * (p - a).x();
          };
          const bool left = side(0) > 0 && side(1) > 0 && side(2) > 0;
          const bool right = side(0) < 0 && side(1) < 0 && side(2) < 0;
          const double z_m = t[0].z() - normal.head<2>().dot(p - t[0].head<2>()) / normal.z();
          if ((left || right) && z_m > z_low_m && z_m < z_high_m) {
            fill(p.x(), p.x(), 0, j / kRays);
          }
        }
      }
    }
  }

  int lines(int along) const { return along == 0 ? found_.rows : found_.columns; }
  double line_m(int along, int ray) const {  // where a ray runs, across itself
    const double in_cell = std::clamp((ray % kRays) / (kRays - 1.0), 1e-4, 1 - 1e-4);
    return found_.origin[1 - along] + found_.cell_m * (ray / kRays + in_cell);
  }

  void cast(const std::vector<std::array<Vec3, 3>>& triangles, double z_m, int along) {
    const int across = 1 - along;
    crossings_.assign(static_cast<std::size_t>(lines(along)) * kRays, {});
    for (const std::array<Vec3, 3>& t : triangles) {
      Vec2 cut[2];
      int cuts = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3& a = t[i];
        const Vec3& b = t[(i + 1) % 3];
        if ((a.z() < z_m) != (b.z() < z_m)) {
          cut[cuts++] = (a + (b - a) * ((z_m - a.z()) / (b.z() - a.z()))).head<2>();
        }
      }
      if (cuts != 2) {
        continue;
      }
      const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
      const int inwards = normal[along] < 0 ? 1 : -1;
      const auto [low, high] = std::minmax(cut[0][across], cut[1][across]);
      const double per_m = kRays / found_.cell_m;
      const double origin_m = found_.origin[across];
      const auto from = static_cast<int>(std::floor((low - origin_m) * per_m)) - 1;
      const auto to = static_cast<int>(std::ceil((high - origin_m) * per_m)) + 1;
      for (int ray = std::max(from, 0); ray <= std::min(to, lines(along) * kRays - 1); ++ray) {
        const double y = line_m(along, ray);
        if ((cut[0][across] < y) != (cut[1][across] < y)) {
          const double share = (y - cut[0][across]) / (cut[1][across] - cut[0][across]);
          crossings_[static_cast<std::size_t>(ray)].push_back(
              {cut[0][along] + share * (cut[1][along] - cut[0][along]), inwards});
        }
      }
    }
    for (std::size_t ray = 0; ray < crossings_.size(); ++ray) {
      mark(crossings_[ray], along, static_cast<int>(ray) / kRays);
    }
  }

  void mark(std::vector<Crossing>& crossings, int along, int line) {
    std::sort(crossings.begin(), crossings.end(),
              [](const Crossing& a, const Crossing& b) { return a.at_m < b.at_m; });
    int depth = 0;
    for (const Crossing& crossing : crossings) {
      depth += crossing.inwards;
    }
    const bool is_closed = depth == 0;
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      const double behind_m = crossings[i].at_m + crossings[i].inwards * kEnds_m;
      fill(behind_m, behind_m, along, line);
      depth += crossings[i].inwards;
      if (is_closed && depth > 0) {
        fill(crossings[i].at_m + kEnds_m, crossings[i + 1].at_m - kEnds_m, along, line);
      }
    }
  }

  void fill(double from_m, double to_m, int along, int line) {
    const auto cell = [&](double x) {
      return static_cast<int>(std::floor((x - found_.origin[along]) / found_.cell_m));
    };
    for (int i = cell(from_m); i <= cell(to_m); ++i) {
      const int column = along == 0 ? i : line;
      const int row = along == 0 ? line : i;
      if (column >= 0 && row >= 0 && column < found_.columns && row < found_.rows) {
        found_.cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(found_.columns) +
                     static_cast<std::size_t>(column)] = 1;
      }
    }
  }

  TruthLayer found_;
  std::vector<std::vector<Crossing>> crossings_;
};

/// Share of the cells that either has which both have.
double agreement(const TruthLayer& a, const TruthLayer& b) {
  std::size_t both = 0;
  std::size_t either = 0;
  for (std::size_t i = 0; i < a.cells.size(); ++i) {
    both += (a.cells[i] != 0 && b.cells[i] != 0) ? 1 : 0;
    either += (a.cells[i] != 0 || b.cells[i] != 0) ? 1 : 0;
  }
  return either == 0 ? 1 : static_cast<double>(both) / static_cast<double>(either);
}

double agreement_with_rays(const World& world, double z_low_m, double z_high_m, double cell_m) {
  const TruthLayer truth = occupancy(world, z_low_m, z_high_m, cell_m);
  RayCast rays(truth);
  for (const Object& object : world.objects) {
    if (object.kind != Object::Kind::kPerson) {
      rays.add(object, z_low_m, z_high_m);
    }
  }
  return agreement(truth, rays.found());
}

std::string scene(const char* name) {
  return std::string(PANOPTES_SOURCE_DIR "/scenes/worlds/") + name;
}

TEST(RayCastTruth, AgreesInTheOffice) {
  const World world = load_world(scene("office.yaml"));
  EXPECT_GE(agreement_with_rays(world, kFloorLayerTop_m, kMast_m, 0.02), 0.99);
  EXPECT_GE(agreement_with_rays(world, kFloorLayerTop_m, kMast_m, 0.05), 0.99);
}

TEST(RayCastTruth, AgreesUnderOverhangs) {
  const World world = load_world(scene("office-overhangs.yaml"));
  EXPECT_GE(agreement_with_rays(world, kFloorLayerTop_m, kMast_m, 0.05), 0.99);
}

TEST(RayCastTruth, AgreesInAGeneratedOffice) {
  WorldSettings settings;
  settings.generate = OfficePlan{.size_m = {12, 9}, .desks = 14, .overhangs = true, .seed = 5};
  EXPECT_GE(agreement_with_rays(make_world(settings), kFloorLayerTop_m, kMast_m, 0.02), 0.99);
}

}  // namespace
}  // namespace panoptes::sim
