// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <variant>

namespace panoptes {

/// A line of a mission's `require:`, such as `map.coverage >= 0.85` or `outcome == completed`.
struct Requirement {
  enum class Op { kEqual, kNotEqual, kLess, kLessEqual, kGreater, kGreaterEqual };
  std::string text;    ///< as written
  std::string figure;  ///< dotted path into metrics.json
  Op op = Op::kEqual;
  std::variant<double, std::string> wanted;
};

/// Throws ConfigError, in one line that names what is allowed.
Requirement parse_requirement(std::string_view text);

bool holds(const Requirement& requirement, double value);
bool holds(const Requirement& requirement, std::string_view value);

}  // namespace panoptes
