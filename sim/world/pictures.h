// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "sim/world/faults.h"
#include "sim/world/world.h"

namespace panoptes::sim {

/// The textures of a world, each read once. What is wrong with one is said once, where it is first
/// mentioned.
class Pictures {
 public:
  Pictures(std::vector<Texture>& textures, Faults& faults) : textures_(textures), faults_(faults) {}

  int from_file(const std::string& file, const std::string& mention);
  /// From a picture file's bytes inside of another file.
  int from_bytes(const std::string& name, const std::string& bytes, const std::string& mention);
  /// Decoded already.
  int from_pixels(const std::string& name, const cv::Mat& bgr);
  /// Amounts of light from 0 to 1; pictures hold their square roots.
  int plain(double red, double green, double blue);

  const cv::Mat& at(int texture) const {  ///< empty when it could not be read
    return textures_[static_cast<std::size_t>(texture)].bgr;
  }

 private:
  template <class Read>
  int find_or_add(const std::string& name, const std::string& mention, const Read& read);

  std::vector<Texture>& textures_;
  Faults& faults_;
  std::map<std::string, int> index_;
};

}  // namespace panoptes::sim
