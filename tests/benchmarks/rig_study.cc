// SPDX-License-Identifier: BSD-3-Clause
// How well a drive tells a rig: rig_study [--motion rose|legs|straight|spin|circle|distant]
//                                         [--runs N] [--first SEED] [--alone] [--false SHARE]
// For each run a rig of 2 to 4 cameras that look away from each other is drawn, with what is
// believed of its mountings, lenses and clocks off by their sigmas and wheels that err by theirs.
// It drives amid points, without pictures, 0.1 px of noise and a share of false matches on what it
// sees, and is adjusted. Alone, no camera sees the points of another. A line a run: what is named
// as not seen, and the normalised error squared a dimension. The summary has for each kind of
// number the share of truths inside the 95 % ellipsoid and the mean of the normalised errors, and
// how often each is named.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Cholesky>

#include "core/eval/statistics.h"
#include "tests/support/driven_rig.h"

namespace panoptes {
namespace {

struct Arguments {
  std::string motion = "rose";
  int runs = 20;
  int first = 1;
  bool shares = true;
  double false_share = 0.02;
};

[[noreturn]] void refuse(std::string_view what) {
  std::fprintf(stderr, "rig_study: no such %s\n", std::string(what).c_str());
  std::exit(2);
}

Arguments arguments(int argc, char** argv) {
  Arguments args;
  for (int i = 1; i < argc; ++i) {
    const std::string_view flag = argv[i];
    const auto number = [&] { return i + 1 < argc ? std::atof(argv[++i]) : 0.0; };
    if (flag == "--motion") {
      args.motion = i + 1 < argc ? argv[++i] : "";
    } else if (flag == "--runs") {
      args.runs = static_cast<int>(number());
    } else if (flag == "--first") {
      args.first = static_cast<int>(number());
    } else if (flag == "--alone") {
      args.shares = false;
    } else if (flag == "--false") {
      args.false_share = number();
    } else {
      refuse("flag: " + std::string(flag));
    }
  }
  return args;
}

RoseShape shape_of(const std::string& motion) {
  RoseShape shape;
  if (motion == "legs") {
    shape.leg_m = 1;
    shape.turn_rad = std::numbers::pi / 2;
    shape.back = false;
  } else if (motion == "straight") {
    shape.legs = 4;
    shape.leg_m = 1;
    shape.turn_rad = 0;
  } else if (motion == "spin") {
    shape.leg_m = 0;
    shape.legs = 18;
  } else if (motion == "circle") {
    shape.legs = 3;
    shape.leg_m = std::numbers::pi;  // about 1 m
    shape.turn_rad = 0;
    shape.leg_turn_rad = 2 * std::numbers::pi;
    shape.back = false;
  } else if (motion != "rose" && motion != "distant") {
    refuse("motion: " + motion);
  }
  return shape;
}

std::vector<RigCamera> drawn_rig(Rng rng) {
  std::vector<RigCamera> rig;
  const int count = 2 + rng.index(3);
  for (int c = 0; c < count; ++c) {
    const double k = rng.uniform(0.7, 1.3);
    const double yaw_rad = 2 * std::numbers::pi * c / count + rng.uniform(-0.2, 0.2);
    RigCamera camera;
    camera.intrinsics = lens_of_view(640, 480, deg_to_rad(rng.uniform(70, 95)),
                                     BrownConrady{-0.2 * k, 0.03 * k, 0, 0, 0});
    const double out_m = rng.uniform(0.1, 0.25);
    camera.T_body_camera = mounted_camera(
        {out_m * std::cos(yaw_rad), out_m * std::sin(yaw_rad), rng.uniform(0.5, 0.9)}, yaw_rad,
        rng.uniform(-0.1, 0.1));
    camera.sigma.focal_ratio = 0.001;
    camera.sigma.centre_px = 0.3;
    camera.sigma.clock_s = 0.005;
    camera.clock_offset_s = camera.sigma.clock_s * rng.normal();
    rig.push_back(camera);
  }
  return rig;
}

/// Normalised errors squared of one kind of numbers, each by its dimension.
struct Errors {
  std::vector<double> normalised;
  int inside = 0;

  double add(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
    const double squared = error.dot(covariance.ldlt().solve(error));
    const auto count = static_cast<double>(error.size());
    // Wilson and Hilferty 1931
    const double most =
        count * std::pow(1 - 2 / (9 * count) + 1.6449 * std::sqrt(2 / (9 * count)), 3);
    inside += squared < most ? 1 : 0;
    normalised.push_back(squared / count);
    return normalised.back();
  }
};

int run(const Arguments& args) {
  std::map<std::string, Errors> errors;
  std::map<std::string, int> named;
  const WheelsKnown wheels;
  int converged = 0;
  for (int i = 0; i < args.runs; ++i) {
    const Rng rng(static_cast<std::uint64_t>(args.first + i));
    const std::clock_t start = std::clock();
    RoseShape shape = shape_of(args.motion);
    Rng wheel = rng.fork("wheels");
    shape.noise_m = 0.005;
    shape.way_error = wheels.sigma[kWayError] * wheel.normal();
    shape.turn_error = wheels.sigma[kTurnError] * wheel.normal();
    shape.turn_per_metre = wheels.sigma[kTurnPerMetre] * wheel.normal();
    DrivenScene scene;
    scene.shares = args.shares;
    scene.false_share = args.false_share;
    if (args.motion == "distant") {
      scene.near_m = 20000;
      scene.far_m = 50000;
    }
    DrivenRig of = driven_rig(drawn_rig(rng.fork("rig")), scene, shape, rng.fork("drive"));
    const RigBundle bundle = adjusted(of);
    converged += bundle.converged ? 1 : 0;
    std::printf("%4d cameras %zu  ", args.first + i, of.truth.size());
    std::map<std::string, int> open;
    const RigCovariance& known = bundle.known;
    double relative = 0;
    double on_body = 0;
    for (std::size_t c = 0; c < of.truth.size(); ++c) {
      for (const std::string& what : known.unobservable[c]) {
        ++open[what];
      }
      const Eigen::Index at = known.camera[c];
      if (c > 0) {
        relative += errors["as the first one sees it"].add(relative_error(of, bundle, c),
                                                           known.relative(bundle.state, 0, c));
      }
      const auto e = body_error(of, bundle, c);
      on_body += errors["on the body"].add(e, known.covariance.block<6, 6>(at, at));
      const std::vector<std::string> names{"roll", "pitch", "yaw", "x", "y", "z"};
      for (Eigen::Index k = 0; k < 6; ++k) {
        errors[names[static_cast<std::size_t>(k)]].add(
            e.segment<1>(k), known.covariance.block<1, 1>(at + k, at + k));
      }
      const Eigen::VectorXd truth = lens_parameters(of.truth[c].intrinsics);
      const Eigen::Index lens = truth.size();
      errors["lens"].add(lens_parameters(bundle.state.lenses[c]) - truth,
                         known.covariance.block(at + 6, at + 6, lens, lens));
      errors["clock"].add(
          Eigen::VectorXd::Constant(1, bundle.state.clock_offset_s[c] - of.truth[c].clock_offset_s),
          known.covariance.block(at + 6 + lens, at + 6 + lens, 1, 1));
    }
    errors["wheels"].add(
        bundle.state.wheel_errors - Vec3(shape.way_error, shape.turn_error, shape.turn_per_metre),
        known.covariance.bottomRightCorner<kWheelErrors, kWheelErrors>());
    const auto count = static_cast<double>(of.truth.size());
    std::printf(
        "normalised %5.2f, on the body %5.2f  noise %.3f px  left out %d of %zu  CPU s %.1f%s%s ",
        relative / (count - 1), on_body / count, bundle.sigma_own_px.front(), bundle.left_out,
        of.tracks.seen.size(), static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC,
        bundle.converged ? "" : "  NOT CONVERGED", bundle.tells_metre ? "" : "  no metre");
    for (const auto& [what, times] : open) {
      std::printf("  %s (%d)", what.c_str(), times);
      named[what] += 1;
      named[what + " of all cameras"] += times == static_cast<int>(of.truth.size()) ? 1 : 0;
    }
    std::printf("\n");
    std::fflush(stdout);
  }
  std::printf("%d of %d runs converged\n", converged, args.runs);
  for (const auto& [what, told] : errors) {
    const auto count = static_cast<double>(told.normalised.size());
    const MeanInterval mean = mean_interval(told.normalised);
    std::printf("%-26s %5.1f %% inside, normalised %.2f (%.2f to %.2f), median %.2f, of %.0f\n",
                what.c_str(), 100 * told.inside / count, mean.mean, mean.low, mean.high,
                quantile(told.normalised, 0.5), count);
  }
  for (const auto& [what, times] : named) {
    std::printf("%-36s named in %d of %d runs\n", what.c_str(), times, args.runs);
  }
  return 0;
}

}  // namespace
}  // namespace panoptes

int main(int argc, char** argv) { return panoptes::run(panoptes::arguments(argc, argv)); }
