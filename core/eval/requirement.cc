// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/requirement.h"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/error.h"

namespace panoptes {
namespace {

constexpr std::array<std::pair<std::string_view, Requirement::Op>, 6> kOps = {{
    {"==", Requirement::Op::kEqual},
    {"!=", Requirement::Op::kNotEqual},
    {"<=", Requirement::Op::kLessEqual},  // before "<"
    {">=", Requirement::Op::kGreaterEqual},
    {"<", Requirement::Op::kLess},
    {">", Requirement::Op::kGreater},
}};

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) {
    return {};
  }
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

bool only(std::string_view text, std::string_view allowed) {
  return !text.empty() && text.find_first_not_of(allowed) == std::string_view::npos;
}

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

template <class T>
bool compare(Requirement::Op op, const T& a, const T& b) {
  switch (op) {
    case Requirement::Op::kEqual:
      return a == b;
    case Requirement::Op::kNotEqual:
      return a != b;
    case Requirement::Op::kLess:
      return a < b;
    case Requirement::Op::kLessEqual:
      return a <= b;
    case Requirement::Op::kGreater:
      return a > b;
    case Requirement::Op::kGreaterEqual:
      return a >= b;
  }
  return false;
}

}  // namespace

Requirement parse_requirement(std::string_view text) {
  constexpr std::string_view kLetters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.";
  const auto fault = [&](const std::string& what) {
    return ConfigError("requirement '" + std::string(text) + "': " + what);
  };
  const auto at = text.find_first_of("=!<>");
  if (at == std::string_view::npos) {
    throw fault("must be a figure, one of == != < <= > >=, and a value");
  }
  Requirement requirement;
  requirement.text = trimmed(text);
  requirement.figure = trimmed(text.substr(0, at));
  std::string_view rest = text.substr(at);
  bool known = false;
  for (const auto& [sign, op] : kOps) {
    if (rest.starts_with(sign)) {
      requirement.op = op;
      rest.remove_prefix(sign.size());
      known = true;
      break;
    }
  }
  const std::string_view wanted = trimmed(rest);
  if (!known || !only(requirement.figure, kLetters)) {
    throw fault("must be a figure, one of == != < <= > >=, and a value");
  }
  if (const std::optional<double> value = number(wanted)) {
    requirement.wanted = *value;
    return requirement;
  }
  if (!only(wanted, kLetters)) {
    throw fault("the value must be a number or a word");
  }
  if (requirement.op != Requirement::Op::kEqual && requirement.op != Requirement::Op::kNotEqual) {
    throw fault("a word can only be compared by == or !=");
  }
  requirement.wanted = std::string(wanted);
  return requirement;
}

bool holds(const Requirement& requirement, double value) {
  const auto* wanted = std::get_if<double>(&requirement.wanted);
  return wanted != nullptr && std::isfinite(value) && compare(requirement.op, value, *wanted);
}

bool holds(const Requirement& requirement, std::string_view value) {
  const auto* wanted = std::get_if<std::string>(&requirement.wanted);
  return wanted != nullptr && compare(requirement.op, value, std::string_view(*wanted));
}

}  // namespace panoptes
