// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/eval/requirement.h"

namespace panoptes {

/// What the runs of a study have to hold: a figure of metrics.json, or one divided by another,
/// against a number. `loops.false == 0`, `trajectory.ate_rmse_m / trajectory.odometry_ate_rmse_m <=
/// 1`.
struct Limit {
  std::string text;  ///< as written
  std::string figure;
  std::string divisor;      ///< empty: the figure itself is compared
  Requirement requirement;  ///< of the figure, or of the quotient
};

/// Throws ConfigError, in one line that names what is allowed.
Limit parse_limit(std::string_view text);

/// The same of how much a figure may differ from another run's: no quotient, and no equality.
Limit parse_comparison(std::string_view text);

/// What is compared; empty where the run has no such figure.
std::optional<double> value_of(const Limit& limit, const std::map<std::string, double>& figures);

/// Why the limit is broken, in words; empty when it holds. A figure that is absent breaks it.
std::string broken_by(const Limit& limit, const std::map<std::string, double>& figures);

}  // namespace panoptes
