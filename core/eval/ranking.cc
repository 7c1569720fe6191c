// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/ranking.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kLevel = 0.05;  // of all comparisons with the best together
constexpr int kResamples = 9999;

struct Moments {
  double mean = 0;
  double standard_error = 0;
};

template <class At>
Moments moments(std::size_t count, const At& at) {
  const auto n = static_cast<double>(count);
  Moments result;
  for (std::size_t i = 0; i < count; ++i) {
    result.mean += at(i) / n;
  }
  double squares = 0;
  for (std::size_t i = 0; i < count; ++i) {
    squares += (at(i) - result.mean) * (at(i) - result.mean);
  }
  result.standard_error = count > 1 ? std::sqrt(squares / (n - 1) / n) : 0;
  return result;
}

std::vector<double> differences(const ScoreBySeed& values, const ScoreBySeed& others) {
  std::vector<double> all;
  for (const auto& [seed, value] : values) {
    if (const auto other = others.find(seed); other != others.end()) {
      all.push_back(value - other->second);
    }
  }
  return all;
}

/// That their mean is 0 but for chance.
double probability_of_chance(const std::vector<double>& values) {
  const std::size_t count = values.size();
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  if (count == 0 || (*least == 0 && *most == 0)) {
    return 1;
  }
  if (*least == *most) {
    return std::exp2(1 - static_cast<double>(count));
  }
  const Moments all = moments(count, [&](std::size_t i) { return values[i]; });
  const double t = std::abs(all.mean) / all.standard_error;
  Rng rng = Rng(1).fork("paired bootstrap");
  std::vector<std::size_t> drawn(count);
  int beyond = 0;
  for (int k = 0; k < kResamples; ++k) {
    for (std::size_t& i : drawn) {
      i = static_cast<std::size_t>(rng.index(static_cast<int>(count)));
    }
    const Moments resample = moments(count, [&](std::size_t i) { return values[drawn[i]]; });
    // Where one value alone was drawn there is no standard error, and t is beyond any.
    beyond += std::abs(resample.mean - all.mean) >= t * resample.standard_error ? 1 : 0;
  }
  return (beyond + 1.0) / (kResamples + 1.0);
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
  std::vector<double> probabilities;
  for (std::size_t k = 1; k <= others; ++k) {
    const std::vector<double> values = differences(contenders[order[k]], contenders[order[0]]);
    probabilities.push_back(probability_of_chance(values));
    if (values.size() > 1) {
      const Moments all = moments(values.size(), [&](std::size_t i) { return values[i]; });
      standings[order[k]]->detectable =
          detectable_difference(all.standard_error, static_cast<int>(values.size()) - 1,
                                kLevel / static_cast<double>(others));
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
