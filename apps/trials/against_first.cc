// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/against_first.h"

#include <algorithm>
#include <variant>

#include <fmt/format.h>

#include "core/eval/statistics.h"

namespace panoptes {
namespace {

const std::string& rig_of(const TrialGroup& group) { return group.point->values[0]; }
const std::string& rung_of(const TrialGroup& group) { return group.point->values[1]; }

const TrialGroup* first_of(const Study& study, const std::vector<TrialGroup>& groups,
                           const TrialGroup& group) {
  const auto found = std::find_if(groups.begin(), groups.end(), [&](const TrialGroup& other) {
    return other.point->mission == group.point->mission && rung_of(other) == rung_of(group) &&
           rig_of(other) == study.rigs.front().name;
  });
  return found == groups.end() || &*found == &group ? nullptr : &*found;
}

std::string verdict_of(const RigComparison& one) {
  if (one.holds) {
    return "holds";
  }
  return one.pairs > 1 ? fmt::format("not shown; {:+.2g} would be", one.detectable) : "not shown";
}

}  // namespace

std::vector<RigComparison> compare_with_first(const Study& study,
                                              const std::vector<TrialGroup>& groups,
                                              const TrialGroup& group) {
  std::vector<RigComparison> all;
  const TrialGroup* first = first_of(study, groups, group);
  for (const StudyComparison& asked : study.against_first) {
    if (first == nullptr) {
      continue;
    }
    const auto found = difference(group, *first, asked.limit.figure);
    if (!found) {
      all.push_back({asked.line});
      continue;
    }
    using Op = Requirement::Op;
    const Requirement& requirement = asked.limit.requirement;
    const bool from_below = requirement.op == Op::kGreater || requirement.op == Op::kGreaterEqual;
    const double margin = std::get<double>(requirement.wanted);
    const double bound = from_below ? found->at_least : found->at_most;
    all.push_back(
        {asked.line, found->mean.count, found->mean.mean, bound,
         margin + (from_below ? found->detectable_one_sided : -found->detectable_one_sided),
         found->mean.count > 1 && holds(requirement, bound)});
  }
  return all;
}

std::string comparison_page(const Study& study, const std::vector<TrialGroup>& groups) {
  std::string rows;
  for (const TrialGroup& group : groups) {
    for (const RigComparison& one : compare_with_first(study, groups, group)) {
      rows += fmt::format(
          "| {}, {}, {} | {} | {} | {} | {} | {} |\n", group.point->mission, rig_of(group),
          rung_of(group), one.line, one.pairs > 0 ? fmt::format("{:+.4g}", one.mean) : "-",
          one.pairs > 1 ? fmt::format("{:+.4g}", one.bound) : "-", one.pairs, verdict_of(one));
    }
  }
  if (rows.empty()) {
    return {};
  }
  return fmt::format(
      "\nAgainst {}, by runs of the same seeds; the bound is what the true difference surely keeps "
      "to (one-sided 95 %):\n\n| | must be | mean | bound | pairs | |\n| --- | --- | --- | --- | "
      "--- | --- |\n{}",
      study.rigs.front().name, rows);
}

}  // namespace panoptes
