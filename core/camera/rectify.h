// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include <opencv2/core/mat.hpp>

#include "core/camera/observation.h"
#include "core/camera/rig.h"

namespace panoptes {

/// The widest pinhole (up to 55 degrees off the axis each way) with the same axis and size whose
/// picture lies inside of what the lens sees.
Intrinsics rectified(const Intrinsics& lens);

/// Makes the pictures of pinholes from those of lenses that bend, so that whoever comes after needs
/// to know straight lines alone. Pictures of pinholes go through as they are, at no cost.
class Rectifier {
 public:
  explicit Rectifier(const Rig& raw);

  /// The rig that the pictures made here are of; floor marks lie where they are seen now, and
  /// sigmas are of its pixels. (A mark that the pinhole does not see any more lies outside of its
  /// picture; one more than 89 degrees off the axis is left out.)
  const Rig& rig() const { return rig_; }

  /// Whether any camera's pictures have to be made anew.
  bool bends() const { return !maps_.empty(); }

  Observation rectified(const Observation& raw) const;

 private:
  struct Maps {
    cv::Mat whole;  // whole pixels and 32nds of them, as cv::remap wants them
    cv::Mat part;
  };
  Rig rig_;
  std::map<std::string, Maps> maps_;
};

}  // namespace panoptes
