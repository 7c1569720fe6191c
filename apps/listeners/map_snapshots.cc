// SPDX-License-Identifier: BSD-3-Clause
#include "apps/listeners/listeners.h"

namespace panoptes {
namespace {

// Of a run whose map is known meanwhile.
class MapSnapshots : public StepListener {
 public:
  MapSnapshots(Recorder& recorder, Slam& slam) : recorder_(recorder), slam_(slam) {}

  void add(const Observation& seen, const SlamStep& /*at*/, const PilotStep& /*step*/) override {
    if (recorder_.snapshot_due(seen.stamp)) {
      recorder_.add_snapshot(seen.stamp, slam_.planning_map());
    }
  }

 private:
  Recorder& recorder_;
  Slam& slam_;
};

}  // namespace

std::unique_ptr<StepListener> make_map_snapshots(const ListenedRun& run) {
  return run.slam == nullptr ? nullptr : std::make_unique<MapSnapshots>(run.recorder, *run.slam);
}

}  // namespace panoptes
