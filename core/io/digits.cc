// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/digits.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <system_error>

#include "core/base/check.h"

namespace panoptes {

std::string shortest(double value) {
  PANOPTES_CHECK(std::isfinite(value), "only finite numbers are written");
  std::array<char, 32> digits{};
  const auto end =
      std::to_chars(digits.data(), digits.data() + digits.size(), value == 0 ? 0.0 : value);
  return {digits.data(), end.ptr};
}

std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') {
    text.remove_prefix(1);
  }
  double value = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::string seconds(Time stamp) {
  const std::int64_t ns = stamp.time_since_epoch().count();
  const std::uint64_t size =
      ns < 0 ? -static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  std::string text = ns < 0 ? "-" : "";
  text += std::to_string(size / 1'000'000'000U);
  std::string fraction = std::to_string(size % 1'000'000'000U);
  fraction.insert(0, 9 - fraction.size(), '0');
  fraction.erase(fraction.find_last_not_of('0') + 1);
  return fraction.empty() ? text : text + "." + fraction;
}

std::optional<Time> parse_seconds(std::string_view text) {
  const std::optional<double> value = parse_number(text);
  constexpr double kMost_s = 9.2e9;  // int64 nanoseconds
  if (!value || std::abs(*value) > kMost_s) {
    return std::nullopt;
  }
  if (text.find_first_of("eE") != std::string_view::npos) {
    return time_at(*value);
  }
  const bool negative = text.front() == '-';
  if (negative || text.front() == '+') {
    text.remove_prefix(1);
  }
  std::int64_t ns = 0;
  std::int64_t unit = 1'000'000'000;
  bool after_point = false;
  for (const char c : text) {
    if (c == '.') {
      after_point = true;
      continue;
    }
    const int digit = c - '0';
    if (!after_point) {
      ns = ns * 10 + digit * std::int64_t{1'000'000'000};
    } else if (unit > 1) {
      unit /= 10;
      ns += digit * unit;
    } else {
      ns += digit >= 5 ? 1 : 0;
      break;
    }
  }
  return Time(Duration(negative ? -ns : ns));
}

}  // namespace panoptes
