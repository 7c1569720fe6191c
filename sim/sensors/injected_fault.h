// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/time.h"
#include "core/camera/mounting.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "sim/sensors/trigger.h"

namespace panoptes::sim {

/// What befalls a camera in the middle of a run: its pictures, or how it is mounted.
enum class CameraFaultKind {
  kFreeze,  ///< the same pixels again, with new stamps
  kCover,   ///< a hand or a cap on the lens
  kBlack,   ///< no light: what the sensor gives then, its noise included
  kUnplug,  ///< no pictures
  kKnock    ///< it sits otherwise from then on
};

struct InjectedFault {
  std::string camera;  ///< empty: every camera, as when the lights go out
  CameraFaultKind fault = CameraFaultKind::kFreeze;
  double at_s = 0;              ///< from the first picture with this stamp or a later one
  std::optional<double> for_s;  ///< absent: for good
  MountingOffset knock = {};    ///< of a knock: from where it sat before

  bool befalls(const std::string& name, Time stamp) const;
};
void bind(Fields& f, InjectedFault& o);

/// Faults of cameras that the rig has not.
std::vector<KeyFault> injection_faults(const std::vector<InjectedFault>& faults, const Rig& rig);

/// What befalls a camera's picture of this instant: of several, the first. Empty: nothing. A knock
/// is none of these.
std::optional<CameraFaultKind> fault_at(const std::vector<InjectedFault>& faults,
                                        const std::string& camera, Time stamp);

/// Whether a camera has been knocked by then, and how it is mounted after all its knocks.
bool is_knocked(const std::vector<InjectedFault>& faults, const std::string& camera, Time t);
Pose3 knocked(const std::vector<InjectedFault>& faults, const std::string& camera, Time t,
              const Pose3& T_body_camera);

/// What a covered lens lets through, from what a clear one would (8-bit square roots of light):
/// brown, nearly even, brighter where it is brighter outside.
void cover(cv::Mat& bgr);

}  // namespace panoptes::sim
