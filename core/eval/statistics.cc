// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"

namespace panoptes {
namespace {

/// 97.5 % point of Student's t.
double student_t(int degrees_of_freedom) {
  constexpr std::array kTable = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306,
                                 2.262,  2.228, 2.201, 2.179, 2.160, 2.145, 2.131, 2.120,
                                 2.110,  2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064,
                                 2.060,  2.056, 2.052, 2.048, 2.045, 2.042};
  if (degrees_of_freedom <= static_cast<int>(kTable.size())) {
    return kTable[static_cast<std::size_t>(degrees_of_freedom) - 1];
  }
  constexpr double kNormal = 1.959964;  // and its first Cornish-Fisher correction
  return kNormal + (kNormal * kNormal * kNormal + kNormal) / (4.0 * degrees_of_freedom);
}

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
      values.size() < 2 ? 0 : student_t(result.count - 1) * std::sqrt(squares / (n - 1) / n);
  result.low = result.mean - half;
  result.high = result.mean + half;
  return result;
}

}  // namespace panoptes
