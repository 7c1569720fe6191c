// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/camera/mounting.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "sim/sensors/trigger.h"

namespace panoptes::sim {

/// How far the true cameras are from where the nominal rig has them: turned about each axis of the
/// body and moved along it by a normal draw. What is given exactly, by the camera's name, takes the
/// draw's place. The defaults of this and the two below are what a good calibration leaves.
struct MountingError {
  double sigma_deg = 0.2;
  double sigma_m = 0.003;
  /// In place of these: as well as the nominal rig says that it is known, by each camera's sigma
  /// and by how cameras are off together (Rig::covariance).
  bool as_known = false;
  std::map<std::string, MountingOffset> exactly = {};
};
/// {sigma_deg, sigma_m, as_known, exactly}
void bind(Fields& f, MountingError& o);

/// What the true lens of one camera has more than the nominal one.
struct LensOffset {
  double focal_percent = 0;  ///< of both focal lengths
  Vec2 centre_px = Vec2::Zero();
  double distortion = 0;  ///< of the first radial coefficient, k1; a pinhole gets Brown's
};
void bind(Fields& f, LensOffset& o);

/// How far the true lenses are from the nominal ones.
struct LensError {
  double sigma_focal_percent = 0.2;
  double sigma_centre_px = 1;        ///< each way
  double sigma_distortion = 0.0005;  ///< 0.1 px at the edge, of 640 px and 80 deg
  std::map<std::string, LensOffset> exactly = {};
};
void bind(Fields& f, LensError& o);

/// By how much the stamps that cameras are told are later than the odometry's: constant, a camera
/// its own. The picture is of the true instant.
struct ClockError {
  double sigma_s = 0.005;
  std::map<std::string, double> exactly = {};  ///< seconds
};
void bind(Fields& f, ClockError& o);

/// All that the true rig has besides the nominal one. Where every sigma is 0 it is the nominal one.
struct RigErrors {
  MountingError mounting;
  LensError lens;
  ClockError clock;
};

/// Errors given exactly for cameras that the nominal rig has not, and lenses that cannot be; by the
/// keys of a platform.
std::vector<KeyFault> rig_error_faults(const RigErrors& errors, const Rig& nominal);

/// The true rig; in `clock_offset_s` what the stamps of its cameras truly are too late. Errors of
/// one kind are drawn whatever those of another are. Throws ConfigError for a lens that the seed
/// makes impossible.
Rig true_rig(const RigErrors& errors, const Rig& nominal, const Rng& rng);

}  // namespace panoptes::sim
