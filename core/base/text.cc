// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/text.h"

namespace panoptes {

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string all;
  for (const std::string& word : words) {
    if (&word != &words.front()) {
      all += between;
    }
    all += word;
  }
  return all;
}

}  // namespace panoptes
