// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/rendered_sight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

#include "core/config/geometry_fields.h"
#include "core/eval/floor_sight.h"
#include "core/eval/statistics.h"
#include "core/io/file.h"

namespace panoptes::test {
namespace {

constexpr double kReach_m = 4.5;
constexpr double kCell_m = 0.02;
constexpr int kHullSides = 180;
constexpr std::array<double, 4> kDistances_m{0.5, 1, 2, 3};

std::string hull_mesh(const Body& body) {
  std::string obj;
  if (body.faces) {
    int corner = 0;
    for (const Face& face : *body.faces) {
      for (const Vec3& p : face) {
        obj += fmt::format("v {:.6f} {:.6f} {:.6f}\n", p.x(), p.y(), p.z());
      }
      obj += fmt::format("f {} {} {}\n", corner + 1, corner + 2, corner + 3);
      corner += 3;
    }
    return obj;
  }
  const auto corner = [&](int k, double z) {
    const double angle = 2 * std::numbers::pi * k / kHullSides;
    return fmt::format("v {:.6f} {:.6f} {:.6f}\n", body.radius_m * std::cos(angle),
                       body.radius_m * std::sin(angle), z);
  };
  for (int k = 0; k < kHullSides; ++k) {
    obj += corner(k, 0) + corner(k, body.hull_height_m);
  }
  std::string top = "f";
  for (int k = 0; k < kHullSides; ++k) {
    const int low = 2 * k + 1;
    const int next = 2 * ((k + 1) % kHullSides) + 1;
    obj += fmt::format("f {} {} {} {}\n", low, next, next + 1, low + 1);
    top += fmt::format(" {}", low + 1);
  }
  return obj + top + "\n";
}

Vec3 drawn_point(Rng& rng, const Body& body) {
  const double angle = rng.uniform(-std::numbers::pi, std::numbers::pi);
  const double r = body.radius_m * rng.uniform(0, 1.1);
  return {r * std::cos(angle), r * std::sin(angle),
          rng.uniform(body.hull_height_m + 0.05, body.height_m)};
}

Intrinsics drawn_lens(Rng& rng) {
  const int height_px = 120 * (2 + rng.index(3));  // 240, 360 or 480
  const int width_px = height_px * 4 / 3;
  switch (rng.index(3)) {
    case 0:
      return pinhole(width_px, height_px, deg_to_rad(rng.uniform(45, 105)));
    case 1:
      return lens_of_view(width_px, height_px, deg_to_rad(rng.uniform(60, 85)),
                          BrownConrady{rng.uniform(-0.15, 0), 0, 0, 0, 0});
    default:
      return lens_of_view(width_px, height_px, deg_to_rad(rng.uniform(90, 150)), Equidistant());
  }
}

/// The floor under each pixel of a picture, in `body`, where it shows floor.
class FloorPicture {
 public:
  FloorPicture(const std::filesystem::path& pictures, const std::string& name,
               const RigCamera& camera)
      : camera_(camera),
        label_(cv::imread((pictures / (name + "_floor.png")).string(), cv::IMREAD_UNCHANGED)),
        depth_mm_(cv::imread((pictures / (name + "_depth.png")).string(), cv::IMREAD_UNCHANGED)) {
    if (label_.type() != CV_8U || depth_mm_.type() != CV_16U || label_.size() != depth_mm_.size()) {
      throw std::runtime_error(pictures.string() + " holds no floor and depth of " + name);
    }
  }

  int rows() const { return label_.rows; }
  int cols() const { return label_.cols; }

  std::optional<Vec2> at(int u, int v) const {
    constexpr int kFar_mm = 65535;
    if (u < 0 || v < 0 || u >= cols() || v >= rows() || label_.at<std::uint8_t>(v, u) == 0 ||
        depth_mm_.at<std::uint16_t>(v, u) == kFar_mm) {
      return std::nullopt;
    }
    const double depth_m = 1e-3 * depth_mm_.at<std::uint16_t>(v, u);
    const std::optional<Vec3> d = camera_.intrinsics.direction(Vec2(u, v));
    if (!d) {
      return std::nullopt;
    }
    // along each pixel's ray of an equidistant lens, else along the axis
    const bool along_ray = std::holds_alternative<Equidistant>(camera_.intrinsics.distortion);
    const Vec3 p_camera = along_ray ? Vec3(depth_m * d->normalized()) : Vec3(depth_m / d->z() * *d);
    return (camera_.T_body_camera * p_camera).head<2>();
  }

  /// How a step of a pixel moves the floor that is seen, across and down; a difference of four
  /// pixels where there is room, for depths are told in millimetres.
  std::optional<Mat2> per_px(int u, int v) const {
    const auto along = [&](int du, int dv) -> std::optional<Vec2> {
      for (const auto& [back, on] : {std::pair{2, 2}, {1, 1}, {0, 1}, {1, 0}}) {
        const auto from = at(u - back * du, v - back * dv);
        const auto to = at(u + on * du, v + on * dv);
        if (from && to) {
          return Vec2((*to - *from) / (back + on));
        }
      }
      return std::nullopt;
    };
    const auto across = along(1, 0);
    const auto down = along(0, 1);
    if (!across || !down) {
      return std::nullopt;
    }
    Mat2 both;
    both << *across, *down;
    return both;
  }

 private:
  const RigCamera& camera_;
  cv::Mat label_;
  cv::Mat depth_mm_;
};

double longer_side(const Mat2& per_px) {
  const Eigen::Vector2cd values = (per_px.transpose() * per_px).eigenvalues();
  return std::sqrt(values.real().maxCoeff());
}

struct Rendered {
  double seen_m2 = 0;
  double mapped_m2 = 0;           ///< between the distances that a floor camera maps
  std::optional<double> ahead_m;  ///< from the body's edge
  double ahead_px_m = 0;          ///< what a pixel covers there
  std::array<std::optional<double>, kDistances_m.size()> sampling_m;  ///< the median all around
};

/// The mean of what falls into each of some directions from the body's middle.
class AroundTheBody {
 public:
  void add(const Vec2& p_body, double value) {
    const double turns = std::atan2(p_body.y(), p_body.x()) / (2 * std::numbers::pi) + 0.5;
    Bin& bin = bins_[static_cast<std::size_t>(turns * kBins) % kBins];
    bin.sum += value;
    ++bin.count;
  }
  std::optional<double> median() const {
    std::vector<double> means;
    for (const Bin& bin : bins_) {
      if (bin.count > 0) {
        means.push_back(bin.sum / bin.count);
      }
    }
    return means.empty() ? std::nullopt : std::optional(quantile(means, 0.5));
  }

 private:
  static constexpr std::size_t kBins = 180;
  struct Bin {
    double sum = 0;
    int count = 0;
  };
  std::array<Bin, kBins> bins_{};
};

bool in_mapped_range(const RigCamera& camera, const Body& body, const Vec2& p_body) {
  const double heading = floor_heading_rad(camera.T_body_camera);
  const double ahead_m = p_body.dot(Vec2(std::cos(heading), std::sin(heading))) - body.radius_m;
  return camera.floor && ahead_m >= camera.floor->near_m && ahead_m <= camera.floor->far_m;
}

Rendered read_rendered(const FloorPicture& picture, const RigCamera& camera, const Body& body) {
  Rendered out;
  std::array<AroundTheBody, kDistances_m.size()> sampling_m;
  for (int v = 0; v < picture.rows(); ++v) {
    for (int u = 0; u < picture.cols(); ++u) {
      const std::optional<Vec2> p = picture.at(u, v);
      const std::optional<Mat2> per_px = picture.per_px(u, v);
      if (!p || !per_px || p->norm() > kReach_m) {
        continue;
      }
      const double pixel_m2 = std::abs(per_px->determinant());
      out.seen_m2 += pixel_m2;
      out.mapped_m2 += in_mapped_range(camera, body, *p) ? pixel_m2 : 0;
      const double side_m = longer_side(*per_px);
      const double from_edge_m = p->norm() - body.radius_m;
      for (std::size_t i = 0; i < kDistances_m.size(); ++i) {
        if (std::abs(from_edge_m - kDistances_m[i]) < std::max(0.02, side_m / 2)) {
          sampling_m[i].add(*p, side_m);
        }
      }
      const double wide_m = per_px->row(1).cwiseAbs().sum() / 2;   // half a pixel's, along y
      const double ahead_m = per_px->row(0).cwiseAbs().sum() / 2;  // and along x
      const double edge_m = p->x() - ahead_m - body.radius_m;
      if (std::abs(p->y()) <= wide_m && p->x() > body.radius_m &&
          edge_m < out.ahead_m.value_or(kReach_m)) {
        out.ahead_m = std::max(0.0, edge_m);
        out.ahead_px_m = 2 * ahead_m;
      }
    }
  }
  for (std::size_t i = 0; i < kDistances_m.size(); ++i) {
    out.sampling_m[i] = sampling_m[i].median();
  }
  return out;
}

}  // namespace

Rig random_rig(Rng& rng, const Body& body) {
  for (;;) {
    Rig rig;
    const int cameras = 1 + rng.index(4);
    for (int i = 0; i < cameras; ++i) {
      RigCamera& camera = rig.cameras[fmt::format("camera{}", i)];
      camera.intrinsics = drawn_lens(rng);
      camera.T_body_camera =
          mounted_camera(drawn_point(rng, body), rng.uniform(-std::numbers::pi, std::numbers::pi),
                         deg_to_rad(rng.uniform(10, 60)));
      if (i == 0) {
        camera.roles = {"floor"};
        camera.floor.emplace();
        camera.T_body_camera =
            mounted_camera(camera.T_body_camera.translation, deg_to_rad(rng.uniform(-20, 20)),
                           deg_to_rad(rng.uniform(15, 50)));
      }
    }
    if (placement_faults(rig, body).empty()) {
      return rig;
    }
  }
}

void write_bare_floor(const std::filesystem::path& folder, const Rig& rig, const Body& body) {
  std::filesystem::create_directories(folder);
  write_file(folder / "hull.obj", hull_mesh(body));
  write_file(folder / "rig.yaml", write_settings(rig));
  write_file(folder / "robot.yaml", write_settings(body));
  write_file(folder / "world.yaml",
             "ambient: 0.8\n"
             "boxes: [{name: floor, size_m: [24, 24, 0.1], z_m: -0.1, "
             "picture: data:office/carpet_sand.png, picture_m: [2, 2]}]\n"
             "objects: [{name: hull, mesh: hull.obj, up: z}]\n");
  write_file(folder / "mission.yaml",
             "rig: rig.yaml\nrobot: robot.yaml\n"
             "platform: {kind: simulated, world: world.yaml, errors: none, "
             "start: {x_m: 3, y_m: 3}}\n");
}

std::vector<SightComparison> compare_sight(const std::filesystem::path& pictures, const Rig& rig,
                                           const Body& body) {
  const RigSight sight(rig, body);
  const FloorSight floor = floor_sight({kReach_m, kCell_m}, sight);
  std::vector<SightComparison> all;
  std::size_t i = 0;
  for (const auto& [name, camera] : rig.cameras) {
    const FloorPicture picture(pictures, name, camera);
    const Rendered rendered = read_rendered(picture, camera, body);
    const CameraSet bit = camera_bit(i++);
    all.push_back({name + " floor seen, m2", area_m2(floor, floor.seen, bit), rendered.seen_m2, 0});
    if (camera.floor && camera.intrinsics.is_pinhole()) {
      all.push_back(
          {name + " floor mapped, m2", area_m2(floor, floor.mapped, bit), rendered.mapped_m2, 0});
    }
    const auto ahead_m = first_seen_m(sight, bit, false, 0, kReach_m);
    if (ahead_m || rendered.ahead_m) {
      all.push_back({name + " blind ahead, m", ahead_m.value_or(kReach_m),
                     rendered.ahead_m.value_or(kReach_m), rendered.ahead_px_m});
    }
    for (std::size_t k = 0; k < kDistances_m.size(); ++k) {
      const SamplingAt at = sampling_at(sight, bit, false, kDistances_m[k]);
      constexpr double kSome = 0.03;  // of the ring: where little is seen, which part decides
      if (at.median_m && rendered.sampling_m[k] && at.seen_share > kSome) {
        all.push_back({fmt::format("{} sampling at {} m, m", name, kDistances_m[k]), *at.median_m,
                       *rendered.sampling_m[k], 0});
      }
    }
  }
  return all;
}

}  // namespace panoptes::test
