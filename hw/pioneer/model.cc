// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/model.h"

#include <algorithm>
#include <array>

namespace panoptes::hw {
namespace {

// Those whose controllers have ARCOS (`-sh`) count millimetres; older ones count by their wheels.
// The figures are facts of the robots, as the maker's parameter files give them.
constexpr std::array kModels = {
    PioneerModel{"p3dx-sh"},
    PioneerModel{"p3dx-sh-lms1xx"},
    PioneerModel{"p3dx-sh-lms500"},
    PioneerModel{"p3dx", 0.485e-3},
    PioneerModel{"p3at-sh", 1e-3, 1e-3, 3.4},
    PioneerModel{"p3at", 0.465e-3, 1e-3, 3.4},
    PioneerModel{"peoplebot-sh", 1e-3, 1e-3, 6.0},
    PioneerModel{"amigo-sh", 1e-3, 1e-3, 11.0},
};

}  // namespace

const PioneerModel* find_model(std::string_view subclass) {
  const auto* found = std::find_if(kModels.begin(), kModels.end(), [&](const PioneerModel& model) {
    return model.subclass == subclass;
  });
  return found == kModels.end() ? nullptr : found;
}

std::vector<std::string> known_models() {
  std::vector<std::string> names;
  for (const PioneerModel& model : kModels) {
    names.emplace_back(model.subclass);
  }
  return names;
}

}  // namespace panoptes::hw
