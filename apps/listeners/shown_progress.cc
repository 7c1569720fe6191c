// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "apps/listeners/listeners.h"
#include "apps/process/progress.h"

namespace panoptes {
namespace {

class ShownProgress : public StepListener {
 public:
  ShownProgress(Duration length, bool quiet, const Slam* slam)
      : progress_(length, quiet), slam_(slam) {}

  void add(const Observation& seen, const SlamStep& /*at*/, const PilotStep& step) override {
    progress_.show(seen.stamp, doing(slam_, step));
  }

 private:
  Progress progress_;
  const Slam* slam_;
};

}  // namespace

std::unique_ptr<StepListener> make_shown_progress(const ListenedRun& run) {
  if (run.pilot.shows_progress()) {
    return nullptr;
  }
  const Duration length =
      std::min({from_seconds(run.mission.until.duration_s), run.open.length, run.pilot.length()});
  return std::make_unique<ShownProgress>(length, run.quiet, run.slam);
}

}  // namespace panoptes
