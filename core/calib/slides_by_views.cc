// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/slides_by_views.h"

#include <cmath>

#include <Eigen/Geometry>

#include "core/base/check.h"

namespace panoptes {

std::vector<BySlides> slides_by_views(const std::vector<RigSeen>& seen,
                                      const std::vector<Vec3>& ray_start, std::size_t points) {
  PANOPTES_CHECK(seen.size() == ray_start.size(), "a ray of each that is seen");
  struct Mean {
    Vec3 direction = Vec3::Zero();  // of length `count`, about
    double log_far = 0;
    double aside = 0;
    int count = 0;
  };
  std::vector<Mean> means(points);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i].believed) {
      Mean& mean = means[seen[i].point];
      mean.direction += ray_start[i].normalized();
      mean.log_far += std::log(ray_start[i].norm());
      ++mean.count;
    }
  }
  const auto across = [](const Mean& mean) -> Vec3 {
    return Vec3::UnitZ().cross(mean.direction).normalized();
  };
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i].believed) {
      Mean& mean = means[seen[i].point];
      mean.aside += across(mean).dot(ray_start[i].normalized());
    }
  }
  std::vector<BySlides> out(seen.size(), BySlides::Zero(3, kSlides));
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Mean& mean = means[seen[i].point];
    if (mean.count > 0) {
      const Vec3 x = across(mean);
      const Vec3 y = mean.direction.normalized().cross(x);
      const double nearer = mean.log_far / mean.count - std::log(ray_start[i].norm());
      const double aside = x.dot(ray_start[i].normalized()) - mean.aside / mean.count;
      out[i] << nearer * x, nearer * y, aside * x, aside * y;
    }
  }
  return out;
}

}  // namespace panoptes
