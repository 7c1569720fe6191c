// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/time.h"
#include "core/io/file.h"

namespace panoptes {

/// A comma-separated table (RFC 4180) that grows a row at a time: fields by <<, numbers in shortest
/// digits, instants in seconds, text quoted where it must be; empty fields by skip(). It appears
/// under its name at finish().
class CsvWriter {
 public:
  CsvWriter(const std::filesystem::path& path, const std::vector<std::string>& columns);

  CsvWriter& operator<<(double value);
  CsvWriter& operator<<(int value);
  CsvWriter& operator<<(Time stamp);
  CsvWriter& operator<<(std::string_view text);
  CsvWriter& skip();
  void end_row();   ///< the row must have as many fields as there are columns
  void drop_row();  ///< what was said of a row that did not come to its end
  void finish();

 private:
  void separate();

  AtomicFile file_;
  std::size_t columns_;
  std::size_t fields_ = 0;
  std::string row_;
};

struct CsvTable {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::string file;        ///< for messages
  std::vector<int> lines;  ///< on which each row begins, counted from 1

  /// The index of a column; throws IoError when there is none.
  std::size_t column(std::string_view name) const;

  /// A field as a finite number, as a whole one and as an instant; throws IoError with the file and
  /// line where it is none.
  double number(std::size_t row, std::size_t column) const;
  int whole(std::size_t row, std::size_t column) const;
  Time stamp(std::size_t row, std::size_t column) const;

  /// What is wrong with a row, with its place.
  IoError fault(std::size_t row, const std::string& what) const;
};

CsvTable read_csv(const std::filesystem::path& path);

/// The same from text; `name` stands for the file in what is said.
CsvTable parse_csv(const std::string& name, std::string_view text);

/// A row as CsvWriter writes it, for a table that grows otherwise; its end of line included.
std::string csv_row(const std::vector<std::string>& fields);

}  // namespace panoptes
