// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace panoptes {

/// The names of a run's figures, dotted paths into its metrics.json, in the order of the file.
struct FigureNames {
  std::vector<std::string> names;
  std::map<std::string, std::size_t, std::less<>> at;
};

/// The numbers of a run's metrics.json. Of many runs the names are kept once.
class FigureRow {
 public:
  FigureRow() = default;
  FigureRow(std::shared_ptr<const FigureNames> names, std::vector<double> values);

  bool empty() const { return values_.empty(); }
  const std::vector<std::string>& names() const;
  std::optional<double> find(std::string_view name) const;
  std::map<std::string, double> by_name() const;
  bool has_names_of(const FigureRow& other) const { return names_ == other.names_; }

 private:
  std::shared_ptr<const FigureNames> names_;
  std::vector<double> values_;
};

/// Makes rows whose names are kept once.
class FigureRows {
 public:
  FigureRow row(const std::vector<std::pair<std::string, double>>& figures);

 private:
  std::map<std::vector<std::string>, std::shared_ptr<const FigureNames>> known_;
};

/// All names of some rows, each once, in the order in which they first come up.
class FigureNameUnion {
 public:
  void add(const FigureRow& row);
  const std::vector<std::string>& names() const { return names_; }

 private:
  FigureRow last_;
  std::set<std::string> known_;
  std::vector<std::string> names_;
};

}  // namespace panoptes
