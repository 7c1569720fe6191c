// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/ranking.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kLevel = 0.05;  // of all comparisons with the best together
constexpr double kNoSpread = 1e-9;

std::vector<double> differences(const ScoreBySeed& values, const ScoreBySeed& others) {
  std::vector<double> all;
  for (const auto& [seed, value] : values) {
    if (const auto other = others.find(seed); other != others.end()) {
      all.push_back(value - other->second);
    }
  }
  return all;
}

/// That they are no larger than 0 on the mean but for chance, were either sign of each as likely:
/// of all signs, or of many that are drawn, the share whose mean is as far from 0.
double probability_of_chance(const std::vector<double>& values) {
  constexpr std::size_t kAllSigns = 13;  // of so many values at most
  constexpr int kDrawn = 9999;
  constexpr double kAsFar = 1 - 1e-9;
  const std::size_t count = values.size();
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  if (sum == 0) {
    return 1;
  }
  const auto flipped = [&](const std::function<bool(std::size_t)>& is_flipped) {
    double flipped_sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      flipped_sum += is_flipped(i) ? -values[i] : values[i];
    }
    return std::abs(flipped_sum) >= kAsFar * std::abs(sum) ? 1 : 0;
  };
  int beyond = 0;
  if (count <= kAllSigns) {
    const unsigned all = 1U << count;
    for (unsigned signs = 0; signs < all; ++signs) {
      beyond += flipped([&](std::size_t i) { return (signs >> i & 1U) != 0; });
    }
    return static_cast<double>(beyond) / all;
  }
  Rng rng = Rng(1).fork("signs");
  for (int k = 0; k < kDrawn; ++k) {
    beyond += flipped([&](std::size_t) { return rng.index(2) == 1; });
  }
  return (beyond + 1.0) / (kDrawn + 1.0);
}

/// Holm's step-down procedure: which of these show.
std::vector<bool> shown(const std::vector<double>& probabilities) {
  std::vector<std::size_t> order(probabilities.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = i;
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return probabilities[a] < probabilities[b];
  });
  std::vector<bool> show(probabilities.size(), false);
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (probabilities[order[i]] > kLevel / static_cast<double>(order.size() - i)) {
      break;
    }
    show[order[i]] = true;
  }
  return show;
}

}  // namespace

std::vector<std::optional<Standing>> rank(const std::vector<ScoreBySeed>& contenders,
                                          bool less_is_better) {
  std::vector<std::optional<Standing>> standings(contenders.size());
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < contenders.size(); ++i) {
    if (contenders[i].empty()) {
      continue;
    }
    std::vector<double> values;
    for (const auto& [seed, value] : contenders[i]) {
      values.push_back(value);
    }
    standings[i].emplace();
    standings[i]->mean = mean_interval(values);
    order.push_back(i);
  }
  if (order.empty()) {
    return standings;
  }
  const auto cost = [&](std::size_t i) {
    const MeanInterval& mean = standings[i]->mean;
    return std::pair(-mean.count, less_is_better ? mean.mean : -mean.mean);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return cost(a) < cost(b); });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool shared = k > 0 && cost(order[k]) == cost(order[k - 1]);
    standings[order[k]]->rank = shared ? standings[order[k - 1]]->rank : static_cast<int>(k) + 1;
  }
  const std::size_t others = order.size() - 1;
  const double level = kLevel / static_cast<double>(std::max<std::size_t>(1, others));
  std::vector<double> probabilities;
  for (std::size_t k = 1; k <= others; ++k) {
    const std::vector<double> values = differences(contenders[order[k]], contenders[order[0]]);
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    const bool is_worse = less_is_better ? sum > 0 : sum < 0;
    probabilities.push_back(is_worse ? probability_of_chance(values) : 1);
    const bool could_show = std::exp2(1 - static_cast<double>(values.size())) <= level;
    if (could_show) {
      const MeanInterval mean = mean_interval(values);
      const double standard_error = standard_error_of(mean);
      if (standard_error > kNoSpread * std::abs(mean.mean)) {
        standings[order[k]]->detectable =
            detectable_difference(standard_error, mean.count - 1, level);
      }
    }
  }
  const std::vector<bool> show = shown(probabilities);
  for (std::size_t k = 1; k <= others; ++k) {
    standings[order[k]]->not_distinguishable_from_best = !show[k - 1];
  }
  return standings;
}

bool dominates(const std::vector<double>& costs, const std::vector<double>& others) {
  bool better = false;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    if (!(costs[i] <= others[i])) {
      return false;
    }
    better = better || costs[i] < others[i];
  }
  return better;
}

}  // namespace panoptes
