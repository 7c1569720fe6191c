// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/dataset_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/base/utf8.h"
#include "core/io/digits.h"

namespace panoptes {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto from = text.find_first_not_of(" \t\r");
  return from == std::string_view::npos
             ? std::string_view()
             : text.substr(from, text.find_last_not_of(" \t\r") + 1 - from);
}

// A few characters of what stands there.
std::string shown(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string some(text.substr(0, kLongest));
  for (char& c : some) {
    c = static_cast<unsigned char>(c) < ' ' || c == 0x7f ? '?' : c;
  }
  return text.empty() ? "nothing" : some + (text.size() > kLongest ? "..." : "");
}

template <class Number>
bool parse(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

void separate(std::string& row) { row += row.empty() ? "" : ","; }

}  // namespace

DatasetTable::DatasetTable(std::string file, std::string_view text, std::size_t columns, TableBy by)
    : file_(std::move(file)), columns_(columns) {
  text = without_byte_order_mark(text);
  const auto place = [this](int line) { return file_ + ":" + std::to_string(line) + ": "; };
  int line = 0;
  while (!text.empty()) {
    ++line;
    const auto end = text.find('\n');
    if (end == std::string_view::npos && by == TableBy::kPanoptes) {
      torn_ = true;
      break;
    }
    std::string_view rest = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line == 1 && !rest.starts_with('#')) {
      throw ConfigError(place(line) + "must name the columns, after a #; it holds " + shown(rest));
    }
    if (rest.empty() || rest.front() == '#') {
      continue;
    }
    const auto count = 1 + static_cast<std::size_t>(std::count(rest.begin(), rest.end(), ','));
    if (by == TableBy::kOthers && lines_.empty()) {
      columns_ = std::max(columns, count);
    }
    if (count != columns_) {
      throw ConfigError(place(line) + "has " + std::to_string(count) + " fields, must have " +
                        std::to_string(columns_));
    }
    for (std::size_t column = 0; column < columns_; ++column) {
      const auto comma = std::min(rest.find(','), rest.size());
      fields_.emplace_back(trimmed(rest.substr(0, comma)));
      rest.remove_prefix(std::min(comma + 1, rest.size()));
    }
    lines_.push_back(line);
  }
  if (line == 0 || (line == 1 && torn_)) {
    throw ConfigError(place(1) + "must name the columns, after a #; the file ends before");
  }
}

const std::string& DatasetTable::text(std::size_t row, std::size_t column) const {
  PANOPTES_CHECK(row < lines_.size() && column < columns_, "the table has this field");
  return fields_[row * columns_ + column];
}

std::int64_t DatasetTable::whole(std::size_t row, std::size_t column) const {
  std::int64_t value = 0;
  if (!parse(text(row, column), value)) {
    throw fault(row, "field " + std::to_string(column + 1) + " must be a whole number, got " +
                         shown(text(row, column)));
  }
  return value;
}

Time DatasetTable::stamp(std::size_t row, std::size_t column) const {
  constexpr std::int64_t kMost_ns = 4'000'000'000'000'000'000;  // sums of two stay in 64 bits
  const std::int64_t ns = whole(row, column);
  if (ns < -kMost_ns || ns > kMost_ns) {
    throw fault(row, "field " + std::to_string(column + 1) + " is no instant in nanoseconds, got " +
                         text(row, column));
  }
  return Time(Duration(ns));
}

double DatasetTable::number(std::size_t row, std::size_t column) const {
  double value = 0;
  if (!parse(text(row, column), value) || std::isnan(value)) {
    throw fault(row, "field " + std::to_string(column + 1) + " must be a number, got " +
                         shown(text(row, column)));
  }
  return value;
}

double DatasetTable::finite(std::size_t row, std::size_t column) const {
  const double value = number(row, column);
  if (!std::isfinite(value)) {
    throw fault(row, "field " + std::to_string(column + 1) + " must be finite, got " +
                         shown(text(row, column)));
  }
  return value;
}

double DatasetTable::bounded(std::size_t row, std::size_t column, double most) const {
  const double value = finite(row, column);
  if (std::abs(value) > most) {
    throw fault(row, "field " + std::to_string(column + 1) + " must be from " + shortest(-most) +
                         " to " + shortest(most) + ", got " + shown(text(row, column)));
  }
  return value;
}

std::string DatasetTable::place(std::size_t row) const {
  return file_ + ":" + std::to_string(lines_.at(row));
}

ConfigError DatasetTable::fault(std::size_t row, const std::string& what) const {
  return ConfigError(place(row) + ": " + what);
}

void add_field(std::string& row, double value) {
  separate(row);
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  row.append(digits.data(), end.ptr);
}

void add_field(std::string& row, std::int64_t value) {
  separate(row);
  row += std::to_string(value);
}

void add_field(std::string& row, Time stamp) { add_field(row, stamp.time_since_epoch().count()); }

void add_field(std::string& row, std::string_view text) {
  separate(row);
  for (const char c : text) {
    row += c == ',' || static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
}

}  // namespace panoptes
