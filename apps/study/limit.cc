// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study/limit.h"

#include <variant>

#include <fmt/format.h>

#include "apps/report/figure_names.h"
#include "core/base/error.h"
#include "core/config/fields.h"

namespace panoptes {
namespace {

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) {
    return {};
  }
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

}  // namespace

Limit parse_limit(std::string_view text) {
  const auto fault = [&](const std::string& what) {
    return ConfigError("limit '" + std::string(text) + "': " + what);
  };
  constexpr const char* kForm =
      "must be a figure, or a figure / another one, one of == != < <= > >=, and a number";
  const std::size_t slash = text.find('/');
  const bool quotient = slash != std::string_view::npos;
  Limit limit;
  try {
    limit.requirement = parse_requirement(quotient ? text.substr(slash + 1) : text);
  } catch (const ConfigError&) {
    throw fault(kForm);
  }
  limit.text = trimmed(text);
  limit.figure = quotient ? trimmed(text.substr(0, slash)) : limit.requirement.figure;
  limit.divisor = quotient ? limit.requirement.figure : "";
  const auto check = [&](const std::string& figure) {
    if (!is_figure(figure) && !is_calibration_figure(figure)) {
      const std::string near = nearest_word(figure, figure_names());
      throw fault(figure.empty() ? kForm
                                 : "no run has a figure '" + figure + "'" +
                                       (near.empty() ? "" : "; did you mean " + near + "?"));
    }
  };
  check(limit.figure);
  if (quotient) {
    check(limit.divisor);
  }
  if (!std::holds_alternative<double>(limit.requirement.wanted)) {
    throw fault("must be compared with a number");
  }
  return limit;
}

Limit parse_comparison(std::string_view text) {
  Limit limit = parse_limit(text);
  using Op = Requirement::Op;
  const Op op = limit.requirement.op;
  if (!limit.divisor.empty() || op == Op::kEqual || op == Op::kNotEqual) {
    throw ConfigError("'" + std::string(text) +
                      "': must be a figure, one of < <= > >=, and by how much it may differ");
  }
  return limit;
}

std::optional<double> value_of(const Limit& limit, const std::map<std::string, double>& figures) {
  const auto figure = figures.find(limit.figure);
  if (figure == figures.end()) {
    return std::nullopt;
  }
  if (limit.divisor.empty()) {
    return figure->second;
  }
  const auto divisor = figures.find(limit.divisor);
  if (divisor == figures.end()) {
    return std::nullopt;
  }
  return figure->second / divisor->second;
}

std::string broken_by(const Limit& limit, const std::map<std::string, double>& figures) {
  const std::optional<double> value = value_of(limit, figures);
  if (!value) {
    return limit.text + ", no such figure";
  }
  return holds(limit.requirement, *value) ? ""
                                          : fmt::format("{}, it is {:.6g}", limit.text, *value);
}

}  // namespace panoptes
