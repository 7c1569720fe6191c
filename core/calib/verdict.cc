// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/verdict.h"

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

}  // namespace panoptes
