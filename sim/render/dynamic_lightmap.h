// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "sim/render/lightmap.h"

namespace panoptes::sim {

/// The lightmap at an instant: the layers of the light groups by their powers, and on what moves
/// the light of the place where it is. It depends on that scene state alone, not on earlier ones:
/// powers are rounded to steps too small to be seen, so that a slow change is not worked out anew
/// each time.
class DynamicLightmap {
 public:
  DynamicLightmap(const Charts& charts, BakedLight baked);

  /// Brings it to the powers of the groups that are not at 1. Returns whether everything changed.
  bool set_powers(const std::map<std::string, double>& powers);

  /// Lights what moves where it is. Returns the place in the lightmap that changed; empty for an
  /// object that has no charts.
  cv::Rect light_object(std::size_t object, const Pose3& T_scene_object);

  const cv::Mat& texels() const { return texels_; }  ///< roots of the share of most_light(), 8-bit
  double most_light() const { return most_light_; }
  double power(const std::string& group) const;

 private:
  double light_at(const Vec3& p_scene, const Vec3& normal_scene) const;

  BakedLight baked_;
  std::map<std::size_t, std::vector<Chart>> moving_;  ///< by object, without their triangles
  std::vector<double> powers_;                        ///< of each group
  std::vector<Probes::Cube> probes_;                  ///< of all groups together
  cv::Mat texels_;
  double most_light_ = kMostLight;
};

}  // namespace panoptes::sim
