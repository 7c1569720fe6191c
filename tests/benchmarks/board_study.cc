// SPDX-License-Identifier: BSD-3-Clause
// How well boards tell a lens: board_study [--corners] [--sets N] [--first SEED] [--pictures N]
//                                          [--view DEGREES] [--noise PX] [--stretch PERCENT]
//                                          [--bow MM] [--wave MM] [--scatter MM] [--upright]
// For each set a lens drawn about a view of so many degrees (a fisheye from 120 on) is seen with N
// boards: by corners alone with so much noise, with --corners, or in drawn pictures with the light
// of a real camera, and then, as long as it is told to be poor, with more of them in the corners of
// the picture, a third as many at a time. A line a set and the summary: errors of f and of the
// centre, of the field (a fisheye's within half its view off the axis) after the turn that explains
// most, and the normalised error squared a dimension. The board may have rows longer than declared,
// be bowed at their ends, and, with --corners, be off by waves of 4 squares or at random. Upright,
// it is not turned about its normal.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <string_view>
#include <vector>

#include <Eigen/Cholesky>

#include "core/calib/lens_fit.h"
#include "core/camera/lens_parameters.h"
#include "core/eval/statistics.h"
#include "tests/support/board_pictures.h"

namespace panoptes {
namespace {

constexpr int kMostTimes = 3;  // as many pictures as at first, and the patience is over

struct Arguments {
  bool corners = false;
  int sets = 20;
  int first = 1;
  int pictures = 40;
  double view_deg = 80;
  double noise_px = 0.1;
  double stretch_percent = 0;
  double bow_mm = 0;
  double wave_mm = 0;
  double scatter_mm = 0;
  bool upright = false;
};

Arguments arguments(int argc, char** argv) {
  Arguments args;
  for (int i = 1; i < argc; ++i) {
    const std::string_view flag = argv[i];
    const auto number = [&] { return i + 1 < argc ? std::atof(argv[++i]) : 0.0; };
    if (flag == "--corners") {
      args.corners = true;
    } else if (flag == "--sets") {
      args.sets = static_cast<int>(number());
    } else if (flag == "--first") {
      args.first = static_cast<int>(number());
    } else if (flag == "--pictures") {
      args.pictures = static_cast<int>(number());
    } else if (flag == "--view") {
      args.view_deg = number();
    } else if (flag == "--noise") {
      args.noise_px = number();
    } else if (flag == "--stretch") {
      args.stretch_percent = number();
    } else if (flag == "--bow") {
      args.bow_mm = number();
    } else if (flag == "--wave") {
      args.wave_mm = number();
    } else if (flag == "--scatter") {
      args.scatter_mm = number();
    } else if (flag == "--upright") {
      args.upright = true;
    } else {
      std::fprintf(stderr, "board_study: no such flag: %s\n", argv[i]);
      std::exit(2);
    }
  }
  return args;
}

Intrinsics drawn_lens(double view_deg, Rng& rng) {
  const double view_rad = deg_to_rad(view_deg * rng.uniform(0.98, 1.02));
  const double k = rng.uniform(0.7, 1.3);
  const Distortion distortion =
      view_deg < 120 ? Distortion(BrownConrady{-0.25 * k, 0.07 * k, rng.uniform(-1e-3, 1e-3),
                                               rng.uniform(-1e-3, 1e-3), rng.uniform(-0.01, 0.01)})
                     : Distortion(Equidistant{-0.012 * k, 0.003 * k, -0.0006 * k, 0.0001 * k});
  Intrinsics lens = lens_of_view(640, 480, view_rad, distortion);
  lens.fy_px *= rng.uniform(0.997, 1.003);
  lens.cx_px += rng.uniform(-10, 10);
  lens.cy_px += rng.uniform(-10, 10);
  return lens;
}

std::vector<Vec3> drawn_corners(const Arguments& args, const Board& board, const BoardShape& shape,
                                Rng& rng) {
  std::vector<Vec3> corners = corners_board(board, shape);
  const double per_m = 2 * std::numbers::pi / (4 * board.square_m);
  const double phase = args.wave_mm > 0 ? rng.uniform(-3.2, 3.2) : 0;
  for (Vec3& p : corners) {
    p.z() += args.wave_mm / 1000 * std::sin(per_m * p.x() + phase) * std::cos(per_m * p.y());
    if (args.scatter_mm > 0) {
      p += args.scatter_mm / 1000 * Vec3(rng.normal(), rng.normal(), rng.normal());
    }
  }
  return corners;
}

double median(const std::vector<double>& values) {
  return values.empty() ? 0 : quantile(values, 0.5);
}

int run(const Arguments& args) {
  const Board board;
  BoardShape shape;
  shape.stretch = args.stretch_percent / 100;
  shape.bow_rows_m = args.bow_mm / 1000;
  BoardPoses held;
  held.most_roll_rad = args.upright ? 0 : held.most_roll_rad;
  std::vector<double> focal_percent;
  std::vector<double> centre_px;
  std::vector<double> field_px;
  std::vector<double> field_most_px;
  double normalised = 0;
  int told = 0;
  int good = 0;
  for (int set = 0; set < args.sets; ++set) {
    Rng rng(args.first + set);
    const Intrinsics truth = drawn_lens(args.view_deg, rng);
    const std::clock_t start = std::clock();
    int pictures = args.pictures;
    const auto poses = board_poses(board, truth, held, pictures, rng);
    const auto fit_of = [&](const std::vector<BoardCorners>& views) {
      return fit_best_lens({}, board, views, truth.width_px, truth.height_px);
    };
    LensFit fit;
    if (args.corners) {
      fit = fit_of(
          seen_corners(drawn_corners(args, board, shape, rng), truth, poses, args.noise_px, rng));
    } else {
      const BoardPainter painter(board, truth, shape);
      std::vector<BoardCorners> views;
      const auto see = [&](const std::vector<Pose3>& more) {
        for (const Pose3& T_camera_board : more) {
          if (const auto corners = find_board(painter.draw(T_camera_board, {}, rng), board)) {
            views.push_back(*corners);
          }
        }
        return fit_of(views);
      };
      fit = see(poses);
      while (fit.verdict == Verdict::kPoor && pictures < kMostTimes * args.pictures) {
        const int more = args.pictures / 3;
        fit = see(board_poses_in_corners(board, truth, more, rng));
        pictures += more;
      }
    }
    const double cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    std::printf("%4d %-6s boards %3d of %3d  noise %.3f px  use %.2f", args.first + set,
                std::string(name(fit.verdict)).c_str(), fit.used(), pictures, fit.noise_px,
                fit.picture_use);
    if (fit.verdict == Verdict::kFailed ||
        fit.lens.distortion.index() != truth.distortion.index()) {
      std::printf("  %s\n", fit.reasons.empty() ? "another model" : fit.reasons.front().c_str());
      continue;
    }
    const Eigen::VectorXd off = lens_parameters(fit.lens) - lens_parameters(truth);
    const double squared =
        off.dot(fit.covariance.ldlt().solve(off)) / static_cast<double>(off.size());
    const FieldDifference field = field_difference(
        truth, fit.lens, args.view_deg < 120 ? deg_to_rad(180) : deg_to_rad(args.view_deg / 2));
    ++told;
    good += fit.verdict == Verdict::kGood;
    normalised += squared;
    focal_percent.push_back(
        100 * std::max(std::abs(off[0] / truth.fx_px), std::abs(off[1] / truth.fy_px)));
    centre_px.push_back(std::max(std::abs(off[2]), std::abs(off[3])));
    field_px.push_back(field.rms_px);
    field_most_px.push_back(field.most_px);
    std::printf(
        "  f %.3f %%  centre %.3f px  field %.3f, most %.3f px (sigma %.3f, %.3f)  "
        "normalised %.2f  board %+.3f (%.3f) %%, %+.3f (%.3f) mm, off it %.3f mm  CPU s %.1f%s%s\n",
        focal_percent.back(), centre_px.back(), field.rms_px, field.most_px, fit.field_sigma_rms_px,
        fit.field_sigma_most_px, squared, 100 * fit.shape.stretch, 100 * fit.shape_sigma.stretch,
        1000 * fit.shape.bow_rows_m, 1000 * fit.shape_sigma.bow_rows_m, 1000 * fit.corner_spread_m,
        cpu_s, fit.reasons.empty() ? "" : "  ",
        fit.reasons.empty() ? "" : fit.reasons.front().c_str());
    std::fflush(stdout);
  }
  const auto most = [](const std::vector<double>& values) {
    return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
  };
  std::printf(
      "%d of %d sets told a lens, %d good; median, most: f %.3f, %.3f %%; centre %.3f, %.3f px; "
      "field rms %.3f, %.3f px; its worst place %.3f, %.3f px; normalised %.2f\n",
      told, args.sets, good, median(focal_percent), most(focal_percent), median(centre_px),
      most(centre_px), median(field_px), most(field_px), median(field_most_px), most(field_most_px),
      told > 0 ? normalised / told : 0);
  return 0;
}

}  // namespace
}  // namespace panoptes

int main(int argc, char** argv) { return panoptes::run(panoptes::arguments(argc, argv)); }
