// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/verdict.h"

#include <algorithm>
#include <utility>

namespace panoptes {

std::string_view name(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood:
      return "good";
    case Verdict::kPoor:
      return "poor";
    case Verdict::kFailed:
      break;
  }
  return "failed";
}

void Judged::doubt(Verdict at_best, std::string why) {
  verdict = std::max(verdict, at_best);
  if (at_best != Verdict::kGood) {
    doubts.push_back(why);
  }
  reasons.push_back(std::move(why));
}

}  // namespace panoptes
