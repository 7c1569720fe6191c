// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/halving.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <tuple>

#include <fmt/format.h>

#include "core/base/text.h"

namespace panoptes {
namespace {

const std::string& rig_of(const Trial& trial) { return trial.point->values[0]; }

/// Of each seed, which one it is in the order in which they were asked for.
std::map<std::uint64_t, int> order_of_seeds(const std::vector<Trial>& trials) {
  std::map<std::uint64_t, int> order;
  for (const Trial& trial : trials) {
    order.try_emplace(trial.seed, static_cast<int>(order.size()));
  }
  return order;
}

std::vector<std::string> contenders_of(const Study& study) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i < study.rigs.size(); ++i) {
    names.push_back(study.rigs[i].name);
  }
  return names;
}

bool stays(const Study& study, const std::vector<std::string>& contenders, const std::string& rig) {
  return rig == study.rigs.front().name ||
         std::find(contenders.begin(), contenders.end(), rig) != contenders.end();
}

std::size_t half_of(std::size_t rigs, const StudyHalving& halving) {
  return std::max((rigs + 1) / 2, static_cast<std::size_t>(halving.keep));
}

/// Of a round after one of `seeds` from which so many rigs go on.
int next_seeds(const StudyHalving& halving, std::size_t rigs, int seeds, int all_seeds) {
  return rigs <= static_cast<std::size_t>(halving.keep) ? all_seeds
                                                        : std::min(2 * seeds, all_seeds);
}

/// The better first: a rig of which fewer runs failed; among equals one of which more runs have the
/// figure; among these the mean decides.
void rank(const StudyHalving& halving, const std::vector<Trial>& trials,
          const std::map<std::uint64_t, int>& order, int seeds, std::vector<std::string>& rigs) {
  struct Score {
    int failed = 0;
    int lacking = 0;
    double mean = std::numeric_limits<double>::infinity();
  };
  std::map<std::string, Score> scores;
  for (const std::string& rig : rigs) {
    int count = 0;
    double sum = 0;
    Score& score = scores[rig];
    for (const Trial& trial : trials) {
      if (rig_of(trial) != rig || order.at(trial.seed) >= seeds) {
        continue;
      }
      const std::optional<double> figure = halving.score.of(trial.figures);
      score.failed += trial.status == TrialStatus::kPassed ? 0 : 1;
      score.lacking += figure ? 0 : 1;
      sum += figure.value_or(0);
      count += figure ? 1 : 0;
    }
    if (count > 0) {
      score.mean = sum / count * (halving.score.less_is_better() ? 1 : -1);
    }
  }
  std::stable_sort(rigs.begin(), rigs.end(), [&](const std::string& a, const std::string& b) {
    const Score& first = scores[a];
    const Score& second = scores[b];
    return std::tie(first.failed, first.lacking, first.mean) <
           std::tie(second.failed, second.lacking, second.mean);
  });
}

/// Who goes on, and to how many seeds.
class Halving {
 public:
  Halving(const Study& study, const std::vector<Trial>& trials)
      : study_(study), order_(order_of_seeds(trials)), all_seeds_(static_cast<int>(order_.size())) {
    contenders_ = contenders_of(study);
    seeds_ = std::min(study.halving->seeds, all_seeds_);
    bool more = true;
    while (more && is_over(trials) && (seeds_ < all_seeds_ || contenders_.size() > keep())) {
      more = seeds_ < all_seeds_;
      end_round(trials);
    }
  }

  bool leaves_out(const Trial& trial) const {
    return order_.at(trial.seed) >= seeds_ || !stays(study_, contenders_, rig_of(trial));
  }
  const std::vector<HalvingRound>& rounds() const { return rounds_; }

 private:
  std::size_t keep() const { return static_cast<std::size_t>(study_.halving->keep); }

  bool is_over(const std::vector<Trial>& trials) const {
    return std::all_of(trials.begin(), trials.end(),
                       [this](const Trial& trial) { return is_done(trial) || leaves_out(trial); });
  }

  void end_round(const std::vector<Trial>& trials) {
    rank(*study_.halving, trials, order_, seeds_, contenders_);
    HalvingRound round{seeds_, contenders_, {}};
    const std::size_t most =
        seeds_ < all_seeds_ ? half_of(round.stay.size(), *study_.halving) : keep();
    const auto stay = static_cast<std::ptrdiff_t>(std::min(round.stay.size(), most));
    round.drop_out.assign(round.stay.begin() + stay, round.stay.end());
    round.stay.erase(round.stay.begin() + stay, round.stay.end());
    contenders_ = round.stay;
    seeds_ = next_seeds(*study_.halving, round.stay.size(), seeds_, all_seeds_);
    rounds_.push_back(std::move(round));
  }

  const Study& study_;
  std::map<std::uint64_t, int> order_;
  int all_seeds_;
  std::vector<std::string> contenders_;
  int seeds_ = 0;
  std::vector<HalvingRound> rounds_;
};

}  // namespace

std::vector<HalvingRound> halving_rounds(const Study& study, const std::vector<Trial>& trials) {
  return study.halving ? Halving(study, trials).rounds() : std::vector<HalvingRound>();
}

std::size_t leave_out(const Study& study, std::vector<Trial>& trials) {
  if (!study.halving) {
    return 0;
  }
  const Halving halving(study, trials);
  for (Trial& trial : trials) {
    trial.left_out = halving.leaves_out(trial);
  }
  return halving.rounds().size();
}

std::size_t runs_of_halving(const Study& study, const std::vector<Trial>& trials) {
  if (!study.halving) {
    return trials.size();
  }
  const int all_seeds = static_cast<int>(order_of_seeds(trials).size());
  std::size_t rigs = study.rigs.size() - 1;
  const std::size_t cells = trials.size() / (static_cast<std::size_t>(all_seeds) * (rigs + 1));
  int before = 0;
  int seeds = std::min(study.halving->seeds, all_seeds);
  std::size_t runs = 0;
  while (true) {
    runs += static_cast<std::size_t>(seeds - before) * (rigs + 1) * cells;
    if (seeds == all_seeds) {
      return runs;
    }
    rigs = std::min(rigs, half_of(rigs, *study.halving));
    before = seeds;
    seeds = next_seeds(*study.halving, rigs, seeds, all_seeds);
  }
}

std::string halving_page(const Study& study, const std::vector<Trial>& trials) {
  const std::vector<HalvingRound> rounds = halving_rounds(study, trials);
  if (rounds.empty()) {
    return {};
  }
  std::string text = fmt::format(
      "\nThe worse half of the rigs drops out: by failed runs, then by {} (the {}, the better). {} "
      "stays for comparison.\n\n",
      study.halving->score.figure(), study.halving->score.less_is_better() ? "less" : "more",
      study.rigs.front().name);
  const bool is_known = std::any_of(trials.begin(), trials.end(), [&](const Trial& trial) {
    return study.halving->score.of(trial.figures).has_value();
  });
  text += is_known ? ""
                   : fmt::format("No run has {}: among equals rigs stay in their order.\n\n",
                                 study.halving->score.figure());
  text += "| after seeds | stay, best first | drop out |\n| --- | --- | --- |\n";
  for (const HalvingRound& round : rounds) {
    text +=
        fmt::format("| {} | {} | {} |\n", round.seeds, joined(round.stay), joined(round.drop_out));
  }
  return text;
}

}  // namespace panoptes
