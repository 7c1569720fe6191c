// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/dynamic_lightmap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace panoptes::sim {
namespace {

constexpr double kSteps = 255;  // of the root of a power: one grey level

double rounded(double power) {
  const double root = std::round(std::sqrt(std::max(power, 0.0)) * kSteps) / kSteps;
  return root * root;
}

std::uint8_t root_of(double share) {
  return static_cast<std::uint8_t>(255 * std::sqrt(std::clamp(share, 0.0, 1.0)) + 0.5);
}

}  // namespace

DynamicLightmap::DynamicLightmap(const Charts& charts, BakedLight baked)
    : baked_(std::move(baked)) {
  for (const Chart& chart : charts.charts) {
    if (chart.moves) {
      Chart kept = chart;
      kept.triangles.clear();
      moving_[chart.object].push_back(std::move(kept));
    }
  }
  set_powers({});
}

bool DynamicLightmap::set_powers(const std::map<std::string, double>& powers) {
  std::vector<double> now;
  for (const std::string& group : baked_.groups) {
    const auto given = powers.find(group);
    now.push_back(given == powers.end() ? 1 : rounded(given->second));
  }
  if (now == powers_) {
    return false;
  }
  powers_ = now;
  const double most = std::max(1.0, *std::max_element(now.begin(), now.end()));
  most_light_ = most * kMostLight;
  if (std::all_of(now.begin(), now.end(), [](double p) { return p == 1; }) && now.size() == 1) {
    texels_ = baked_.layers[0].clone();
  } else {
    texels_.create(baked_.layers[0].size(), CV_8U);
    std::vector<std::array<float, 256>> shares(now.size());
    for (std::size_t g = 0; g < now.size(); ++g) {
      for (std::size_t v = 0; v < 256; ++v) {
        const double root = static_cast<double>(v) / 255;
        shares[g][v] = static_cast<float>(now[g] / most * root * root);
      }
    }
    std::vector<float> sums(static_cast<std::size_t>(texels_.cols));
    for (int row = 0; row < texels_.rows; ++row) {
      std::fill(sums.begin(), sums.end(), 0.0F);
      for (std::size_t g = 0; g < now.size(); ++g) {
        const auto* layer = baked_.layers[g].ptr<std::uint8_t>(row);
        for (std::size_t i = 0; i < sums.size(); ++i) {
          sums[i] += shares[g][layer[i]];
        }
      }
      auto* out = texels_.ptr<std::uint8_t>(row);
      for (std::size_t i = 0; i < sums.size(); ++i) {
        out[i] = root_of(sums[i]);
      }
    }
  }
  probes_.assign(baked_.probes.size(), Probes::Cube{});
  for (std::size_t g = 0; g < now.size(); ++g) {
    for (std::size_t i = 0; i < probes_.size(); ++i) {
      for (std::size_t side = 0; side < 6; ++side) {
        probes_[i][side] += static_cast<float>(now[g]) * baked_.probes.groups[g][i][side];
      }
    }
  }
  return true;
}

double DynamicLightmap::light_at(const Vec3& p_scene, const Vec3& normal_scene) const {
  const Probes& grid = baked_.probes;
  std::array<std::size_t, 3> cell{};
  Vec3 share;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const double last = std::max(grid.counts[i] - 1, 0);
    const double at =
        std::clamp((p_scene[axis] - grid.low_scene[axis]) / grid.spacing_m[axis], 0.0, last);
    cell[i] = static_cast<std::size_t>(std::max(0.0, std::min(std::floor(at), last - 1)));
    share[axis] = at - static_cast<double>(cell[i]);
  }
  double light = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::size_t index = 0;
    for (std::size_t i = 3; i-- > 0;) {
      const std::size_t up = corner >> i & 1U;
      const double s = share[static_cast<Eigen::Index>(i)];
      weight *= up == 1 ? s : 1 - s;
      index = index * static_cast<std::size_t>(grid.counts[i]) + cell[i] + up;
    }
    if (weight <= 0) {
      continue;  // also beyond a grid that is flat along an axis
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const double n = normal_scene[static_cast<Eigen::Index>(i)];
      light += weight * n * n * static_cast<double>(probes_[index][2 * i + (n < 0 ? 1 : 0)]);
    }
  }
  return light;
}

cv::Rect DynamicLightmap::light_object(std::size_t object, const Pose3& T_scene_object) {
  const auto found = moving_.find(object);
  if (found == moving_.end()) {
    return {};
  }
  cv::Rect place;
  for (const Chart& chart : found->second) {
    const cv::Rect here(chart.column, chart.row, chart.columns, chart.rows);
    place = place.empty() ? here : (place | here);
    const Vec3 normal_scene = T_scene_object.rotation * chart.normal;
    for (int row = 0; row < chart.rows; ++row) {
      const auto* open = baked_.layers[0].ptr<std::uint8_t>(chart.row + row) + chart.column;
      auto* out = texels_.ptr<std::uint8_t>(chart.row + row) + chart.column;
      for (int column = 0; column < chart.columns; ++column) {
        const Vec3 p_scene = T_scene_object * chart.point(column, row);
        out[column] = root_of(light_at(p_scene, normal_scene) * open[column] / 255.0 / most_light_);
      }
    }
  }
  return place;
}

double DynamicLightmap::power(const std::string& group) const {
  const auto found = std::lower_bound(baked_.groups.begin(), baked_.groups.end(), group);
  return found != baked_.groups.end() && *found == group
             ? powers_[static_cast<std::size_t>(found - baked_.groups.begin())]
             : 1;
}

}  // namespace panoptes::sim
