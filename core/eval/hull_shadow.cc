// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/hull_shadow.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace panoptes {
namespace {

constexpr double kHousing_m = 0.03;  // a Flea2 is a cube of 3 cm

/// Across, along and out of a side of the cube; sides 0 to 2 look along x, y, z, 3 to 5 against.
Vec3 on_side(const Vec3& p_eye, int side) {
  const int out = side % 3;
  return {p_eye[(out + 1) % 3], p_eye[(out + 2) % 3], side < 3 ? p_eye[out] : -p_eye[out]};
}

int side_of(const Vec3& p_eye) {
  int out = 0;
  p_eye.cwiseAbs().maxCoeff(&out);
  return p_eye[out] >= 0 ? out : out + 3;
}

/// Surely nothing of it is seen through the side.
bool is_beside(const Face& face) {
  const auto all = [&](const auto& outside) {
    return std::all_of(face.begin(), face.end(), outside);
  };
  return all([](const Vec3& p) { return p.x() > p.z(); }) ||
         all([](const Vec3& p) { return -p.x() > p.z(); }) ||
         all([](const Vec3& p) { return p.y() > p.z(); }) ||
         all([](const Vec3& p) { return -p.y() > p.z(); });
}

}  // namespace

HullShadow::HullShadow(const std::vector<Face>& faces, const Vec3& eye_body) : eye_body_(eye_body) {
  for (int side = 0; side < kSides; ++side) {
    std::vector<float>& depths_m = depths_m_[static_cast<std::size_t>(side)];
    depths_m.assign(std::size_t{kCells} * kCells, std::numeric_limits<float>::infinity());
    for (const Face& face : faces) {
      const Face seen = {on_side(face[0] - eye_body, side), on_side(face[1] - eye_body, side),
                         on_side(face[2] - eye_body, side)};
      if (!is_beside(seen)) {
        draw(seen, depths_m);
      }
    }
  }
}

void HullShadow::draw(const Face& face, std::vector<float>& depths_m) {
  const auto& [a, b, c] = face;
  const Vec3 normal = (b - a).cross(c - a);
  const double off = normal.dot(a);
  // Whether a ray passes between its corners, without dividing: as a corner behind the eye has no
  // picture (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997).
  const std::array<Vec3, 3> edges = {a.cross(b), b.cross(c), c.cross(a)};
  std::array<int, 4> box = {0, kCells - 1, 0, kCells - 1};
  if (a.z() > 0 && b.z() > 0 && c.z() > 0) {
    const auto cells = [](double least, double most, int* from, int* to) {
      *from = std::max(0, static_cast<int>(std::floor(cell_at(std::max(-1.0, least)))));
      *to = std::min(kCells - 1, static_cast<int>(std::ceil(cell_at(std::min(1.0, most)))));
    };
    const auto [left, right] = std::minmax({a.x() / a.z(), b.x() / b.z(), c.x() / c.z()});
    const auto [low, high] = std::minmax({a.y() / a.z(), b.y() / b.z(), c.y() / c.z()});
    cells(left, right, &box[0], &box[1]);
    cells(low, high, &box[2], &box[3]);
  }
  for (int row = box[2]; row <= box[3]; ++row) {
    for (int column = box[0]; column <= box[1]; ++column) {
      const Vec3 ray(middle(column), middle(row), 1);
      const double s0 = ray.dot(edges[0]);
      const double s1 = ray.dot(edges[1]);
      const double s2 = ray.dot(edges[2]);
      if (!((s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0))) {
        continue;
      }
      const double depth_m = off / normal.dot(ray);
      if (depth_m * ray.norm() > kHousing_m) {  // neither behind nor, seen edge on, not a number
        float& nearest_m = depths_m[static_cast<std::size_t>(row) * kCells + column];
        nearest_m = std::min(nearest_m, static_cast<float>(depth_m));
      }
    }
  }
}

bool HullShadow::hides(const Vec3& p_body) const {
  const Vec3 p_eye = p_body - eye_body_;
  const int side = side_of(p_eye);
  const Vec3 p = on_side(p_eye, side);
  if (!(p.z() > 0)) {
    return false;
  }
  const auto cell = [](double tangent) {
    return std::clamp(static_cast<int>(cell_at(tangent)), 0, kCells - 1);
  };
  const std::size_t at =
      static_cast<std::size_t>(cell(p.y() / p.z())) * kCells + cell(p.x() / p.z());
  return depths_m_[static_cast<std::size_t>(side)][at] < p.z();
}

bool inside_hull(const std::vector<Face>& faces, const Vec3& eye_body) {
  // From inside a line crosses the surface an odd number of times. Most lines tell, where a mesh
  // has holes or one meets an edge.
  constexpr int kLines = 15;
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  int odd = 0;
  for (int k = 0; k < kLines; ++k) {
    const double z = 1 - (2 * k + 1.0) / kLines;
    const double r = std::sqrt(1 - z * z);
    const Vec3 line(r * std::cos(turn * k), r * std::sin(turn * k), z);
    int crossings = 0;
    for (const Face& face : faces) {
      Mat3 A;
      A << face[1] - face[0], face[2] - face[0], -line;
      const double det = A.determinant();
      const Vec3 from_corner = eye_body - face[0];
      // By Cramer's rule (Moeller and Trumbore, 1997).
      const double u = A.col(1).cross(A.col(2)).dot(from_corner) / det;
      const double v = A.col(2).cross(A.col(0)).dot(from_corner) / det;
      const double length_m = A.col(0).cross(A.col(1)).dot(from_corner) / det;
      crossings += u >= 0 && v >= 0 && u + v <= 1 && length_m > kHousing_m ? 1 : 0;
    }
    odd += crossings % 2;
  }
  return 2 * odd > kLines;
}

}  // namespace panoptes
