// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr int kTabled = 30;  // degrees of freedom

/// A point of Student's t, for 1, 2, .. degrees of freedom, and the normal law's.
struct StudentPoint {
  std::array<double, kTabled> table;
  double normal;

  double at(int degrees_of_freedom) const {
    if (degrees_of_freedom <= kTabled) {
      return table[static_cast<std::size_t>(degrees_of_freedom) - 1];
    }
    // with its first Cornish-Fisher correction
    return normal + (normal * normal * normal + normal) / (4.0 * degrees_of_freedom);
  }
};

constexpr StudentPoint k975{{12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
                             2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086,
                             2.080,  2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042},
                            1.959964};
constexpr StudentPoint k95{{6.314, 2.920, 2.353, 2.132, 2.015, 1.943, 1.895, 1.860, 1.833, 1.812,
                            1.796, 1.782, 1.771, 1.761, 1.753, 1.746, 1.740, 1.734, 1.729, 1.725,
                            1.721, 1.717, 1.714, 1.711, 1.708, 1.706, 1.703, 1.701, 1.699, 1.697},
                           1.644854};
constexpr StudentPoint k80{{1.376, 1.061, 0.978, 0.941, 0.920, 0.906, 0.896, 0.889, 0.883, 0.879,
                            0.876, 0.873, 0.870, 0.868, 0.866, 0.865, 0.863, 0.862, 0.861, 0.860,
                            0.859, 0.858, 0.858, 0.857, 0.856, 0.856, 0.855, 0.855, 0.854, 0.854},
                           0.841621};

}  // namespace

double quantile(std::vector<double> values, double share) {
  PANOPTES_CHECK(!values.empty() && share >= 0 && share <= 1, "a share of at least one value");
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

MeanInterval mean_interval(const std::vector<double>& values) {
  PANOPTES_CHECK(!values.empty(), "a mean of at least one value");
  const auto n = static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) {
    sum += value;
  }
  MeanInterval result;
  result.count = static_cast<int>(values.size());
  result.mean = sum / n;
  double squares = 0;
  for (const double value : values) {
    squares += (value - result.mean) * (value - result.mean);
  }
  const double half =
      values.size() < 2 ? 0 : k975.at(result.count - 1) * std::sqrt(squares / (n - 1) / n);
  result.low = result.mean - half;
  result.high = result.mean + half;
  return result;
}

PairedDifference paired_difference(const std::vector<double>& values,
                                   const std::vector<double>& others) {
  PANOPTES_CHECK(values.size() == others.size(), "pairs");
  std::vector<double> differences(values.size());
  std::transform(values.begin(), values.end(), others.begin(), differences.begin(),
                 [](double value, double other) { return value - other; });
  PairedDifference result;
  result.mean = mean_interval(differences);
  const int degrees_of_freedom = result.mean.count - 1;
  result.at_least = result.at_most = result.mean.mean;
  if (degrees_of_freedom == 0) {
    result.detectable = std::numeric_limits<double>::infinity();
    return result;
  }
  const double half = 0.5 * (result.mean.high - result.mean.low);
  const double one_sided = half * k95.at(degrees_of_freedom) / k975.at(degrees_of_freedom);
  result.at_least -= one_sided;
  result.at_most += one_sided;
  result.detectable = half * (1 + k80.at(degrees_of_freedom) / k975.at(degrees_of_freedom));
  return result;
}

}  // namespace panoptes
