// SPDX-License-Identifier: BSD-3-Clause
#include "core/plan/dwa.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/plan/reaction.h"

namespace panoptes {
namespace {

struct Candidate {
  Twist2 twist;
  bool admissible = false;
  double heading = 0;
  double distance = 0;
  double speed = 0;
  double clearance_m = 0;
  double free_path_m = 0;
  double score = 0;
};

}  // namespace

void bind(Fields& f, DwaOptions& o) {
  f("cell_m", o.cell_m, between(0.005, 0.1));
  f("window_m", o.window_m, between(1.0, 10.0));
  f("speed_samples", o.speed_samples, at_least(2));
  f("turn_samples", o.turn_samples, at_least(3));
  f.require(o.turn_samples % 2 == 1, "turn_samples",
            "must be odd so that keeping straight on is tried");
  for (const char* stated : {"cycle_s", "reaction_s"}) {
    f.removed(stated,
              "is not set any more: the platform states its timing, and the cycle is measured");
  }
  f("distance_cap_m", o.distance_cap_m, positive);
  f("margin_m", o.margin_m, not_negative);
  f("margin_s", o.margin_s, not_negative);
  f("heading_weight", o.heading_weight, not_negative);
  f("distance_weight", o.distance_weight, not_negative);
  f("speed_weight", o.speed_weight, not_negative);
}

DwaResult choose_arc(const DwaOptions& options, const Body& body, const ClearanceMap& local_odom,
                     const DwaRequest& request) {
  // What can be reached within a cycle, from the speeds as they are.
  const double dv = body.max_accel_mps2 * request.cycle_s;
  const double dw = body.max_turn_accel_radps2 * request.cycle_s;
  const double v_now = std::clamp(request.twist_body.v_mps, 0.0, body.max_speed_mps);
  const double w_now =
      std::clamp(request.twist_body.w_radps, -body.max_turn_radps, body.max_turn_radps);
  const double v_low = std::max(0.0, v_now - body.max_accel_mps2 * request.longest_cycle_s);
  const double v_high = std::max(
      v_low, std::min({v_now + dv, body.max_speed_mps, std::max(0.0, request.speed_limit_mps)}));
  const double w_low = std::max(-body.max_turn_radps, w_now - dw);
  const double w_high = std::min(body.max_turn_radps, w_now + dw);

  const auto room_m = [&](const Vec2& p) {
    return outline_clearance_m(local_odom, body.radius_m,
                               std::min(kUnknownNearer_m, options.margin_m), p);
  };
  const double here_m = room_m(request.T_odom_body.position());
  const double step_m = std::max(0.5 * local_odom.map.cell_m, 0.02);

  const auto roll = [&](const Twist2& twist) {
    Candidate c;
    c.twist = twist;
    // Inside the margin already: nothing nearer than now is allowed, so that the way out is open.
    const double margin =
        std::min(options.margin_m + options.margin_s * twist.v_mps, here_m - 1e-6);
    const double stop_s = std::max(twist.v_mps / body.max_accel_mps2,
                                   std::abs(twist.w_radps) / body.max_turn_accel_radps2);
    if (twist.v_mps <= 0) {
      c.free_path_m = options.distance_cap_m;  // a disc turns on the spot
      c.clearance_m = here_m;
      c.admissible = true;
    } else {
      c.clearance_m = here_m;
      // The gap cannot shrink faster than the body moves: where there is room, in long steps.
      double path_m = 0;
      double gap = here_m;
      while (path_m < options.distance_cap_m) {
        const double step = std::max(step_m, gap - margin - local_odom.map.cell_m);
        const Pose2 T = request.T_odom_body * exp_twist(twist, (path_m + step) / twist.v_mps);
        gap = room_m(T.position());
        if (gap < margin) {
          break;
        }
        path_m += step;
        c.clearance_m = std::min(c.clearance_m, gap);
      }
      c.free_path_m = std::min(path_m, options.distance_cap_m);
      c.admissible = stopping_distance_m(twist.v_mps, request.longest_cycle_s,
                                         body.max_accel_mps2) <= c.free_path_m;
    }
    // The heading once it has stopped: braking keeps the arc and takes half the distance of driving
    // on.
    const Pose2 T_end = request.T_odom_body * exp_twist(twist, request.cycle_s + 0.5 * stop_s);
    const Vec2 to_lookahead = request.lookahead_odom - T_end.position();
    const double aside =
        wrap_angle(std::atan2(to_lookahead.y(), to_lookahead.x()) - T_end.theta_rad);
    c.heading = 1.0 - std::abs(aside) / std::numbers::pi;
    c.distance = c.free_path_m / options.distance_cap_m;
    c.speed = twist.v_mps / body.max_speed_mps;
    return c;
  };

  std::vector<Candidate> window;
  window.reserve(static_cast<std::size_t>(options.speed_samples) * options.turn_samples);
  const int speeds = v_high > v_low ? options.speed_samples : 1;
  for (int i = 0; i < speeds; ++i) {
    const double v = v_low + (speeds > 1 ? (v_high - v_low) * i / (speeds - 1) : 0.0);
    for (int j = 0; j < options.turn_samples; ++j) {
      const double w = w_low + (w_high - w_low) * j / (options.turn_samples - 1);
      window.push_back(roll({v, w}));
    }
  }

  // Each term over the admissible set, from 0 to 1.
  DwaResult out;
  double low[3] = {1, 1, 1};
  double high[3] = {0, 0, 0};
  int rejected = 0;
  for (const Candidate& c : window) {
    if (!c.admissible) {
      ++rejected;
      continue;
    }
    const double terms[3] = {c.heading, c.distance, c.speed};
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], terms[k]);
      high[k] = std::max(high[k], terms[k]);
    }
  }
  const auto normal = [&](double value, int k) {
    return high[k] > low[k] ? (value - low[k]) / (high[k] - low[k]) : 1.0;
  };
  const double weights = options.heading_weight + options.distance_weight + options.speed_weight;
  const Candidate* best = nullptr;
  for (Candidate& c : window) {
    if (c.admissible) {
      c.score = (options.heading_weight * normal(c.heading, 0) +
                 options.distance_weight * normal(c.distance, 1) +
                 options.speed_weight * normal(c.speed, 2)) /
                std::max(weights, 1e-12);
      if (best == nullptr || c.score > best->score) {
        best = &c;
      }
    }
    if (request.keep_window) {
      out.window.push_back({c.twist, c.score, c.clearance_m});
    }
  }
  if (best != nullptr && (best->twist.v_mps > 0 || std::abs(best->twist.w_radps) > 0)) {
    bool slowed = false;
    for (std::size_t i = static_cast<std::size_t>(best - window.data()) + options.turn_samples;
         i < window.size(); i += options.turn_samples) {
      slowed = slowed || !window[i].admissible;  // the same turn, faster
    }
    out.choice = DwaChoice{best->twist, best->clearance_m, best->free_path_m, rejected, slowed};
  }
  return out;
}

}  // namespace panoptes
