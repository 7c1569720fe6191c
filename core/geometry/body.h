// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace panoptes {

/// What the robot believes of its own body: a disc about the middle of the wheel axle, driven by
/// two wheels on that axle. The defaults are a Pioneer P3-DX with a camera mast.
struct Body {
  double radius_m = 0.25;
  double height_m = 0.8;        ///< top of the mast
  double hull_height_m = 0.24;  ///< top of the hull that the mast stands on
  double wheel_base_m = 0.33;   ///< between the wheels' points of contact
  double wheel_radius_m = 0.0975;
  int ticks_per_turn = 500;
  double max_speed_mps = 0.6;
  double max_turn_radps = 1.5;
  double max_accel_mps2 = 0.6;
  double max_turn_accel_radps2 = 3.0;
};

}  // namespace panoptes
