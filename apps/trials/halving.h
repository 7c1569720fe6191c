// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "apps/batch/plan.h"

namespace panoptes {

/// What a round of a study's `halving` has decided, in the order of how good the rigs were.
struct HalvingRound {
  int seeds = 0;  ///< that each of its rigs has been run with
  std::vector<std::string> stay;
  std::vector<std::string> drop_out;
};

/// Successive halving (Jamieson and Talwalkar 2016) in synchronous rounds: all runs of a round are
/// made before any of the next. The rounds that are over, by the runs that are done alone; none
/// without `halving`.
std::vector<HalvingRound> halving_rounds(const Study& study, const std::vector<Trial>& trials);

/// Says of every run whether it is left out: because its rig has dropped out, or because its round
/// has not come. Returns how many rounds are over.
std::size_t leave_out(const Study& study, std::vector<Trial>& trials);

/// At most how many of the runs are made.
std::size_t runs_of_halving(const Study& study, const std::vector<Trial>& trials);

/// The rounds that are over, in Markdown; empty where there are none.
std::string halving_page(const Study& study, const std::vector<Trial>& trials);

}  // namespace panoptes
