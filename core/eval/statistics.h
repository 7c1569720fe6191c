// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace panoptes {

/// The value below which this share of the values lies, linear between neighbours (the median is
/// 0.5). There must be at least one value.
double quantile(std::vector<double> values, double share);

struct MeanInterval {
  int count = 0;
  double mean = 0;
  double low = 0;  ///< 95 % interval of the mean by Student's t; the mean itself for one value
  double high = 0;
};
MeanInterval mean_interval(const std::vector<double>& values);

}  // namespace panoptes
