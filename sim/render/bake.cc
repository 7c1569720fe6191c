// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "sim/render/lightmap.h"
#include "sim/render/ray_tracer.h"
#include "sim/render/renderer.h"

namespace panoptes::sim {
namespace {

constexpr int kAmbientRayBits = 6;
constexpr int kAmbientRays = 48;         // the first of 64 that are spread evenly
constexpr double kAmbientReach_m = 1.2;  // how far away a surface still takes ambient light
// What comes back from the surfaces that take the ambient light: white walls and grey carpet return
// about half, a part of it towards the point that lost it.
constexpr double kAmbientReturned = 0.2;
constexpr std::size_t kLightSide = 4;  // a light is sampled on a grid of 4 x 4
constexpr double kOff_m = 1e-3;        // rays start this far off their surface
constexpr double kLightBody_m = 0.05;  // what is that near to a light is the lamp itself
constexpr double kLampBrightness =
    1.4;                           // a little more than white: a lamp in a picture is overexposed
constexpr double kInset_m = 5e-3;  // corners are sampled this far inside
// A texel that sees more than this share of back faces lies inside of something that stands on it,
// or on its edge, from where half of them are seen.
constexpr double kInsideShare = 0.4;
constexpr double kNegligible = 2e-3;  // light below half a grey level in a lit room
constexpr double kSunReach_m = 1e4;   // nothing stands farther away

constexpr double kProbeSpacing_m = 0.5;
constexpr double kProbeFloor_m = 0.15;  // the lowest ones stand this high: shoes and chair legs
constexpr std::size_t kMostProbes = 8000;

constexpr int kItemTexels = 2048;     // what a thread takes at a time
constexpr int kProgressTexels = 512;  // how often the caller hears of it

/// Two unit vectors across a third.
std::pair<Vec3, Vec3> across(const Vec3& n) {
  const Vec3 helper = std::abs(n.z()) > 0.9 ? Vec3::UnitX() : Vec3::UnitZ();
  const Vec3 a = helper.cross(n).normalized();
  return {a, n.cross(a)};
}

struct Lamp {
  AreaLight light;
  std::size_t group;
  Vec3 normal;
  Vec3 side_u;  ///< half of its size
  Vec3 side_v;
  double radius_m;
  std::array<Vec3, kLightSide * kLightSide> samples;
};

std::size_t group_of(const std::vector<std::string>& groups, const std::string& name) {
  return static_cast<std::size_t>(std::lower_bound(groups.begin(), groups.end(), name) -
                                  groups.begin());
}

/// A light's first size runs along x (for one that shines up or down) or along the floor.
std::vector<Lamp> lamps_of(const World& world, const std::vector<std::string>& groups) {
  std::vector<Lamp> lamps;
  for (const AreaLight& light : world.lights) {
    Lamp lamp{light, group_of(groups, light.group), light.normal.normalized(), {}, {}, 0, {}};
    Vec3 u = across(lamp.normal).first;
    if (std::abs(lamp.normal.z()) > 0.9) {
      u = (Vec3::UnitX() - lamp.normal * lamp.normal.x()).normalized();
    }
    lamp.side_u = 0.5 * light.size_m.x() * u;
    lamp.side_v = 0.5 * light.size_m.y() * lamp.normal.cross(u);
    lamp.radius_m = 0.5 * light.size_m.norm();
    for (std::size_t i = 0; i < lamp.samples.size(); ++i) {
      const std::size_t column = i % kLightSide;
      const std::size_t row = i / kLightSide;
      const double a = (2.0 * static_cast<double>(column) + 1) / kLightSide - 1;
      const double b = (2.0 * static_cast<double>(row) + 1) / kLightSide - 1;
      lamp.samples[i] = light.at_m + a * lamp.side_u + b * lamp.side_v;
    }
    lamps.push_back(lamp);
  }
  return lamps;
}

/// Directions about z, as many in each direction as a matt surface returns light to it
/// (Hammersley's points on a disc, lifted to the hemisphere). By square roots alone: sines differ
/// in their last bit from processor to processor.
std::vector<Vec3> ambient_directions() {
  std::vector<Vec3> directions;
  for (int i = 0; i < kAmbientRays; ++i) {
    // The lowest bit of i turns by a half, the next by a quarter, ...
    Vec2 turn(1, 0);
    Vec2 step(-1, 0);
    for (int bit = 0; bit < kAmbientRayBits; ++bit) {
      if ((i >> bit & 1) != 0) {
        turn = {turn.x() * step.x() - turn.y() * step.y(),
                turn.x() * step.y() + turn.y() * step.x()};
      }
      step = {std::sqrt((1 + step.x()) / 2), std::sqrt((1 - step.x()) / 2)};
    }
    const double r = std::sqrt((i + 0.5) / kAmbientRays);
    directions.emplace_back(r * turn.x(), r * turn.y(), std::sqrt(1 - r * r));
  }
  return directions;
}

Vec3 nearest_in(const std::array<Vec3, 3>& t, const Vec3& normal, const Vec3& p) {
  Vec3 best = p;
  double best_m = std::numeric_limits<double>::infinity();
  bool inside = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& a = t[i];
    const Vec3 edge = t[(i + 1) % 3] - a;
    if (normal.dot(edge.cross(p - a)) < 0) {
      inside = false;
    }
    const double length2 = edge.squaredNorm();
    const Vec3 q = a + edge * (length2 > 0 ? std::clamp(edge.dot(p - a) / length2, 0.0, 1.0) : 0.0);
    if ((q - p).norm() < best_m) {
      best_m = (q - p).norm();
      best = q;
    }
  }
  return inside ? p : best;
}

std::vector<RayTracer::Corners> corners_of(const Charts& charts, std::size_t first,
                                           std::size_t end) {
  std::vector<RayTracer::Corners> corners;
  for (std::size_t c = first; c < end; ++c) {
    for (const LitTriangle& t : charts.charts[c].triangles) {
      corners.push_back(t.p);
    }
  }
  return corners;
}

std::uint8_t root_of(double light) {
  return static_cast<std::uint8_t>(
      std::lround(255 * std::sqrt(std::clamp(light / kMostLight, 0.0, 1.0))));
}

double light_of(std::uint8_t root) {
  const double share = root / 255.0;
  return kMostLight * share * share;
}

/// Where the light on a surface is asked for.
struct Spot {
  Vec3 p = Vec3::Zero();
  Vec3 normal = Vec3::Zero();
  std::array<Vec3, 4> about{p, p, p, p};  ///< four points about p, for shadows with sharp edges
};

class Light {
 public:
  Light(const World& world, const std::vector<std::string>& groups, const RayTracer& fixed)
      : fixed_(fixed),
        lamps_(lamps_of(world, groups)),
        directions_(ambient_directions()),
        ambient_(world.ambient),
        ambient_group_(group_of(groups, world.ambient_group)),
        sun_(world.sun) {
    if (sun_) {
      sun_->from.normalize();
      sun_group_ = group_of(groups, sun_->group);
    }
  }

  struct AmbientOcclusion {
    double open = 1;   ///< 1: nothing near
    double backs = 0;  ///< share of rays that meet something from behind
  };

  AmbientOcclusion ambient_occlusion(const RayTracer& things, const Vec3& p,
                                     const Vec3& normal) const {
    const Vec3 from = p + kOff_m * normal;
    const auto [a, b] = across(normal);
    double lost = 0;
    int backs = 0;
    for (const Vec3& d : directions_) {
      const Vec3 direction = d.x() * a + d.y() * b + d.z() * normal;
      const RayTracer::Hit hit = things.first_hit(from, direction, kOff_m, kAmbientReach_m);
      if (hit.distance_m < kAmbientReach_m) {
        lost += 1 - hit.distance_m / kAmbientReach_m;
        backs += hit.back ? 1 : 0;
      }
    }
    return {1 - lost / kAmbientRays, static_cast<double>(backs) / kAmbientRays};
  }

  static double let_in(double open) { return kAmbientReturned + (1 - kAmbientReturned) * open; }

  /// The light of each group. False, and none of it, when the spot is inside of something.
  bool at(const Spot& spot, std::vector<double>& light) const {
    std::fill(light.begin(), light.end(), 0.0);
    const Lamp* shining = nullptr;
    for (const Lamp& lamp : lamps_) {
      if (shows(lamp, spot)) {
        shining = &lamp;
        break;
      }
    }
    if (shining != nullptr && light.size() == 1) {
      light[0] = kLampBrightness;
      return true;
    }
    const AmbientOcclusion around = ambient_occlusion(fixed_, spot.p, spot.normal);
    if (around.backs > kInsideShare && shining == nullptr) {
      return false;
    }
    light[ambient_group_] += ambient_ * let_in(around.open);
    const Vec3 from = spot.p + kOff_m * spot.normal;
    for (const Lamp& lamp : lamps_) {
      light[lamp.group] += light_from(lamp, from, spot.normal);
    }
    if (sun_) {
      light[sun_group_] += light_from_sun(spot);
    }
    if (shining != nullptr) {  // brought to its brightness by its own group: out, it is a surface
      double others = 0;
      for (std::size_t g = 0; g < light.size(); ++g) {
        others += g == shining->group ? 0 : light[g];
      }
      light[shining->group] = std::max(0.0, kLampBrightness - others);
    }
    return true;
  }

  double ambient() const { return ambient_; }
  std::size_t ambient_group() const { return ambient_group_; }

 private:
  static bool shows(const Lamp& lamp, const Spot& spot) {
    const Vec3 off = spot.p - lamp.light.at_m;
    return spot.normal.dot(lamp.normal) > kSameWay &&
           std::abs(off.dot(lamp.normal)) < kLightBody_m &&
           std::abs(off.dot(lamp.side_u)) <= lamp.side_u.squaredNorm() * kEdge &&
           std::abs(off.dot(lamp.side_v)) <= lamp.side_v.squaredNorm() * kEdge;
  }

  double light_from_sun(const Spot& spot) const {
    const double cosine = spot.normal.dot(sun_->from);
    if (cosine <= 0) {
      return 0;
    }
    int seen = 0;
    for (const Vec3& p : spot.about) {
      seen += fixed_.blocked(p + kOff_m * spot.normal, sun_->from, kOff_m, kSunReach_m) ? 0 : 1;
    }
    return sun_->power * cosine * seen / static_cast<double>(spot.about.size());
  }

  double light_from(const Lamp& lamp, const Vec3& from, const Vec3& normal) const {
    const double negligible = kNegligible / static_cast<double>(lamps_.size());
    const Vec3 to_middle = lamp.light.at_m - from;
    const double nearest_m = std::max(to_middle.norm() - lamp.radius_m, kOff_m);
    if (lamp.light.power < negligible * nearest_m * nearest_m ||
        normal.dot(to_middle) < -lamp.radius_m || lamp.normal.dot(to_middle) >= 0) {
      return 0;
    }
    const auto unblocked = [&](const Vec3& sample) {
      const Vec3 to = sample - from;
      const double r2 = to.squaredNorm();
      const double cosines = normal.dot(to) * -lamp.normal.dot(to);
      return normal.dot(to) > 0 && lamp.normal.dot(to) < 0 ? cosines / (r2 * r2) : 0.0;
    };
    std::array<double, kLightSide * kLightSide> part;
    double all = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      part[i] = lamp.light.power / static_cast<double>(part.size()) * unblocked(lamp.samples[i]);
      all += part[i];
    }
    if (all < negligible) {
      return 0;
    }
    const auto sees = [&](std::size_t i) {
      const Vec3 to = lamp.samples[i] - from;
      const double r = to.norm();
      return r < kLightBody_m || !fixed_.blocked(from, to / r, kOff_m, r - kLightBody_m);
    };
    // All of the light where its four corners are seen, none where none is; else one by one.
    constexpr std::size_t kLast = kLightSide - 1;
    constexpr std::array<std::size_t, 4> kCorners{0, kLast, kLast * kLightSide,
                                                  kLast * kLightSide + kLast};
    int seen = 0;
    for (const std::size_t i : kCorners) {
      seen += sees(i) ? 1 : 0;
    }
    if (seen == 0 || seen == static_cast<int>(kCorners.size())) {
      return seen == 0 ? 0 : all;
    }
    double light = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      light += part[i] > 0 && sees(i) ? part[i] : 0;
    }
    return light;
  }

  static constexpr double kSameWay = 0.99;
  static constexpr double kEdge = 1.02;  // the lamp's own edge belongs to it

  const RayTracer& fixed_;
  std::vector<Lamp> lamps_;
  std::vector<Vec3> directions_;
  double ambient_;
  std::size_t ambient_group_;
  std::optional<Sun> sun_;
  std::size_t sun_group_ = 0;
};

/// Some rows of a chart, or some of the probes.
struct Item {
  std::size_t chart = 0;
  int first = 0;
  int end = 0;
};

/// Lays the grid where something may move: over the fixed floor plan, as high as what moves.
void lay_probes(const Charts& charts, const World& world, Probes& probes) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  double top_m = -std::numeric_limits<double>::infinity();
  for (const Chart& chart : charts.charts) {
    for (const LitTriangle& t : chart.triangles) {
      for (const Vec3& p : t.p) {
        const Vec3 p_scene = chart.moves ? world.objects[chart.object].T_scene_object * p : p;
        low = low.cwiseMin(p_scene);
        high = high.cwiseMax(p_scene);
        top_m = chart.moves ? std::max(top_m, p_scene.z()) : top_m;
      }
    }
  }
  if (!(top_m > -std::numeric_limits<double>::infinity())) {
    return;
  }
  low.z() = std::min(kProbeFloor_m, top_m);
  high.z() = top_m;
  double spacing_m = kProbeSpacing_m;
  const auto count = [&](Eigen::Index axis) {
    const double most = axis == 2 ? kProbeSpacing_m : spacing_m;
    return static_cast<int>(std::ceil((high[axis] - low[axis]) / most - 1e-6)) + 1;
  };
  const auto number = [&] { return 1.0 * count(0) * count(1) * count(2); };
  while (number() > static_cast<double>(kMostProbes) && count(0) + count(1) > 2) {
    spacing_m *= 1.1;
  }
  probes.low_scene = low;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const int n = count(axis);
    probes.counts[static_cast<std::size_t>(axis)] = n;
    probes.spacing_m[axis] = n > 1 ? (high[axis] - low[axis]) / (n - 1) : 1;
  }
}

class Baker {
 public:
  Baker(const World& world, const Charts& charts)
      : charts_(charts),
        baked_{light_groups(world), {}, {}},
        fixed_(corners_of(charts, 0, first_moving(charts))),
        light_(world, baked_.groups, fixed_),
        known_(cv::Mat::zeros(std::max(charts.rows, 1), charts.columns, CV_8U)) {
    for (std::size_t g = 0; g < baked_.groups.size(); ++g) {
      baked_.layers.push_back(cv::Mat::zeros(known_.rows, known_.cols, CV_8U));
    }
    lay_probes(charts, world, baked_.probes);
    baked_.probes.groups.assign(baked_.groups.size(),
                                std::vector<Probes::Cube>(baked_.probes.size(), Probes::Cube{}));
    probe_known_.assign(baked_.probes.size(), 0);
    // What moves is lit by itself: each in a tree of its own.
    for (std::size_t c = first_moving(charts); c < charts.charts.size();) {
      std::size_t end = c;
      while (end < charts.charts.size() && charts.charts[end].object == charts.charts[c].object) {
        ++end;
      }
      const std::size_t object = charts.charts[c].object;
      own_trees_.resize(std::max(own_trees_.size(), object + 1));
      own_trees_[object].emplace(corners_of(charts, c, end));
      c = end;
    }
    cut_into_items();
  }

  const std::vector<Item>& items() const { return items_; }
  double work() const { return work_; }

  /// Returns how much work that was.
  int bake(const Item& item) {
    if (item.chart == charts_.charts.size()) {
      for (int i = item.first; i < item.end; ++i) {
        bake_probe(static_cast<std::size_t>(i));
      }
      return 6 * (item.end - item.first);
    }
    const Chart& chart = charts_.charts[item.chart];
    bake_rows(chart, item.first, item.end);
    return chart.columns * (item.end - item.first);
  }

  BakedLight finish() {
    for (const Chart& chart : charts_.charts) {
      fill_unknown(chart);
    }
    fill_unknown_probes();
    return std::move(baked_);
  }

 private:
  static std::size_t first_moving(const Charts& charts) {
    std::size_t c = 0;
    while (c < charts.charts.size() && !charts.charts[c].moves) {
      ++c;
    }
    return c;
  }

  void cut_into_items() {
    for (std::size_t c = 0; c < charts_.charts.size(); ++c) {
      const Chart& chart = charts_.charts[c];
      const int rows = std::max(1, kItemTexels / chart.columns);
      for (int row = 0; row < chart.rows; row += rows) {
        items_.push_back({c, row, std::min(row + rows, chart.rows)});
      }
      work_ += 1.0 * chart.columns * chart.rows;
    }
    const int probes = static_cast<int>(baked_.probes.size());
    for (int i = 0; i < probes; i += kItemTexels / 6) {
      items_.push_back({charts_.charts.size(), i, std::min(i + kItemTexels / 6, probes)});
    }
    work_ += 6.0 * probes;
  }

  void bake_rows(const Chart& chart, int first, int end) {
    const std::vector<Spot> spots = spots_of(chart, first, end);
    std::vector<double> light(baked_.groups.size());
    for (std::size_t i = 0; i < spots.size(); ++i) {
      if (spots[i].normal.isZero(0)) {
        continue;  // nothing of the chart is near: never looked up
      }
      const int row = chart.row + first + static_cast<int>(i) / chart.columns;
      const int column = chart.column + static_cast<int>(i) % chart.columns;
      if (chart.moves) {
        const Light::AmbientOcclusion around =
            light_.ambient_occlusion(*own_trees_[chart.object], spots[i].p, chart.normal);
        if (around.backs <= kInsideShare) {
          known_.at<std::uint8_t>(row, column) = kKnown;
          baked_.layers[0].at<std::uint8_t>(row, column) =
              static_cast<std::uint8_t>(std::lround(255 * Light::let_in(around.open)));
        } else {
          known_.at<std::uint8_t>(row, column) = kInside;
        }
      } else if (light_.at(spots[i], light)) {
        known_.at<std::uint8_t>(row, column) = kKnown;
        for (std::size_t g = 0; g < light.size(); ++g) {
          baked_.layers[g].at<std::uint8_t>(row, column) = root_of(light[g]);
        }
      } else {
        known_.at<std::uint8_t>(row, column) = kInside;
      }
    }
  }

  /// The places of a chart's texels on its surface: the nearest points a little inside of its
  /// edges. No normal: the texel is not near to any of its triangles.
  static std::vector<Spot> spots_of(const Chart& chart, int first, int end) {
    const auto columns = static_cast<std::size_t>(chart.columns);
    std::vector<Spot> spots(columns * static_cast<std::size_t>(end - first));
    std::vector<double> distance_m(spots.size(), std::numeric_limits<double>::infinity());
    for (const LitTriangle& t : chart.triangles) {
      Vec2 low = t.texel[0].cwiseMin(t.texel[1]).cwiseMin(t.texel[2]);
      Vec2 high = t.texel[0].cwiseMax(t.texel[1]).cwiseMax(t.texel[2]);
      low -= Vec2(chart.column, chart.row);
      high -= Vec2(chart.column, chart.row);
      const int r0 = std::max(first, static_cast<int>(std::floor(low.y())) - 1);
      const int r1 = std::min(end - 1, static_cast<int>(std::ceil(high.y())) + 1);
      const int c0 = std::max(0, static_cast<int>(std::floor(low.x())) - 1);
      const int c1 = std::min(chart.columns - 1, static_cast<int>(std::ceil(high.x())) + 1);
      for (int row = r0; row <= r1; ++row) {
        for (int column = c0; column <= c1; ++column) {
          const std::size_t i =
              static_cast<std::size_t>(row - first) * columns + static_cast<std::size_t>(column);
          if (distance_m[i] <= 0) {
            continue;
          }
          const Vec3 p = inside(chart, column, row);
          const Vec3 q = nearest_in(t.p, chart.normal, p);
          const double away_m = (q - p).norm() < kOnSurface_m ? 0 : (q - p).norm();
          if (away_m < distance_m[i]) {
            distance_m[i] = away_m;
            spots[i] = away_m > 0 ? beside(chart, t, q) : on_surface(chart, column, row, p);
          }
        }
      }
    }
    return spots;
  }

  static Spot beside(const Chart& chart, const LitTriangle& t, const Vec3& q) {
    const Vec3 to_middle = (t.p[0] + t.p[1] + t.p[2]) / 3 - q;
    const Vec3 p = q + to_middle * std::min(0.5, kInset_m / std::max(to_middle.norm(), kInset_m));
    return {p, chart.normal, {p, p, p, p}};
  }

  static Spot on_surface(const Chart& chart, int column, int row, const Vec3& p) {
    constexpr double kQuarter = 0.25;
    return {p,
            chart.normal,
            {inside(chart, column - kQuarter, row - kQuarter),
             inside(chart, column + kQuarter, row - kQuarter),
             inside(chart, column - kQuarter, row + kQuarter),
             inside(chart, column + kQuarter, row + kQuarter)}};
  }

  /// A point of the chart's rectangle, a little inside of its edges.
  static Vec3 inside(const Chart& chart, double column, double row) {
    const auto kept = [](double x, double size_m) {
      const double inset = std::min(kInset_m, size_m / 4);
      return std::clamp(x, inset, size_m - inset);
    };
    const Vec3 off = chart.point(column, row) - chart.origin;
    return chart.origin + chart.u * kept(chart.u.dot(off), chart.size_m.x()) +
           chart.v * kept(chart.v.dot(off), chart.size_m.y());
  }

  /// Texels inside of something take the mean of their known neighbours, ring by ring.
  void fill_unknown(const Chart& chart) {
    const cv::Rect place(chart.column, chart.row, chart.columns, chart.rows);
    cv::Mat known = known_(place);
    std::vector<cv::Mat> layers;
    for (std::size_t g = 0; g < (chart.moves ? 1 : baked_.layers.size()); ++g) {
      layers.push_back(baked_.layers[g](place));
    }
    const auto neighbours = [&chart](const cv::Point& at, const auto& visit) {
      for (int r = std::max(0, at.y - 1); r <= std::min(chart.rows - 1, at.y + 1); ++r) {
        for (int c = std::max(0, at.x - 1); c <= std::min(chart.columns - 1, at.x + 1); ++c) {
          visit(r, c);
        }
      }
    };
    std::vector<cv::Point> unknown;
    for (int row = 0; row < chart.rows; ++row) {
      for (int column = 0; column < chart.columns; ++column) {
        if (known.at<std::uint8_t>(row, column) == kInside) {
          unknown.emplace_back(column, row);
        }
      }
    }
    while (!unknown.empty()) {
      std::vector<cv::Point> ring;
      std::vector<cv::Point> later;
      for (const cv::Point& at : unknown) {
        int near = 0;
        neighbours(at, [&](int r, int c) { near += known.at<std::uint8_t>(r, c) == kKnown; });
        (near > 0 ? ring : later).push_back(at);
      }
      if (ring.empty()) {
        break;
      }
      for (const cv::Point& at : ring) {
        for (cv::Mat& layer : layers) {
          double sum = 0;
          int near = 0;
          neighbours(at, [&](int r, int c) {
            if (known.at<std::uint8_t>(r, c) == kKnown) {
              sum += light_of(layer.at<std::uint8_t>(r, c));
              ++near;
            }
          });
          layer.at<std::uint8_t>(at) = root_of(sum / near);
        }
      }
      for (const cv::Point& at : ring) {
        known.at<std::uint8_t>(at) = kKnown;
      }
      unknown = std::move(later);
    }
    for (const cv::Point& at : unknown) {  // a chart nobody can see
      layers[chart.moves ? 0 : light_.ambient_group()].at<std::uint8_t>(at) =
          chart.moves ? static_cast<std::uint8_t>(std::lround(255 * kAmbientReturned))
                      : root_of(light_.ambient() * kAmbientReturned);
    }
  }

  void bake_probe(std::size_t index) {
    Probes& probes = baked_.probes;
    const auto nx = static_cast<std::size_t>(probes.counts[0]);
    const auto ny = static_cast<std::size_t>(probes.counts[1]);
    const Vec3 steps(static_cast<double>(index % nx), static_cast<double>(index / nx % ny),
                     static_cast<double>(index / nx / ny));
    const Vec3 p = probes.low_scene + steps.cwiseProduct(probes.spacing_m);
    std::vector<double> light(baked_.groups.size());
    int inside = 0;
    for (std::size_t side = 0; side < 6; ++side) {
      Vec3 normal = Vec3::Zero();
      normal[static_cast<Eigen::Index>(side / 2)] = side % 2 == 0 ? 1 : -1;
      inside += light_.at({p, normal, {p, p, p, p}}, light) ? 0 : 1;
      for (std::size_t g = 0; g < light.size(); ++g) {
        probes.groups[g][index][side] = static_cast<float>(light[g]);
      }
    }
    // Inside of a thing from most sides: the light is that of its neighbours.
    probe_known_[index] = inside < 3 ? 1 : 0;
  }

  void fill_unknown_probes() {
    Probes& probes = baked_.probes;
    const std::array<int, 3>& n = probes.counts;
    const auto at = [&n](int x, int y, int z) {
      return (static_cast<std::size_t>(z) * static_cast<std::size_t>(n[1]) +
              static_cast<std::size_t>(y)) *
                 static_cast<std::size_t>(n[0]) +
             static_cast<std::size_t>(x);
    };
    bool filled = true;
    while (filled) {
      filled = false;
      const std::vector<char> known = probe_known_;
      for (int i = 0; i < static_cast<int>(probes.size()); ++i) {
        if (known[static_cast<std::size_t>(i)] != 0) {
          continue;
        }
        const int x = i % n[0];
        const int y = i / n[0] % n[1];
        const int z = i / n[0] / n[1];
        std::vector<std::size_t> near;
        for (const auto& [dx, dy, dz] : std::array<std::array<int, 3>, 6>{
                 {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}}) {
          if (x + dx >= 0 && x + dx < n[0] && y + dy >= 0 && y + dy < n[1] && z + dz >= 0 &&
              z + dz < n[2] && known[at(x + dx, y + dy, z + dz)] != 0) {
            near.push_back(at(x + dx, y + dy, z + dz));
          }
        }
        if (near.empty()) {
          continue;
        }
        for (std::vector<Probes::Cube>& cubes : probes.groups) {
          for (std::size_t side = 0; side < 6; ++side) {
            float sum = 0;
            for (const std::size_t other : near) {
              sum += cubes[other][side];
            }
            cubes[static_cast<std::size_t>(i)][side] = sum / static_cast<float>(near.size());
          }
        }
        probe_known_[static_cast<std::size_t>(i)] = 1;
        filled = true;
      }
    }
  }

  static constexpr double kOnSurface_m = 1e-6;
  static constexpr std::uint8_t kKnown = 1;
  static constexpr std::uint8_t kInside = 2;

  const Charts& charts_;
  BakedLight baked_;
  RayTracer fixed_;
  Light light_;
  std::vector<std::optional<RayTracer>> own_trees_;  ///< by object
  cv::Mat known_;                                    ///< what is known of each texel
  std::vector<char> probe_known_;
  std::vector<Item> items_;
  double work_ = 0;
};

}  // namespace

std::vector<std::string> light_groups(const World& world) {
  std::set<std::string> names{world.ambient_group};
  for (const AreaLight& light : world.lights) {
    names.insert(light.group);
  }
  if (world.sun) {
    names.insert(world.sun->group);
  }
  return {names.begin(), names.end()};
}

BakedLight bake_light(const World& world, const Charts& charts, int num_threads,
                      const BakeProgress& progress) {
  Baker baker(world, charts);
  std::atomic<std::size_t> next{0};
  std::atomic<std::int64_t> done{0};
  std::atomic<bool> stopped{false};
  const auto work = [&](const auto& after_item) {
    for (std::size_t i = next++; i < baker.items().size() && !stopped; i = next++) {
      const int texels = baker.bake(baker.items()[i]);
      done += texels;
      after_item(texels);
    }
  };
  std::mutex fault_mutex;
  std::exception_ptr fault;  // of a helper
  const auto help = [&] {
    try {
      work([](int /*texels*/) {});
    } catch (...) {
      stopped = true;
      const std::lock_guard lock(fault_mutex);
      fault = std::current_exception();
    }
  };
  struct Helpers {
    std::atomic<bool>& stopped;
    std::vector<std::thread> threads;
    ~Helpers() {  // also when the caller's progress throws
      stopped = true;
      for (std::thread& thread : threads) {
        thread.join();
      }
    }
  };
  {
    Helpers helpers{stopped, {}};
    for (int i = 1; i < num_threads; ++i) {
      helpers.threads.emplace_back(help);
    }
    int unsaid = 0;
    work([&](int texels) {
      unsaid += texels;
      if (progress && unsaid >= kProgressTexels) {
        unsaid = 0;
        if (!progress(static_cast<double>(done) / baker.work())) {
          throw BakeStopped("light and shadow are not finished: stopped as asked");
        }
      }
    });
    for (std::thread& thread : helpers.threads) {
      thread.join();
    }
    helpers.threads.clear();
  }
  if (fault) {
    std::rethrow_exception(fault);
  }
  return baker.finish();
}

}  // namespace panoptes::sim
