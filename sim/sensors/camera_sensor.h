// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include <opencv2/core/mat.hpp>

#include "core/base/rng.h"
#include "core/base/time.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/geometry/pose3.h"
#include "sim/render/renderer.h"
#include "sim/sensors/sensor_response.h"
#include "sim/world/world.h"

namespace panoptes::sim {

struct FixedExposure {
  static constexpr std::string_view kName = "fixed";
  double exposure_ms = 2;
  double gain = 1;  ///< of the amplifier behind the sensor
};
void bind(Fields& f, FixedExposure& o);

/// Exposes so that the mean of the picture comes to a grey level; the amplifier helps where the
/// longest exposure is too short. It is settled when the first picture is taken.
struct AutoExposure {
  static constexpr std::string_view kName = "auto";
  double target_grey = 110;
  double least_ms = 0.05;
  double most_ms = 16;
  double most_gain = 8;
  double time_constant_pictures = 4;  ///< of its way to the target, in logarithms of the light
};
void bind(Fields& f, AutoExposure& o);

/// What a camera's sensor does to the light its lens lets through. The defaults are a machine
/// vision camera that exposes by itself; the world's own brightness is what an exposure of
/// `white_ms` at gain 1 shows.
struct SensorOptions {
  std::variant<FixedExposure, AutoExposure> exposure = AutoExposure();
  double white_ms = 2;      ///< so long an exposure at gain 1 draws light 1 white
  double vignetting = 0.2;  ///< share of the light lost in the farthest corner, as cos^4 goes
  SensorNoise noise;
  bool motion_blur = true;  ///< the picture is the mean over the exposure, of what moves as well
  double row_us = 0;        ///< rows are exposed so long after one another; 0: all at once
  bool bayer = false;       ///< one colour a pixel (RGGB), the others interpolated
};
void bind(Fields& f, SensorOptions& o);

/// Where the camera is and how the world looks at an instant.
struct Instant {
  Pose3 T_scene_camera;
  SceneState scene_state;
};

/// What stands between the world and the lens.
enum class Before { kNothing, kHand, kDarkness };

/// One picture as the sensor gives it, and the truth of it, pixel by pixel.
struct SensorImage {
  cv::Mat bgr;
  cv::Mat floor_label;  ///< as in RenderedImage, of the middle of each row's exposure; empty unless
                        ///< asked for
  cv::Mat depth_m;      ///< of an equidistant lens along each pixel's ray; else as in RenderedImage
  cv::Mat instance;     ///< as in RenderedImage
};

/// One camera: its lens, its exposure and its sensor. What it draws by chance comes from the
/// camera's name and the number of the picture alone, so that another camera changes nothing. Where
/// nothing moves during the exposure it costs one drawing (of several views where the lens sees
/// wider than one can show).
class CameraSensor {
 public:
  /// Draws the world as a View sees it.
  using Draw = std::function<RenderedImage(const View&, const RenderOutputs&)>;
  using DrawScene =
      std::function<RenderedImage(const View&, const RenderOutputs&, const SceneState&)>;

  CameraSensor(const std::string& name, const Intrinsics& lens, const SensorOptions& options,
               const Rng& rng);
  ~CameraSensor();
  CameraSensor(CameraSensor&&) noexcept;

  /// `at(dt)` is the instant `dt` after the middle of the exposure (of the middle row). `picture`
  /// grows from call to call.
  SensorImage take(const DrawScene& draw, const std::function<Instant(Duration)>& at,
                   std::int64_t picture, const RenderOutputs& outputs,
                   Before before = Before::kNothing);
  /// The same where the camera alone moves.
  SensorImage take(const Draw& draw, const std::function<Pose3(Duration)>& T_scene_camera_at,
                   std::int64_t picture, const RenderOutputs& outputs);

  double exposure_ms() const;  ///< of the next picture
  double gain() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace panoptes::sim
