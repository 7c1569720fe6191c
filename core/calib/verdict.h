// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace panoptes {

/// What a calibration is worth: to be used, to be used with care, not to be told.
enum class Verdict { kGood, kPoor, kFailed };
std::string_view name(Verdict verdict);

struct Judged {
  Verdict verdict = Verdict::kGood;
  std::vector<std::string> reasons;  ///< in words, with what to do,
  std::vector<std::string> doubts;   ///< and those that the verdict is no better for

  /// No better than `at_best`, and why.
  void doubt(Verdict at_best, std::string why);
};

}  // namespace panoptes
