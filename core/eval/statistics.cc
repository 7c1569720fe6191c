// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <boost/math/distributions/students_t.hpp>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr double kLevel = 0.05;
constexpr double kPower = 0.8;

/// The point below which Student's t lies with this probability.
double student(int degrees_of_freedom, double probability) {
  return boost::math::quantile(boost::math::students_t(degrees_of_freedom), probability);
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
  const double half = values.size() < 2 ? 0
                                        : student(result.count - 1, 1 - kLevel / 2) *
                                              std::sqrt(squares / (n - 1) / n);
  result.low = result.mean - half;
  result.high = result.mean + half;
  return result;
}

double standard_error_of(const MeanInterval& mean) {
  return mean.count < 2 ? 0
                        : 0.5 * (mean.high - mean.low) / student(mean.count - 1, 1 - kLevel / 2);
}

double detectable_difference(double standard_error, int degrees_of_freedom, double level) {
  return standard_error *
         (student(degrees_of_freedom, 1 - level / 2) + student(degrees_of_freedom, kPower));
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
    result.detectable = result.detectable_one_sided = std::numeric_limits<double>::infinity();
    return result;
  }
  const double standard_error = standard_error_of(result.mean);
  result.at_least -= standard_error * student(degrees_of_freedom, 1 - kLevel);
  result.at_most += standard_error * student(degrees_of_freedom, 1 - kLevel);
  result.detectable = detectable_difference(standard_error, degrees_of_freedom, kLevel);
  result.detectable_one_sided =
      detectable_difference(standard_error, degrees_of_freedom, 2 * kLevel);
  return result;
}

}  // namespace panoptes
