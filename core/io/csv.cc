// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/csv.h"

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/check.h"
#include "core/base/utf8.h"
#include "core/io/digits.h"

namespace panoptes {
namespace {

std::string escaped(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    return std::string(text);
  }
  std::string all = "\"";
  for (const char c : text) {
    all += c;
    if (c == '"') {
      all += '"';
    }
  }
  return all + "\"";
}

}  // namespace

CsvWriter::CsvWriter(const std::filesystem::path& path, const std::vector<std::string>& columns)
    : file_(path), columns_(columns.size()) {
  for (const std::string& column : columns) {
    *this << column;
  }
  end_row();
}

void CsvWriter::separate() {
  if (fields_++ > 0) {
    row_ += ',';
  }
}

CsvWriter& CsvWriter::operator<<(double value) {
  separate();
  row_ += shortest(value);
  return *this;
}

CsvWriter& CsvWriter::operator<<(int value) {
  separate();
  row_ += std::to_string(value);
  return *this;
}

CsvWriter& CsvWriter::operator<<(Time stamp) {
  separate();
  row_ += seconds(stamp);
  return *this;
}

CsvWriter& CsvWriter::operator<<(std::string_view text) {
  separate();
  row_ += escaped(text);
  return *this;
}

CsvWriter& CsvWriter::skip() {
  separate();
  return *this;
}

void CsvWriter::end_row() {
  PANOPTES_CHECK(fields_ == columns_, "a row has a field for every column");
  row_ += '\n';
  file_.append(row_);
  drop_row();
}

void CsvWriter::drop_row() {
  row_.clear();
  fields_ = 0;
}

void CsvWriter::finish() {
  PANOPTES_CHECK(fields_ == 0, "the last row was ended");
  file_.commit();
}

std::size_t CsvTable::column(std::string_view name) const {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] == name) {
      return i;
    }
  }
  throw IoError("a table has no column " + std::string(name));
}

IoError CsvTable::fault(std::size_t row, const std::string& what) const {
  return IoError(file + ":" + std::to_string(lines.at(row)) + ": " + what);
}

double CsvTable::number(std::size_t row, std::size_t column) const {
  const std::optional<double> value = parse_number(rows.at(row).at(column));
  if (!value) {
    throw fault(row, columns.at(column) + " must be a number, got '" + rows[row][column] + "'");
  }
  return *value;
}

int CsvTable::whole(std::size_t row, std::size_t column) const {
  const double value = number(row, column);
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
    throw fault(row,
                columns.at(column) + " must be a whole number, got '" + rows[row][column] + "'");
  }
  return static_cast<int>(value);
}

Time CsvTable::stamp(std::size_t row, std::size_t column) const {
  const std::optional<Time> value = parse_seconds(rows.at(row).at(column));
  if (!value) {
    throw fault(row, columns.at(column) + " must be an instant in seconds, got '" +
                         rows[row][column] + "'");
  }
  return *value;
}

std::string csv_row(const std::vector<std::string>& fields) {
  std::string row;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    row += i > 0 ? "," : "";
    row += escaped(fields[i]);
  }
  return row + "\n";
}

CsvTable read_csv(const std::filesystem::path& path) {
  return parse_csv(path.string(), read_file(path));
}

CsvTable parse_csv(const std::string& name, std::string_view text) {
  text = without_byte_order_mark(text);
  std::vector<std::vector<std::string>> rows;
  std::vector<int> lines;
  int line = 1;
  std::vector<std::string> row;
  std::string field;
  bool inside_quotes = false;
  bool row_open = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (!row_open) {
      lines.push_back(line);
    }
    line += c == '\n' ? 1 : 0;
    row_open = true;
    if (inside_quotes) {
      if (c != '"') {
        field += c;
      } else if (i + 1 < text.size() && text[i + 1] == '"') {
        field += '"';
        ++i;
      } else {
        inside_quotes = false;
      }
    } else if (c == '"') {
      inside_quotes = true;
    } else if (c == ',') {
      row.push_back(std::exchange(field, {}));
    } else if (c == '\n') {
      row.push_back(std::exchange(field, {}));
      rows.push_back(std::exchange(row, {}));
      row_open = false;
    } else if (c != '\r') {
      field += c;
    }
  }
  if (inside_quotes) {
    throw IoError(name + ": ends inside a quoted field");
  }
  if (row_open) {
    row.push_back(field);
    rows.push_back(row);
  }
  if (rows.empty()) {
    throw IoError(name + ": has no header line");
  }
  // Empty lines at the end, where a row has more than one field.
  while (rows.front().size() > 1 && rows.back().size() == 1 && rows.back().front().empty()) {
    rows.pop_back();
    lines.pop_back();
  }
  CsvTable table;
  table.file = name;
  table.columns = std::move(rows.front());
  rows.erase(rows.begin());
  lines.erase(lines.begin());
  table.lines = std::move(lines);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].size() != table.columns.size()) {
      throw IoError(name + ": row " + std::to_string(i + 1) + " has " +
                    std::to_string(rows[i].size()) + " fields, the header " +
                    std::to_string(table.columns.size()));
    }
  }
  table.rows = std::move(rows);
  return table;
}

}  // namespace panoptes
