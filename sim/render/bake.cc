// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <thread>
#include <utility>

#include <embree3/rtcore.h>

#include "core/base/check.h"
#include "core/base/error.h"
#include "sim/render/lightmap.h"

namespace panoptes::sim {
namespace {

constexpr int kAmbientRays = 48;
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

class Scene {
 public:
  explicit Scene(const Charts& charts) {
    device_ = rtcNewDevice("threads=1,set_affinity=0");
    if (device_ == nullptr) {
      throw DeviceError("Embree does not start; reinstall the package libembree3-3");
    }
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    for (const Chart& chart : charts.charts) {
      normals_.insert(normals_.end(), chart.triangles.size(), chart.normal);
    }
    auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               3 * normals_.size()));
    auto* indices = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), normals_.size()));
    unsigned next = 0;
    for (const Chart& chart : charts.charts) {
      for (const LitTriangle& t : chart.triangles) {
        for (const Vec3& p : t.p_scene) {
          for (int i = 0; i < 3; ++i) {
            *points++ = static_cast<float>(p[i]);
          }
          *indices++ = next++;
        }
      }
    }
    rtcCommitGeometry(geometry);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  ~Scene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  bool blocked(const Vec3& from, const Vec3& direction, double reach_m) const {
    RTCRay ray = ray_of(from, direction, reach_m);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene_, &context, &ray);
    return ray.tfar < 0;
  }

  struct Hit {
    double distance_m = std::numeric_limits<double>::infinity();
    bool back = false;
  };
  Hit first_hit(const Vec3& from, const Vec3& direction, double reach_m) const {
    RTCRayHit hit{};
    hit.ray = ray_of(from, direction, reach_m);
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &hit);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
      return {};
    }
    return {hit.ray.tfar, normals_[hit.hit.primID].dot(direction) > 0};
  }

 private:
  static RTCRay ray_of(const Vec3& from, const Vec3& direction, double reach_m) {
    RTCRay ray{};
    ray.org_x = static_cast<float>(from.x());
    ray.org_y = static_cast<float>(from.y());
    ray.org_z = static_cast<float>(from.z());
    ray.dir_x = static_cast<float>(direction.x());
    ray.dir_y = static_cast<float>(direction.y());
    ray.dir_z = static_cast<float>(direction.z());
    ray.tnear = static_cast<float>(kOff_m);  // a surface through the very point hides nothing
    ray.tfar = static_cast<float>(reach_m);
    ray.mask = ~0U;
    return ray;
  }

  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  std::vector<Vec3> normals_;
};

/// Two unit vectors across a third.
std::pair<Vec3, Vec3> across(const Vec3& n) {
  const Vec3 helper = std::abs(n.z()) > 0.9 ? Vec3::UnitX() : Vec3::UnitZ();
  const Vec3 a = helper.cross(n).normalized();
  return {a, n.cross(a)};
}

struct Lamp {
  AreaLight light;
  Vec3 normal;
  Vec3 side_u;  ///< half of its size
  Vec3 side_v;
  std::array<Vec3, kLightSide * kLightSide> samples;
};

/// A light's first size runs along x (for one that shines up or down) or along the floor.
std::vector<Lamp> lamps_of(const World& world) {
  std::vector<Lamp> lamps;
  for (const AreaLight& light : world.lights) {
    Lamp lamp{light, light.normal.normalized(), {}, {}, {}};
    Vec3 u = across(lamp.normal).first;
    if (std::abs(lamp.normal.z()) > 0.9) {
      u = (Vec3::UnitX() - lamp.normal * lamp.normal.x()).normalized();
    }
    lamp.side_u = 0.5 * light.size_m.x() * u;
    lamp.side_v = 0.5 * light.size_m.y() * lamp.normal.cross(u);
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
/// (Hammersley's points on a disc, lifted to the hemisphere).
std::vector<Vec3> ambient_directions() {
  std::vector<Vec3> directions;
  for (int i = 0; i < kAmbientRays; ++i) {
    double radical = 0;
    double digit = 0.5;
    for (int bits = i; bits != 0; bits >>= 1, digit /= 2) {
      radical += (bits & 1) != 0 ? digit : 0;
    }
    const double r = std::sqrt((i + 0.5) / kAmbientRays);
    const double angle = 2 * 3.14159265358979323846 * radical;
    directions.emplace_back(r * std::cos(angle), r * std::sin(angle), std::sqrt(1 - r * r));
  }
  return directions;
}

class Baker {
 public:
  Baker(const World& world, const Charts& charts)
      : scene_(charts),
        lamps_(lamps_of(world)),
        directions_(ambient_directions()),
        ambient_(world.ambient) {}

  void bake(const Chart& chart, cv::Mat& texels) const {
    std::vector<double> light(texel_index(chart, 0, chart.rows));  // negative: not known
    for (int row = 0; row < chart.rows; ++row) {
      for (int column = 0; column < chart.columns; ++column) {
        light[texel_index(chart, column, row)] =
            light_at(sample_point(chart, column, row), chart.normal);
      }
    }
    fill_unknown(chart, light);
    for (int row = 0; row < chart.rows; ++row) {
      std::uint8_t* out = texels.ptr<std::uint8_t>(chart.row + row) + chart.column;
      for (int column = 0; column < chart.columns; ++column) {
        const double e = light[texel_index(chart, column, row)];
        out[column] = static_cast<std::uint8_t>(
            std::lround(255 * std::sqrt(std::clamp(e / kMostLight, 0.0, 1.0))));
      }
    }
  }

 private:
  static std::size_t texel_index(const Chart& chart, int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(chart.columns) +
           static_cast<std::size_t>(column);
  }

  /// The texel's place on the chart's surface: the nearest point a little inside of its edges.
  static Vec3 sample_point(const Chart& chart, int column, int row) {
    const auto inside = [](double x, double size_m) {
      const double inset = std::min(kInset_m, size_m / 4);
      return std::clamp(x, inset, size_m - inset);
    };
    Vec3 p = chart.origin_scene +
             chart.u * inside(chart.size_m.x() * column / (chart.columns - 1), chart.size_m.x()) +
             chart.v * inside(chart.size_m.y() * row / (chart.rows - 1), chart.size_m.y());
    double nearest_m = std::numeric_limits<double>::infinity();
    Vec3 nearest = p;
    for (const LitTriangle& t : chart.triangles) {
      const Vec3 q = nearest_in(t.p_scene, chart.normal, p);
      const double distance_m = (q - p).norm();
      if (distance_m < 1e-6) {
        return p;
      }
      if (distance_m < nearest_m) {
        nearest_m = distance_m;
        const Vec3 to_middle = (t.p_scene[0] + t.p_scene[1] + t.p_scene[2]) / 3 - q;
        nearest = q + to_middle * std::min(0.5, kInset_m / std::max(to_middle.norm(), kInset_m));
      }
    }
    return nearest;
  }

  static Vec3 nearest_in(const std::array<Vec3, 3>& t, const Vec3& normal, const Vec3& p) {
    Vec3 best = p;
    double best_m = std::numeric_limits<double>::infinity();
    bool inside = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& a = t[i];
      const Vec3 edge = t[(i + 1) % 3] - a;
      if (normal.dot(edge.cross(p - a)) < 0) {
        inside = false;
      }
      const Vec3 q = a + edge * std::clamp(edge.dot(p - a) / edge.squaredNorm(), 0.0, 1.0);
      if ((q - p).norm() < best_m) {
        best_m = (q - p).norm();
        best = q;
      }
    }
    return inside ? p : best;
  }

  /// Negative when the point is inside of something.
  double light_at(const Vec3& p, const Vec3& normal) const {
    for (const Lamp& lamp : lamps_) {
      if (shows(lamp, p, normal)) {
        return kLampBrightness;
      }
    }
    const Vec3 from = p + kOff_m * normal;
    const auto [a, b] = across(normal);
    double lost = 0;
    int backs = 0;
    for (const Vec3& d : directions_) {
      const Vec3 direction = d.x() * a + d.y() * b + d.z() * normal;
      const Scene::Hit hit = scene_.first_hit(from, direction, kAmbientReach_m);
      if (hit.distance_m < kAmbientReach_m) {
        lost += 1 - hit.distance_m / kAmbientReach_m;
        backs += hit.back ? 1 : 0;
      }
    }
    if (backs > kInsideShare * kAmbientRays) {
      return -1;
    }
    const double open = 1 - lost / kAmbientRays;
    double light = ambient_ * (kAmbientReturned + (1 - kAmbientReturned) * open);
    for (const Lamp& lamp : lamps_) {
      light += light_from(lamp, from, normal);
    }
    return light;
  }

  static bool shows(const Lamp& lamp, const Vec3& p, const Vec3& normal) {
    const Vec3 off = p - lamp.light.at_m;
    return normal.dot(lamp.normal) > kSameWay && std::abs(off.dot(lamp.normal)) < kLightBody_m &&
           std::abs(off.dot(lamp.side_u)) <= lamp.side_u.squaredNorm() * kEdge &&
           std::abs(off.dot(lamp.side_v)) <= lamp.side_v.squaredNorm() * kEdge;
  }

  double light_from(const Lamp& lamp, const Vec3& from, const Vec3& normal) const {
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
    if (all < kNegligible) {
      return 0;
    }
    const auto sees = [&](std::size_t i) {
      const Vec3 to = lamp.samples[i] - from;
      const double r = to.norm();
      return r < kLightBody_m || !scene_.blocked(from, to / r, r - kLightBody_m);
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

  /// Texels inside of something take the mean of their known neighbours, ring by ring.
  void fill_unknown(const Chart& chart, std::vector<double>& light) const {
    const auto at = [&chart](int column, int row) { return texel_index(chart, column, row); };
    bool filled = true;
    while (filled) {
      filled = false;
      const std::vector<double> before = light;
      for (int row = 0; row < chart.rows; ++row) {
        for (int column = 0; column < chart.columns; ++column) {
          if (before[at(column, row)] >= 0) {
            continue;
          }
          double sum = 0;
          int known = 0;
          for (int r = std::max(0, row - 1); r <= std::min(chart.rows - 1, row + 1); ++r) {
            for (int c = std::max(0, column - 1); c <= std::min(chart.columns - 1, column + 1);
                 ++c) {
              if (before[at(c, r)] >= 0) {
                sum += before[at(c, r)];
                ++known;
              }
            }
          }
          if (known > 0) {
            light[at(column, row)] = sum / known;
            filled = true;
          }
        }
      }
    }
    for (double& e : light) {
      e = e < 0 ? ambient_ * kAmbientReturned : e;  // a chart nobody can see
    }
  }

  static constexpr double kSameWay = 0.99;
  static constexpr double kEdge = 1.02;  // the lamp's own edge belongs to it

  Scene scene_;
  std::vector<Lamp> lamps_;
  std::vector<Vec3> directions_;
  double ambient_;
};

}  // namespace

cv::Mat bake_light(const World& world, const Charts& charts, int num_threads) {
  cv::Mat texels = cv::Mat::zeros(std::max(charts.rows, 1), std::max(charts.columns, 1), CV_8U);
  const Baker baker(world, charts);
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < charts.charts.size(); i = next++) {
      baker.bake(charts.charts[i], texels);
    }
  };
  std::vector<std::thread> helpers;
  for (int i = 1; i < num_threads; ++i) {
    helpers.emplace_back(work);
  }
  work();
  for (std::thread& helper : helpers) {
    helper.join();
  }
  return texels;
}

}  // namespace panoptes::sim
