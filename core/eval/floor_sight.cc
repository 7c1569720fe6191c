// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/floor_sight.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/base/check.h"
#include "core/eval/statistics.h"

namespace panoptes {
namespace {

constexpr double kMarch_m = 0.02;  // a strip of floor that is narrower may be passed over
constexpr double kResolution_m = 5e-4;
constexpr int kRingSteps = 180;

bool has(const RigSight& sight, CameraSet cameras, bool mapped, const Vec2& p_body) {
  for (std::size_t i = 0; i < sight.cameras().size(); ++i) {
    if ((cameras & camera_bit(i)) == 0) {
      continue;
    }
    const CameraSight& camera = sight.cameras()[i];
    if (mapped ? camera.maps(p_body) : camera.sees({p_body.x(), p_body.y(), 0})) {
      return true;
    }
  }
  return false;
}

/// Where a line first enters what `inside` says, from 0 on.
std::optional<double> entered_m(double most_m, const std::function<bool(double)>& inside) {
  for (double at_m = 0; at_m <= most_m; at_m += kMarch_m) {
    if (!inside(at_m)) {
      continue;
    }
    double low = std::max(0.0, at_m - kMarch_m);
    double high = at_m;
    while (high - low > kResolution_m) {
      const double middle = (low + high) / 2;
      (inside(middle) ? high : low) = middle;
    }
    return high;
  }
  return std::nullopt;
}

}  // namespace

Vec2 FloorSight::centre(int column, int row) const {
  return cell_m * Vec2(column - side / 2.0 + 0.5, row - side / 2.0 + 0.5);
}

FloorSight floor_sight(const FloorSightOptions& options, const RigSight& sight) {
  PANOPTES_CHECK(options.cell_m > 0 && options.reach_m > options.cell_m, "there is floor in reach");
  FloorSight out;
  out.cell_m = options.cell_m;
  out.side = 2 * static_cast<int>(std::ceil(options.reach_m / options.cell_m));
  const std::size_t cells = static_cast<std::size_t>(out.side) * static_cast<std::size_t>(out.side);
  out.seen.assign(cells, 0);
  out.mapped.assign(cells, 0);
  out.sampling_m.assign(cells, 0);
  out.floor.assign(cells, 0);
  std::size_t cell = 0;
  for (int row = 0; row < out.side; ++row) {
    for (int column = 0; column < out.side; ++column, ++cell) {
      const Vec2 p_body = out.centre(column, row);
      const double from_middle_m = p_body.norm();
      if (from_middle_m < sight.body().radius_m || from_middle_m > options.reach_m) {
        continue;
      }
      out.floor[cell] = 1;
      out.seen[cell] = sight.seeing({p_body.x(), p_body.y(), 0});
      out.mapped[cell] = sight.mapping(p_body) & out.seen[cell];
      for (std::size_t i = 0; i < sight.cameras().size(); ++i) {
        if ((out.seen[cell] & camera_bit(i)) != 0) {
          const auto sampling_m = static_cast<float>(sight.cameras()[i].sampling_m(p_body));
          float& finest_m = out.sampling_m[cell];
          finest_m = finest_m > 0 ? std::min(finest_m, sampling_m) : sampling_m;
        }
      }
    }
  }
  return out;
}

double area_m2(const FloorSight& floor, const std::vector<CameraSet>& sets, CameraSet cameras) {
  const auto cells =
      std::count_if(sets.begin(), sets.end(), [&](CameraSet set) { return (set & cameras) != 0; });
  return static_cast<double>(cells) * floor.cell_m * floor.cell_m;
}

double ring_share(const FloorSight& floor, const std::vector<CameraSet>& sets, CameraSet cameras,
                  double body_radius_m, double from_m, double to_m) {
  int inside = 0;
  int had = 0;
  std::size_t cell = 0;
  for (int row = 0; row < floor.side; ++row) {
    for (int column = 0; column < floor.side; ++column, ++cell) {
      const double distance_m = floor.centre(column, row).norm() - body_radius_m;
      if (floor.floor[cell] != 0 && distance_m >= from_m && distance_m < to_m) {
        ++inside;
        had += (sets[cell] & cameras) != 0 ? 1 : 0;
      }
    }
  }
  return inside > 0 ? static_cast<double>(had) / inside : 0.0;
}

SamplingAt sampling_at(const RigSight& sight, CameraSet cameras, bool mapped, double distance_m) {
  std::vector<double> finest;
  const double r = sight.body().radius_m + distance_m;
  for (int k = 0; k < kRingSteps; ++k) {
    const double angle = 2 * std::numbers::pi * k / kRingSteps;
    const Vec2 p_body = r * Vec2(std::cos(angle), std::sin(angle));
    double best = 0;
    for (std::size_t i = 0; i < sight.cameras().size(); ++i) {
      const CameraSight& camera = sight.cameras()[i];
      if ((cameras & camera_bit(i)) != 0 &&
          (mapped ? camera.maps(p_body) : camera.sees({p_body.x(), p_body.y(), 0}))) {
        const double sampling_m = camera.sampling_m(p_body);
        best = best > 0 ? std::min(best, sampling_m) : sampling_m;
      }
    }
    if (best > 0) {
      finest.push_back(best);
    }
  }
  SamplingAt out;
  out.distance_m = distance_m;
  out.seen_share = static_cast<double>(finest.size()) / kRingSteps;
  if (!finest.empty()) {
    out.median_m = quantile(finest, 0.5);
    out.worst_m = *std::max_element(finest.begin(), finest.end());
  }
  return out;
}

std::optional<double> first_seen_m(const RigSight& sight, CameraSet cameras, bool mapped,
                                   double heading_rad, double reach_m) {
  const Vec2 along(std::cos(heading_rad), std::sin(heading_rad));
  const double edge_m = sight.body().radius_m;
  return entered_m(reach_m - edge_m, [&](double at_m) {
    return has(sight, cameras, mapped, (edge_m + at_m) * along);
  });
}

std::optional<double> first_seen_over_width_m(const RigSight& sight, CameraSet cameras, bool mapped,
                                              double reach_m) {
  const double radius_m = sight.body().radius_m;
  constexpr int kLines = 11;
  double longest_m = 0;
  for (int i = 0; i < kLines; ++i) {
    const double y = radius_m * (2.0 * i / (kLines - 1) - 1);
    const auto first_m = entered_m(reach_m - radius_m, [&](double at_m) {
      return has(sight, cameras, mapped, {radius_m + at_m, y});
    });
    if (!first_m) {
      return std::nullopt;
    }
    longest_m = std::max(longest_m, *first_m);
  }
  return longest_m;
}

std::optional<double> last_seen_m(const RigSight& sight, CameraSet cameras, bool mapped,
                                  double reach_m) {
  const std::optional<double> first_m = first_seen_m(sight, cameras, mapped, 0, reach_m);
  if (!first_m) {
    return std::nullopt;
  }
  const double edge_m = sight.body().radius_m;
  const std::optional<double> lost_m =
      entered_m(reach_m - edge_m - *first_m, [&](double further_m) {
        return !has(sight, cameras, mapped, {edge_m + *first_m + further_m, 0});
      });
  return lost_m ? *first_m + *lost_m : reach_m - edge_m;
}

std::optional<double> smallest_obstacle_m(const RigSight& sight, double distance_m,
                                          double least_px) {
  const Vec2 foot(sight.body().radius_m + distance_m, 0);
  std::optional<double> smallest;
  for (const CameraSight& camera : sight.cameras()) {
    if (!camera.maps(foot)) {
      continue;
    }
    const Vec3 p_body(foot.x(), foot.y(), 0);
    const Vec3 sight_line = p_body - camera.eye_body();
    const Vec3 aside = Vec3(-sight_line.y(), sight_line.x(), 0).normalized();
    const Eigen::Matrix2d J = camera.px_per_m(p_body, aside, Vec3::UnitZ());
    const double size_m = least_px / std::min(J.col(0).norm(), J.col(1).norm());
    smallest = std::min(smallest.value_or(size_m), size_m);
  }
  return smallest;
}

BlindSpot blind_spot(const RigSight& sight, double height_m, double around_m, double reach_m) {
  const double radius_m = sight.body().radius_m;
  BlindSpot out;
  out.height_m = height_m;
  // rings of equal area, so that every place counts the same
  constexpr int kRings = 16;
  constexpr int kHeadings = 72;
  const double inner2 = radius_m * radius_m;
  const double outer2 = (radius_m + around_m) * (radius_m + around_m);
  int blind = 0;
  for (int ring = 0; ring < kRings; ++ring) {
    const double r = std::sqrt(inner2 + (ring + 0.5) / kRings * (outer2 - inner2));
    for (int k = 0; k < kHeadings; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.5) / kHeadings;
      blind += sight.seeing({r * std::cos(angle), r * std::sin(angle), height_m}) == 0 ? 1 : 0;
    }
  }
  out.share = static_cast<double>(blind) / (kRings * kHeadings);
  out.ahead_m = entered_m(reach_m - radius_m, [&](double at_m) {
    return sight.seeing({radius_m + at_m, 0, height_m}) != 0;
  });
  return out;
}

}  // namespace panoptes
