// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/time.h"

namespace panoptes {

/// Whose hand a table is of.
enum class TableBy {
  kPanoptes,  ///< a last row without an end of line was torn when the recording was cut short, and
              ///< is left out; rows have as many fields as is asked for
  kOthers     ///< such a row is whole; rows have as many fields as the first, or more than is asked
};

/// A table of a EuRoC dataset: a first line that begins with # and names the columns, then rows of
/// fields between commas. Every fault is a ConfigError with the file's name and the line.
class DatasetTable {
 public:
  /// `file` is for messages.
  DatasetTable(std::string file, std::string_view text, std::size_t columns,
               TableBy by = TableBy::kPanoptes);

  std::size_t size() const { return lines_.size(); }
  std::size_t columns() const { return columns_; }
  bool torn() const { return torn_; }
  const std::string& file() const { return file_; }

  const std::string& text(std::size_t row, std::size_t column) const;
  Time stamp(std::size_t row, std::size_t column) const;  ///< whole nanoseconds
  std::int64_t whole(std::size_t row, std::size_t column) const;
  double number(std::size_t row, std::size_t column) const;  ///< not NaN; may be infinite
  double finite(std::size_t row, std::size_t column) const;
  double bounded(std::size_t row, std::size_t column, double most) const;  ///< in [-most, most]

  std::string place(std::size_t row) const;  ///< file:line
  /// What is wrong with a row, with its place.
  ConfigError fault(std::size_t row, const std::string& what) const;

 private:
  std::string file_;
  std::size_t columns_;
  std::vector<std::string> fields_;  // row by row
  std::vector<int> lines_;           // of the rows, counted from 1
  bool torn_ = false;
};

/// One field more for a row: numbers in the fewest digits that read back to the same bits (-0 too),
/// instants in nanoseconds, text without commas and ends of line (they become blanks).
void add_field(std::string& row, double value);
void add_field(std::string& row, std::int64_t value);
void add_field(std::string& row, Time stamp);
void add_field(std::string& row, std::string_view text);

/// A row, its end of line included.
template <class... Fields>
std::string dataset_row(const Fields&... fields) {
  std::string row;
  (add_field(row, fields), ...);
  return row + "\n";
}

}  // namespace panoptes
