// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study/figure_row.h"

namespace panoptes {

FigureRow::FigureRow(std::shared_ptr<const FigureNames> names, std::vector<double> values)
    : names_(std::move(names)), values_(std::move(values)) {}

const std::vector<std::string>& FigureRow::names() const {
  static const std::vector<std::string> none;
  return names_ ? names_->names : none;
}

std::optional<double> FigureRow::find(std::string_view name) const {
  if (!names_) {
    return std::nullopt;
  }
  const auto found = names_->at.find(name);
  return found == names_->at.end() ? std::nullopt : std::optional(values_[found->second]);
}

std::map<std::string, double> FigureRow::by_name() const {
  std::map<std::string, double> all;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    all.emplace(names_->names[i], values_[i]);
  }
  return all;
}

FigureRow FigureRows::row(const std::vector<std::pair<std::string, double>>& figures) {
  std::vector<std::string> names;
  std::vector<double> values;
  names.reserve(figures.size());
  values.reserve(figures.size());
  for (const auto& [name, value] : figures) {
    names.push_back(name);
    values.push_back(value);
  }
  auto [known, is_new] = known_.try_emplace(names);
  if (is_new) {
    auto made = std::make_shared<FigureNames>();
    for (std::size_t i = 0; i < names.size(); ++i) {
      made->at.emplace(names[i], i);
    }
    made->names = std::move(names);
    known->second = std::move(made);
  }
  return {known->second, std::move(values)};
}

void FigureNameUnion::add(const FigureRow& row) {
  if (row.has_names_of(last_)) {  // as of most runs
    return;
  }
  last_ = row;
  for (const std::string& name : row.names()) {
    if (known_.insert(name).second) {
      names_.push_back(name);
    }
  }
}

}  // namespace panoptes
