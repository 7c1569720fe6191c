// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/brown_conrady.h"

namespace panoptes {

Vec2 bent(const BrownConrady& o, const Vec2& p) {
  const double x = p.x();
  const double y = p.y();
  const double r2 = x * x + y * y;
  const double c = 1 + r2 * (o.k1 + r2 * (o.k2 + r2 * o.k3));
  return {x * c + 2 * o.p1 * x * y + o.p2 * (r2 + 2 * x * x),
          y * c + o.p1 * (r2 + 2 * y * y) + 2 * o.p2 * x * y};
}

Eigen::Matrix2d bent_jacobian(const BrownConrady& o, const Vec2& p) {
  const double x = p.x();
  const double y = p.y();
  const double r2 = x * x + y * y;
  const double c = 1 + r2 * (o.k1 + r2 * (o.k2 + r2 * o.k3));
  const double dc = o.k1 + r2 * (2 * o.k2 + r2 * 3 * o.k3);
  Eigen::Matrix2d J;
  J(0, 0) = c + 2 * x * x * dc + 2 * o.p1 * y + 6 * o.p2 * x;
  J(0, 1) = 2 * x * y * dc + 2 * o.p1 * x + 2 * o.p2 * y;
  J(1, 0) = J(0, 1);
  J(1, 1) = c + 2 * y * y * dc + 6 * o.p1 * y + 2 * o.p2 * x;
  return J;
}

}  // namespace panoptes
