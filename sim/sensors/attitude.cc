// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/attitude.h"

#include <cmath>
#include <numbers>

namespace panoptes::sim {
namespace {

constexpr double kGravity_mps2 = 9.81;

WavesAttitude waves_of(const LevelAttitude&) { return {}; }

WavesAttitude waves_of(const WavesAttitude& waves) { return waves; }

// The lean at which the weight just balances the acceleration; the loop that keeps it upright rocks
// at about 1 Hz by fractions of a degree, on two frequencies that do not repeat together.
WavesAttitude waves_of(const BalancingAttitude&) {
  WavesAttitude waves;
  waves.pitch = {{deg_to_rad(0.5), 0.9, 0}, {deg_to_rad(0.25), 2.3, 1}};
  waves.lean_rad_per_mps2 = 1 / kGravity_mps2;
  return waves;
}

// At a walk of about two steps a second each step lifts what is carried by a few centimetres and
// nods it by a degree or two, each second one sways it; slow drifts of the hand come on top.
WavesAttitude waves_of(const HandHeldAttitude&) {
  WavesAttitude waves;
  waves.pitch = {{deg_to_rad(1.5), 1.9, 0}, {deg_to_rad(1), 0.31, 2}};
  waves.roll = {{deg_to_rad(1.2), 0.95, 0.5}, {deg_to_rad(0.8), 0.23, 1}};
  waves.heave = {{0.02, 1.9, 1.2}};
  return waves;
}

template <class Wave>
double at_time(const Wave& wave, double amplitude, double t_s) {
  return amplitude * std::sin(2 * std::numbers::pi * wave.frequency_hz * t_s + wave.phase_rad);
}

}  // namespace

void bind(Fields& f, AngleWave& o) {
  f.angle("amplitude", o.amplitude_rad, between(-0.8, 0.8));
  f("frequency_hz", o.frequency_hz, between(0, 100));
  f.angle("phase", o.phase_rad);
}

void bind(Fields& f, HeaveWave& o) {
  f("amplitude_m", o.amplitude_m, between(-1, 1));
  f("frequency_hz", o.frequency_hz, between(0, 100));
  f.angle("phase", o.phase_rad);
}

void bind(Fields&, LevelAttitude&) {}
void bind(Fields&, BalancingAttitude&) {}
void bind(Fields&, HandHeldAttitude&) {}

void bind(Fields& f, WavesAttitude& o) {
  f("pitch", o.pitch);
  f("roll", o.roll);
  f("heave", o.heave);
  f("lean_rad_per_mps2", o.lean_rad_per_mps2, between(-1, 1));
  f("lean_time_s", o.lean_time_s, between(0.01, 10));
}

Attitude::Attitude(const AttitudeOptions& options, const Body& body)
    : waves_(std::visit([](const auto& alternative) { return waves_of(alternative); }, options)),
      level_(waves_.pitch.empty() && waves_.roll.empty() && waves_.heave.empty() &&
             waves_.lean_rad_per_mps2 == 0),
      axle_m_(body.wheel_radius_m) {}

void Attitude::step(double accel_mps2, double step_s) {
  const double wanted_rad = waves_.lean_rad_per_mps2 * accel_mps2;
  lean_rad_ += (wanted_rad - lean_rad_) * (1 - std::exp(-step_s / waves_.lean_time_s));
}

Tilt Attitude::tilt(Time at, double lean_rad) const {
  const double t_s = to_seconds(at);
  Tilt tilt;
  tilt.pitch_rad = lean_rad;
  for (const AngleWave& wave : waves_.pitch) {
    tilt.pitch_rad += at_time(wave, wave.amplitude_rad, t_s);
  }
  for (const AngleWave& wave : waves_.roll) {
    tilt.roll_rad += at_time(wave, wave.amplitude_rad, t_s);
  }
  for (const HeaveWave& wave : waves_.heave) {
    tilt.heave_m += at_time(wave, wave.amplitude_m, t_s);
  }
  return tilt;
}

Pose3 Attitude::T_level_body(const Tilt& tilt) const {
  const Vec3 axle_body(0, 0, axle_m_);
  Pose3 T;
  T.rotation = Eigen::AngleAxisd(tilt.pitch_rad, Vec3::UnitY()) *
               Eigen::AngleAxisd(tilt.roll_rad, Vec3::UnitX());
  T.translation = axle_body - T.rotation * axle_body + Vec3(0, 0, tilt.heave_m);
  return T;
}

}  // namespace panoptes::sim
