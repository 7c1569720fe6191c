// SPDX-License-Identifier: BSD-3-Clause
#include "apps/listeners/listeners.h"

namespace panoptes {

#define PANOPTES_LISTENER(name) std::unique_ptr<StepListener> make_##name(const ListenedRun& run);
#include "apps/listeners/listeners.inc"
#undef PANOPTES_LISTENER

std::vector<std::unique_ptr<StepListener>> make_listeners(const ListenedRun& run) {
  std::vector<std::unique_ptr<StepListener>> all;
#define PANOPTES_LISTENER(name) all.push_back(make_##name(run));
#include "apps/listeners/listeners.inc"
#undef PANOPTES_LISTENER
  std::erase(all, nullptr);
  return all;
}

}  // namespace panoptes
