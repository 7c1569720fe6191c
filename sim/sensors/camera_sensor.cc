// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/camera_sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "sim/sensors/lens_view.h"

namespace panoptes::sim {
namespace {

// Neighbouring drawings of a blurred picture lie at most so far from one another: a pixel's own
// width smooths over it.
constexpr double kBlurStep_px = 1.0;
constexpr int kMostDrawings = 33;  // of one exposure
// Rows are drawn together as long as what they show moves less than this between them.
constexpr double kRowsStep_px = 0.5;
constexpr int kMostBands = 64;
constexpr int kScoutDivisor = 16;    // of the picture that tells how far away things are
constexpr int kExposureGrid = 8;     // every so many pixels each way are metered
constexpr double kNearest_m = 0.03;  // nothing nearer is drawn
constexpr double kFar_m = 1e6;       // stands for infinitely far
constexpr int kSettlingLooks = 8;

Duration from_ms(double ms) { return from_seconds(ms * 1e-3); }

double mean_grey(const cv::Mat& bgr) {
  std::int64_t sum = 0;
  std::int64_t count = 0;
  const int channels = bgr.channels();
  for (int v = kExposureGrid / 2; v < bgr.rows; v += kExposureGrid) {
    const auto* row = bgr.ptr<std::uint8_t>(v);
    for (int u = kExposureGrid / 2; u < bgr.cols; u += kExposureGrid) {
      for (int c = 0; c < channels; ++c) {
        sum += row[u * channels + c];
      }
      count += channels;
    }
  }
  return count == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(count);
}

void add_light(const cv::Mat& bgr, cv::Mat& sum) {
  if (sum.empty()) {
    sum = cv::Mat(bgr.size(), CV_32SC3, cv::Scalar::all(0));
  }
  const auto count = static_cast<std::size_t>(bgr.cols) * 3;
  for (int v = 0; v < bgr.rows; ++v) {
    const std::uint8_t* __restrict grey = bgr.ptr<std::uint8_t>(v);
    std::int32_t* __restrict light = sum.ptr<std::int32_t>(v);
    for (std::size_t i = 0; i < count; ++i) {
      light[i] += static_cast<std::int32_t>(grey[i]) * grey[i];
    }
  }
}

cv::Mat mean_light(const cv::Mat& sum, int drawings) {
  cv::Mat bgr(sum.size(), CV_8UC3);
  const auto count = static_cast<std::size_t>(sum.cols) * 3;
  const float share = 1.0F / static_cast<float>(drawings);
  for (int v = 0; v < sum.rows; ++v) {
    const std::int32_t* __restrict light = sum.ptr<std::int32_t>(v);
    std::uint8_t* __restrict grey = bgr.ptr<std::uint8_t>(v);
    for (std::size_t i = 0; i < count; ++i) {
      const float s = static_cast<float>(light[i]) * share;
      const float rounded = std::sqrt(s) + 0.5F;  // several at once, which lround is not
      grey[i] = static_cast<std::uint8_t>(static_cast<int>(rounded));
    }
  }
  return bgr;
}

// RGGB: the colour that each pixel's own filter lets through.
cv::Mat mosaic_of(const cv::Mat& bgr) {
  cv::Mat mosaic(bgr.size(), CV_8UC1);
  for (int v = 0; v < bgr.rows; ++v) {
    const auto* in = bgr.ptr<std::uint8_t>(v);
    auto* out = mosaic.ptr<std::uint8_t>(v);
    const std::array<int, 2> channel = v % 2 == 0 ? std::array{2, 1} : std::array{1, 0};
    for (int u = 0; u < bgr.cols; ++u) {
      out[u] = in[3 * u + channel[static_cast<std::size_t>(u % 2)]];
    }
  }
  return mosaic;
}

bool same(const Pose3& a, const Pose3& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

void place(const Drawn& band, int row, Taken& taken) {
  const auto rows = [&](const cv::Mat& from, cv::Mat& to) {
    if (!from.empty()) {
      from.copyTo(to.rowRange(row, row + from.rows));
    }
  };
  rows(band.bgr, taken.bgr);
  rows(band.floor_label, taken.floor_label);
  rows(band.depth_m, taken.depth_m);
  rows(band.instance, taken.instance);
}

}  // namespace

void bind(Fields& f, FixedExposure& o) {
  f("exposure_ms", o.exposure_ms, between(1e-3, 1000));
  f("gain", o.gain, between(0.01, 1000));
}

void bind(Fields& f, AutoExposure& o) {
  f("target_grey", o.target_grey, between(10, 240));
  f("least_ms", o.least_ms, between(1e-3, 1000));
  f("most_ms", o.most_ms, between(1e-3, 1000));
  f.require(o.most_ms >= o.least_ms, "most_ms", "must be >= least_ms");
  f("most_gain", o.most_gain, between(1, 1000));
  f("time_constant_pictures", o.time_constant_pictures, between(0.1, 1000));
}

void bind(Fields& f, SensorOptions& o) {
  f.choice("exposure", o.exposure);
  f("white_ms", o.white_ms, between(1e-3, 1000));
  f("vignetting", o.vignetting, between(0, 0.7));
  f.choice("noise", o.noise);
  f("motion_blur", o.motion_blur);
  f("row_us", o.row_us, between(0, 1000));
  f("bayer", o.bayer);
}

class CameraSensor::Impl {
 public:
  Impl(const std::string& name, const Intrinsics& lens, const SensorOptions& options,
       const Rng& rng)
      : lens_(lens),
        options_(options),
        view_(lens),
        photosites_(lens, options.bayer ? 1 : 3, options.vignetting, options.noise,
                    rng.fork(name)) {
    if (const auto* fixed = std::get_if<FixedExposure>(&options.exposure)) {
      exposure_ms_ = fixed->exposure_ms;
      gain_ = fixed->gain;
    } else {
      set_light(options.white_ms);
    }
  }

  Taken take(const Draw& draw, const std::function<Pose3(Duration)>& T_scene_camera_at,
             std::int64_t picture, const Ask& ask) {
    PANOPTES_CHECK(!last_picture_ || picture > *last_picture_, "pictures are taken in their order");
    if (!last_picture_ && std::holds_alternative<AutoExposure>(options_.exposure)) {
      settle(draw, T_scene_camera_at(Duration{}));
    }
    Taken taken = let_in(draw, T_scene_camera_at, ask);
    taken.bgr = developed(taken.bgr, picture, true);
    if (std::holds_alternative<AutoExposure>(options_.exposure)) {
      const auto& meter = std::get<AutoExposure>(options_.exposure);
      const auto passed = static_cast<double>(last_picture_ ? picture - *last_picture_ : 1);
      adapt(taken.bgr, 1 - std::exp(-passed / meter.time_constant_pictures));
    }
    last_picture_ = picture;
    return taken;
  }

  double exposure_ms() const { return exposure_ms_; }
  double gain() const { return gain_; }

 private:
  /// Of exposure time times gain, which the exposure serves first.
  void set_light(double light_ms) {
    const auto& meter = std::get<AutoExposure>(options_.exposure);
    light_ms = std::clamp(light_ms, meter.least_ms, meter.most_ms * meter.most_gain);
    exposure_ms_ = std::min(light_ms, meter.most_ms);
    gain_ = light_ms / exposure_ms_;
  }

  /// Goes a part of the way to the target. Grey levels are square roots of light.
  void adapt(const cv::Mat& bgr, double part) {
    const auto& meter = std::get<AutoExposure>(options_.exposure);
    const double ratio = meter.target_grey / std::max(mean_grey(bgr), 1.0);
    set_light(exposure_ms_ * gain_ * std::pow(ratio, 2 * part));
  }

  void settle(const Draw& draw, const Pose3& T_scene_camera) {
    for (int i = 0; i < kSettlingLooks; ++i) {
      const double before_ms = exposure_ms_ * gain_;
      cv::Mat bgr = view_.draw(draw, T_scene_camera, drawn_gain(), {}).bgr;
      adapt(developed(bgr, 0, false), 1);
      constexpr double kClose = 0.02;
      if (std::abs(exposure_ms_ * gain_ / before_ms - 1) < kClose) {
        return;
      }
    }
  }

  double drawn_gain() const {
    return exposure_ms_ * gain_ / options_.white_ms * photosites_.headroom();
  }

  cv::Mat developed(cv::Mat& bgr, std::int64_t picture, bool noisy) const {
    if (!options_.bayer) {
      photosites_.expose(bgr, gain_, picture, noisy);
      return bgr;
    }
    cv::Mat mosaic = mosaic_of(bgr);
    photosites_.expose(mosaic, gain_, picture, noisy);
    cv::Mat out;
    cv::cvtColor(mosaic, out, cv::COLOR_BayerRGGB2BGR);
    return out;
  }

  /// The light on the sensor over the exposure of every row.
  Taken let_in(const Draw& draw, const std::function<Pose3(Duration)>& T_scene_camera_at,
               const Ask& ask) {
    const Duration exposure = options_.motion_blur ? from_ms(exposure_ms_) : Duration{};
    const Duration readout = from_seconds(options_.row_us * 1e-6 * (lens_.height_px - 1));
    const Pose3 T_scene_camera = T_scene_camera_at(Duration{});
    int drawings = 1;
    int bands = 1;
    if (moves(T_scene_camera_at, exposure + readout)) {
      const std::vector<Vec3> seen_camera = scout(draw, T_scene_camera);
      drawings = drawings_over(motion_px(seen_camera, T_scene_camera_at, exposure));
      bands = std::clamp(static_cast<int>(std::ceil(
                             motion_px(seen_camera, T_scene_camera_at, readout) / kRowsStep_px)),
                         1, std::min(kMostBands, lens_.height_px));
    }
    Taken taken;
    if (drawings == 1 && bands == 1) {
      Drawn drawn = view_.draw(draw, T_scene_camera, drawn_gain(), ask);
      return {drawn.bgr, drawn.floor_label, drawn.depth_m, drawn.instance};
    }
    const cv::Size size(lens_.width_px, lens_.height_px);
    taken.bgr.create(size, CV_8UC3);
    if (ask.floor_label) {
      taken.floor_label.create(size, CV_8UC1);
    }
    if (ask.depth) {
      taken.depth_m.create(size, CV_32FC1);
    }
    if (ask.instance) {
      taken.instance.create(size, CV_16UC1);
    }
    const int rows_a_band = (lens_.height_px + bands - 1) / bands;
    for (int first = 0; first < lens_.height_px; first += rows_a_band) {
      const int end = std::min(first + rows_a_band, lens_.height_px);
      const double after_middle = (first + end - lens_.height_px) / 2.0;  // rows
      const Duration band_at =
          bands == 1 ? Duration{} : from_seconds(options_.row_us * 1e-6 * after_middle);
      place(integrated(draw, T_scene_camera_at, band_at, exposure, drawings, ask, first, end),
            first, taken);
    }
    return taken;
  }

  /// The mean light on some rows over an exposure about `middle`; the truth is the middle's.
  Drawn integrated(const Draw& draw, const std::function<Pose3(Duration)>& T_scene_camera_at,
                   Duration middle, Duration exposure, int drawings, const Ask& ask, int first,
                   int end) {
    Drawn out;
    cv::Mat light;
    for (int i = 0; i < drawings; ++i) {
      const double part = (i + 0.5) / drawings - 0.5;
      const Duration at = middle + from_seconds(part * to_seconds(exposure));
      const bool is_middle = 2 * i + 1 == drawings;
      Drawn drawn = view_.draw(draw, T_scene_camera_at(at), drawn_gain(), is_middle ? ask : Ask{},
                               first, end);
      if (drawings == 1) {
        return drawn;
      }
      add_light(drawn.bgr, light);
      if (is_middle) {
        out = drawn;
      }
    }
    out.bgr = mean_light(light, drawings);
    return out;
  }

  /// Whether anything in the picture could move by more than is let pass within `span` about the
  /// middle.
  bool moves(const std::function<Pose3(Duration)>& T_scene_camera_at, Duration span) const {
    const Pose3 before = T_scene_camera_at(-span / 2);
    const Pose3 after = T_scene_camera_at(span / 2);
    if (same(before, after)) {
      return false;
    }
    const double turn_rad = before.rotation.angularDistance(after.rotation);
    const double shift_m = (before.translation - after.translation).norm();
    const double finest_px =
        std::max(view_.faces().front().pinhole.fx_px, std::max(lens_.fx_px, lens_.fy_px));
    return (turn_rad + shift_m / kNearest_m) * finest_px > std::min(kBlurStep_px, kRowsStep_px);
  }

  /// Points all over the picture, from a small drawing.
  std::vector<Vec3> scout(const Draw& draw, const Pose3& T_scene_camera) const {
    std::vector<Vec3> seen_camera;
    for (const LensView::Face& face : view_.faces()) {
      View view;
      view.intrinsics = face.pinhole;
      Intrinsics& small = view.intrinsics;
      small.width_px = std::max(small.width_px / kScoutDivisor, 1);
      small.height_px = std::max(small.height_px / kScoutDivisor, 1);
      const double across = static_cast<double>(small.width_px) / face.pinhole.width_px;
      const double down = static_cast<double>(small.height_px) / face.pinhole.height_px;
      small.fx_px *= across;
      small.fy_px *= down;
      small.cx_px = (small.cx_px + 0.5) * across - 0.5;
      small.cy_px = (small.cy_px + 0.5) * down - 0.5;
      view.T_scene_camera = T_scene_camera * face.T_camera_face;
      const cv::Mat depth_m = draw(view, {.depth = true}).depth_m;
      for (int v = 0; v < depth_m.rows; ++v) {
        for (int u = 0; u < depth_m.cols; ++u) {
          const auto z_m = static_cast<double>(depth_m.at<float>(v, u));
          const Vec3 p_face = small.ray(Vec2(u, v)) * (std::isfinite(z_m) ? z_m : kFar_m);
          const Vec3 p_camera = face.T_camera_face * p_face;
          if (lens_.sees(p_camera)) {
            seen_camera.push_back(p_camera);
          }
        }
      }
    }
    return seen_camera;
  }

  /// How far anything of it moves over the picture within `span` about the middle.
  double motion_px(const std::vector<Vec3>& seen_camera,
                   const std::function<Pose3(Duration)>& T_scene_camera_at, Duration span) const {
    if (span == Duration{}) {
      return 0;
    }
    const Pose3 T_scene_camera = T_scene_camera_at(Duration{});
    const Pose3 T_before_camera = T_scene_camera_at(-span / 2).inverse() * T_scene_camera;
    const Pose3 T_after_camera = T_scene_camera_at(span / 2).inverse() * T_scene_camera;
    double most_px = 0;
    for (const Vec3& p_camera : seen_camera) {
      const Vec3 p_before = T_before_camera * p_camera;
      const Vec3 p_after = T_after_camera * p_camera;
      if (lens_.sees(p_before) && lens_.sees(p_after)) {
        most_px = std::max(most_px, (lens_.project(p_after) - lens_.project(p_before)).norm());
      }
    }
    return most_px;
  }

  /// An odd number, so that one of them is the middle's.
  static int drawings_over(double motion) {
    const int steps = static_cast<int>(
        std::ceil(std::min(motion / kBlurStep_px, static_cast<double>(kMostDrawings))));
    return steps / 2 * 2 + 1;
  }

  Intrinsics lens_;
  SensorOptions options_;
  LensView view_;
  Photosites photosites_;
  double exposure_ms_ = 0;
  double gain_ = 1;
  std::optional<std::int64_t> last_picture_;
};

CameraSensor::CameraSensor(const std::string& name, const Intrinsics& lens,
                           const SensorOptions& options, const Rng& rng)
    : impl_(std::make_unique<Impl>(name, lens, options, rng)) {}
CameraSensor::~CameraSensor() = default;
CameraSensor::CameraSensor(CameraSensor&&) noexcept = default;

Taken CameraSensor::take(const Draw& draw, const std::function<Pose3(Duration)>& T_scene_camera_at,
                         std::int64_t picture, const Ask& ask) {
  return impl_->take(draw, T_scene_camera_at, picture, ask);
}

double CameraSensor::exposure_ms() const { return impl_->exposure_ms(); }
double CameraSensor::gain() const { return impl_->gain(); }

}  // namespace panoptes::sim
