// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/calib/board.h"
#include "core/calib/board_shape.h"
#include "core/calib/verdict.h"
#include "core/camera/rig.h"

namespace panoptes {

/// The corners of a whole board, as one picture shows them.
using BoardCorners = std::vector<Vec2>;

enum class LensModel { kBrownConrady, kEquidistant };

/// What a lens has to be known to, to be good: what all that is built on it takes for granted.
struct LensFitOptions {
  double focal_sigma_ratio = 0.001;  ///< of each focal length
  double centre_sigma_px = 0.3;      ///< of the principal point, each way
  double field_px = 0.1;     ///< of where a direction is drawn, over the picture, at two sigmas
  double picture_use = 0.7;  ///< share of the picture where corners were seen
  double noise_px = 0.3;     ///< of a corner, each way: more is no sharp picture of a board
};

/// How one picture fits.
struct FittedView {
  bool used = false;  ///< else its corners agree with no lens that the other pictures agree with
  Pose3 T_camera_board;
  double rms_px = 0;  ///< sqrt(mean(dx^2 + dy^2))
  bool copy = false;  ///< of another picture, the same to the last bit, and so not used
};

/// A lens, and how well it is known. When `verdict` is kFailed there is no lens: the numbers are
/// not to be told.
struct LensFit {
  Intrinsics lens;
  Eigen::MatrixXd covariance;  ///< of lens_parameters(lens), by the corners' own scatter and spread
  BoardShape shape;
  BoardShape shape_sigma;          ///< standard deviation of each number
  double corner_spread_m = 0;      ///< of the board's corners off that shape, each way
  double noise_px = 0;             ///< standard deviation of a corner, each way
  double reprojection_rms_px = 0;  ///< of the pictures used, sqrt(mean(dx^2 + dy^2))
  std::vector<FittedView> views;   ///< one a picture with a board, in their order
  double field_sigma_rms_px = 0;   ///< how far from the truth the lens may draw a direction: over
  double field_sigma_most_px = 0;  ///< the picture, and where it is worst; a turn of all is none
  double picture_use = 0;          ///< share of the lit cells of the picture with corners in them
  Verdict verdict = Verdict::kFailed;
  std::vector<std::string> reasons;  ///< why it is not good, and what to do, in words

  int used() const;
  int copies() const;
};

/// The parts of a picture that its use is counted in.
inline constexpr int kPartsAcross = 8;
inline constexpr int kPartsDown = 6;

/// The share of the picture's parts that hold a corner; `lit` tells of each part,
/// row by row, whether the lens draws anything there at all (all of them where it is empty).
double picture_use(const std::vector<BoardCorners>& views, int width_px, int height_px,
                   const std::vector<bool>& lit);

/// Lens and boards' poses from the corners of whole boards, by least squares (Zhang 2000, with rays
/// in the place of a pinhole's homographies so that a fisheye starts alike), from several focal
/// lengths so that nothing need be known. The board's shape is fitted with them (Strobl and
/// Hirzinger 2011; Albarelli, Rodola and Torsello 2009), within what is usual. Corners that fit
/// nothing are left out, copies of a picture count once. The scatter of the corners gives the
/// covariance, with what each of the board's corners is off in all pictures alike. A verdict and no
/// lens for too few boards, or boards that do not tell: all facing the camera alike, or all in one
/// part of the picture.
LensFit fit_lens(const LensFitOptions& options, const Board& board,
                 const std::vector<BoardCorners>& views, int width_px, int height_px,
                 LensModel model, const std::vector<bool>& lit = {});

/// The model that explains the corners better (Schwarz 1978: a parameter costs); kBrownConrady
/// where both do alike.
LensFit fit_best_lens(const LensFitOptions& options, const Board& board,
                      const std::vector<BoardCorners>& views, int width_px, int height_px,
                      const std::vector<bool>& lit = {});

/// By how much two lenses draw directions apart, after the turn that brings them nearest: rms and
/// most over the picture, in pixels, as far as it shows what is no more than so much off a's axis.
struct FieldDifference {
  double rms_px = 0;
  double most_px = 0;
};
FieldDifference field_difference(const Intrinsics& a, const Intrinsics& b,
                                 double most_off_axis_rad = deg_to_rad(180));

}  // namespace panoptes
