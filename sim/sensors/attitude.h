// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <variant>
#include <vector>

#include "core/base/time.h"
#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/geometry/pose3.h"

namespace panoptes::sim {

/// amplitude * sin(2 pi frequency t + phase)
struct AngleWave {
  double amplitude_rad = 0;
  double frequency_hz = 1;
  double phase_rad = 0;
};
void bind(Fields& f, AngleWave& o);

struct HeaveWave {
  double amplitude_m = 0;
  double frequency_hz = 1;
  double phase_rad = 0;
};
void bind(Fields& f, HeaveWave& o);

/// A body on castors: always level.
struct LevelAttitude {
  static constexpr std::string_view kName = "level";
};
void bind(Fields& f, LevelAttitude& o);

/// Sums of sines, and a body that leans into its acceleration.
struct WavesAttitude {
  static constexpr std::string_view kName = "waves";
  std::vector<AngleWave> pitch;
  std::vector<AngleWave> roll;
  std::vector<HeaveWave> heave;
  double lean_rad_per_mps2 = 0;  ///< nose down per forward acceleration
  double lean_time_s = 0.15;     ///< of its way to that angle, an exponential
};
void bind(Fields& f, WavesAttitude& o);

/// Two wheels kept upright: leans 0.1 rad for each m/s2, as gravity asks, and rocks a little.
struct BalancingAttitude {
  static constexpr std::string_view kName = "balancing";
};
void bind(Fields& f, BalancingAttitude& o);

/// A rig carried by somebody who walks: two steps a second, the hip sways at half of that.
struct HandHeldAttitude {
  static constexpr std::string_view kName = "hand_held";
};
void bind(Fields& f, HandHeldAttitude& o);

using AttitudeOptions =
    std::variant<LevelAttitude, BalancingAttitude, HandHeldAttitude, WavesAttitude>;

/// How the body stands over its place on the floor.
struct Tilt {
  double pitch_rad = 0;  ///< nose down
  double roll_rad = 0;   ///< right side down
  double heave_m = 0;
};

/// The body's tilt as time goes on; it moves the cameras and nothing else. The body turns about its
/// wheel axle.
class Attitude {
 public:
  Attitude(const AttitudeOptions& options, const Body& body);

  bool level() const { return level_; }

  /// Carries the lean on by one step in which the body accelerated so much.
  void step(double accel_mps2, double step_s);
  double lean_rad() const { return lean_rad_; }

  /// `lean_rad`: what it was at that instant.
  Tilt tilt(Time at, double lean_rad) const;

  /// From the body as it stands to its frame on the floor.
  Pose3 T_level_body(const Tilt& tilt) const;

 private:
  WavesAttitude waves_;
  bool level_ = true;
  double axle_m_;
  double lean_rad_ = 0;
};

}  // namespace panoptes::sim
