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

/// Of the mean; 0 of one value.
double standard_error_of(const MeanInterval& mean);

/// The true difference that a two-sided test at this level shows four times out of five (Bloom
/// 1995), where the difference of means has this standard error.
double detectable_difference(double standard_error, int degrees_of_freedom, double level);

/// By how much values are larger than others that differ from them, each from its own, in one thing
/// alone: runs of the same seeds under two settings.
struct PairedDifference {
  MeanInterval mean;
  /// A true difference of this size shows four times out of five. 0 where all pairs differ by the
  /// same; infinite for one pair.
  double detectable = 0;
  double detectable_one_sided = 0;  ///< the same by one of the bounds below
  /// Bounds that the true difference is above and below, each with 95 %; the mean for one pair.
  double at_least = 0;
  double at_most = 0;

  /// The interval keeps clear of 0.
  bool shows() const { return mean.count > 1 && (mean.low > 0 || mean.high < 0); }
};
/// `values` and `others` pair by pair: as many, and at least one.
PairedDifference paired_difference(const std::vector<double>& values,
                                   const std::vector<double>& others);

}  // namespace panoptes
