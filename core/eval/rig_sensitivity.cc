// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/rig_sensitivity.h"

#include <string>
#include <utility>

#include "core/base/rng.h"
#include "core/camera/mounting.h"
#include "core/eval/statistics.h"

namespace panoptes {
namespace {

Rig mounted_off(const RigSensitivityOptions& options, Rig rig, const Rng& of_draw) {
  for (auto& [name, camera] : rig.cameras) {
    Rng rng = of_draw.fork(name);
    const auto off = [&rng](double sigma) {
      const double x = rng.normal(0, sigma);
      const double y = rng.normal(0, sigma);
      return Vec3(x, y, rng.normal(0, sigma));
    };
    Pose3& T = camera.T_body_camera;
    T.rotation = (turned_by(off(options.rotation_rad)) * T.rotation).normalized();
    T.translation += off(options.position_m);
  }
  return rig;
}

}  // namespace

RigSensitivity rig_sensitivity(const RigSensitivityOptions& options, const RigScoreOptions& scores,
                               const Rig& rig, const Body& body) {
  const std::vector<NamedScore> as_drawn = named_scores(score_rig(scores, rig, body));
  std::vector<std::vector<double>> values(as_drawn.size());
  for (int draw = 0; draw < options.draws; ++draw) {
    const Rng of_draw = Rng(options.seed).fork("draw " + std::to_string(draw));
    const std::vector<NamedScore> off =
        named_scores(score_rig(scores, mounted_off(options, rig, of_draw), body));
    for (std::size_t i = 0; i < off.size(); ++i) {
      if (off[i].value) {
        values[i].push_back(*off[i].value);
      }
    }
  }
  constexpr double kRare = 0.05;
  RigSensitivity out{options, {}};
  for (std::size_t i = 0; i < as_drawn.size(); ++i) {
    const bool has = as_drawn[i].value && options.draws > 0 &&
                     values[i].size() == static_cast<std::size_t>(options.draws);
    out.spreads.push_back(has ? std::optional<ScoreSpread>(
                                    {quantile(values[i], kRare), quantile(values[i], 1 - kRare)})
                              : std::nullopt);
  }
  return out;
}

}  // namespace panoptes
