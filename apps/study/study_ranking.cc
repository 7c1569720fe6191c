// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study/study_ranking.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace panoptes {
namespace {

// Cells that are tried side by side: of one mission and rung, in order of the rigs.
std::vector<std::vector<std::size_t>> races_of(const std::vector<StudyCell>& cells) {
  std::vector<std::vector<std::size_t>> races;
  std::map<std::pair<std::string, std::string>, std::size_t> known;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto [race, is_new] = known.try_emplace({cells[i].mission, cells[i].rung}, races.size());
    if (is_new) {
      races.emplace_back();
    }
    races[race->second].push_back(i);
  }
  return races;
}

std::string mean_text(const MeanInterval& mean) {
  return mean.count > 1 ? fmt::format("{:.4g} +- {:.2g}", mean.mean, mean.high - mean.mean)
                        : fmt::format("{:.4g}", mean.mean);
}

std::string standing_text(const std::optional<Standing>& standing) {
  if (!standing) {
    return "-";
  }
  std::string text = fmt::format("{} ({}", mean_text(standing->mean), standing->rank);
  if (standing->rank > 1 && standing->not_distinguishable_from_best) {
    text += standing->detectable
                ? fmt::format(", not distinguishable; {:.2g} would show", *standing->detectable)
                : ", not distinguishable by these seeds";
  }
  return text + ")";
}

}  // namespace

StudyRanking rank_rigs(const Study& study, const std::vector<StudyRun>& runs) {
  StudyRanking ranking;
  ranking.scores = study.scores;
  if (ranking.scores.empty() && study.figure.empty()) {
    ranking.scores.push_back({shown_figure(study), {}});
  }
  const std::vector<StudyCell> cells = cells_of(study);
  const std::size_t count = ranking.scores.size();
  std::vector<std::vector<ScoreBySeed>> values(cells.size(), std::vector<ScoreBySeed>(count));
  for (const StudyRun& run : runs) {
    for (std::size_t k = 0; k < count && run.done; ++k) {
      if (const auto value = ranking.scores[k].of(run.figures)) {
        values[run.cell][k][run.seed] = *value;
      }
    }
  }
  ranking.standings.assign(cells.size(), std::vector<std::optional<Standing>>(count));
  ranking.pareto.assign(cells.size(), false);
  for (const std::vector<std::size_t>& race : races_of(cells)) {
    std::vector<std::vector<double>> costs(race.size());
    std::size_t known = 0;  // scores that any run has
    for (std::size_t k = 0; k < count; ++k) {
      const bool less = ranking.scores[k].less_is_better();
      std::vector<ScoreBySeed> contenders;
      std::size_t most = 0;
      for (const std::size_t cell : race) {
        contenders.push_back(values[cell][k]);
        most = std::max(most, contenders.back().size());
      }
      known += most > 0 ? 1 : 0;
      const auto standings = rank(contenders, less);
      for (std::size_t i = 0; i < race.size(); ++i) {
        ranking.standings[race[i]][k] = standings[i];
        if (standings[i] && contenders[i].size() == most) {  // with other seeds it is not compared
          costs[i].push_back((less ? 1 : -1) * standings[i]->mean.mean);
        }
      }
    }
    const auto has_all = [&](const std::vector<double>& own) {
      return known > 0 && own.size() == known;
    };
    for (std::size_t i = 0; i < race.size(); ++i) {
      ranking.pareto[race[i]] =
          has_all(costs[i]) && std::none_of(costs.begin(), costs.end(), [&](const auto& other) {
            return has_all(other) && dominates(other, costs[i]);
          });
    }
  }
  return ranking;
}

std::string ranking_page(const Study& study, const std::vector<StudyRun>& runs,
                         const StudyRanking& ranking) {
  if (study.scores.empty()) {
    return {};
  }
  const std::vector<StudyCell> cells = cells_of(study);
  std::vector<std::pair<int, int>> passed_of(cells.size());  // and how many are done
  for (const StudyRun& run : runs) {
    auto& [passed, done] = passed_of[run.cell];
    passed += run.done && run.passed ? 1 : 0;
    done += run.done ? 1 : 0;
  }
  std::string tables;
  for (std::vector<std::size_t> race : races_of(cells)) {
    std::erase_if(race, [&](std::size_t cell) { return passed_of[cell].second == 0; });
    if (race.empty()) {
      continue;
    }
    std::stable_sort(race.begin(), race.end(), [&](std::size_t a, std::size_t b) {
      const auto& one = ranking.standings[a].front();
      const auto& other = ranking.standings[b].front();
      return one && (!other || one->rank < other->rank);
    });
    std::vector<std::string> head{
        fmt::format("{}, {}", cells[race.front()].mission, cells[race.front()].rung), "passed"};
    for (const StudyScore& score : study.scores) {
      head.push_back(
          fmt::format("{} ({})", score.figure(), score.less_is_better() ? "least" : "most"));
    }
    if (study.scores.size() > 1) {
      head.emplace_back("Pareto set");
    }
    tables += fmt::format("\n{}{}", markdown_row(head),
                          markdown_row(std::vector<std::string>(head.size(), "---")));
    for (const std::size_t cell : race) {
      std::vector<std::string> words{
          cells[cell].rig, fmt::format("{}/{}", passed_of[cell].first, passed_of[cell].second)};
      for (const auto& standing : ranking.standings[cell]) {
        words.push_back(standing_text(standing));
      }
      if (study.scores.size() > 1) {
        words.emplace_back(ranking.pareto[cell] ? "yes" : "");
      }
      tables += markdown_row(words);
    }
  }
  if (tables.empty()) {
    return {};
  }
  return fmt::format(
      "\nRanked: means over the seeds +- half of their 95 % intervals, and each rig's rank by the "
      "score. Not distinguishable: from the best by that score, by runs of the same seeds (paired "
      "bootstrap, 5 % over all rigs by Holm's correction), though a difference of so much would "
      "show about four times out of five.\n{}",
      tables);
}

}  // namespace panoptes
