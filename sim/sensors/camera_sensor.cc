// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/camera_sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "sim/sensors/injected_fault.h"
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
constexpr int kSettlingDrawings = 8;

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

bool same_places(const SceneState& a, const SceneState& b) {
  return std::ranges::equal(a.T_scene_object, b.T_scene_object,
                            [](const auto& one, const auto& other) {
                              return one.first == other.first && same(one.second, other.second);
                            });
}

/// A point of what the camera sees.
struct Scouted {
  Vec3 p_camera;
  std::size_t instance = 0;  ///< as in RenderedImage
};

/// Where what the camera sees now lies before it at another instant. What has left the place that
/// the world gives it at one of the two alone counts as standing.
class Shift {
 public:
  Shift(const Instant& then, const Instant& now)
      : T_then_now_(then.T_scene_camera.inverse() * now.T_scene_camera) {
    for (const auto& [object, T_scene_now] : now.scene_state.T_scene_object) {
      const auto place = then.scene_state.T_scene_object.find(object);
      if (place != then.scene_state.T_scene_object.end() && !same(place->second, T_scene_now)) {
        moving_[1 + object] = then.T_scene_camera.inverse() * place->second *
                              T_scene_now.inverse() * now.T_scene_camera;
      }
    }
  }

  Vec3 operator()(const Scouted& point) const {
    const auto moving = moving_.find(point.instance);
    return (moving == moving_.end() ? T_then_now_ : moving->second) * point.p_camera;
  }

 private:
  Pose3 T_then_now_;
  std::map<std::size_t, Pose3> moving_;  // by instance
};

void place(const RenderedImage& band, int row, SensorImage& image) {
  const auto rows = [&](const cv::Mat& from, cv::Mat& to) {
    if (!from.empty()) {
      from.copyTo(to.rowRange(row, row + from.rows));
    }
  };
  rows(band.bgr, image.bgr);
  rows(band.floor_label, image.floor_label);
  rows(band.depth_m, image.depth_m);
  rows(band.instance, image.instance);
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
  using At = std::function<Instant(Duration)>;

  Impl(const std::string& name, const Intrinsics& lens, const SensorOptions& options,
       const Rng& rng)
      : lens_(lens),
        options_(options),
        view_(lens),
        response_(lens, options.bayer ? 1 : 3, options.vignetting, options.noise, rng.fork(name)) {
    if (const auto* fixed = std::get_if<FixedExposure>(&options.exposure)) {
      exposure_ms_ = fixed->exposure_ms;
      gain_ = fixed->gain;
    } else {
      set_light(options.white_ms);
    }
  }

  SensorImage take(const DrawScene& draw, const At& at, std::int64_t picture,
                   const RenderOutputs& outputs, Before before) {
    PANOPTES_CHECK(!last_picture_ || picture > *last_picture_, "pictures are taken in their order");
    if (!last_picture_ && std::holds_alternative<AutoExposure>(options_.exposure)) {
      settle_exposure(draw, at(Duration{}));
    }
    SensorImage image = let_in(draw, at, outputs);
    if (before == Before::kHand) {
      cover(image.bgr);
    } else if (before == Before::kDarkness) {
      image.bgr.setTo(cv::Scalar::all(0));
    }
    image.bgr = developed(image.bgr, picture, true);
    if (std::holds_alternative<AutoExposure>(options_.exposure)) {
      const auto& meter = std::get<AutoExposure>(options_.exposure);
      const auto passed = static_cast<double>(last_picture_ ? picture - *last_picture_ : 1);
      adapt(image.bgr, 1 - std::exp(-passed / meter.time_constant_pictures));
    }
    last_picture_ = picture;
    return image;
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

  RenderedImage render(const DrawScene& draw, const Instant& now, const RenderOutputs& outputs,
                       int first, int end) {
    return view_.draw(
        [&](const View& view, const RenderOutputs& of_view) {
          return draw(view, of_view, now.scene_state);
        },
        now.T_scene_camera, render_gain(), outputs, first, end);
  }
  RenderedImage render(const DrawScene& draw, const Instant& now, const RenderOutputs& outputs) {
    return render(draw, now, outputs, 0, lens_.height_px);
  }

  void settle_exposure(const DrawScene& draw, const Instant& now) {
    for (int i = 0; i < kSettlingDrawings; ++i) {
      const double before_ms = exposure_ms_ * gain_;
      cv::Mat bgr = render(draw, now, {}).bgr;
      adapt(developed(bgr, 0, false), 1);
      constexpr double kClose = 0.02;
      if (std::abs(exposure_ms_ * gain_ / before_ms - 1) < kClose) {
        return;
      }
    }
  }

  double render_gain() const {
    return exposure_ms_ * gain_ / options_.white_ms * response_.headroom();
  }

  cv::Mat developed(cv::Mat& bgr, std::int64_t picture, bool noisy) const {
    if (!options_.bayer) {
      response_.expose(bgr, gain_, picture, noisy);
      return bgr;
    }
    cv::Mat mosaic = mosaic_of(bgr);
    response_.expose(mosaic, gain_, picture, noisy);
    cv::Mat out;
    cv::cvtColor(mosaic, out, cv::COLOR_BayerRGGB2BGR);
    return out;
  }

  /// The light on the sensor over the exposure of every row.
  SensorImage let_in(const DrawScene& draw, const At& at, const RenderOutputs& outputs) {
    const Duration exposure = options_.motion_blur ? from_ms(exposure_ms_) : Duration{};
    const Duration readout = from_seconds(options_.row_us * 1e-6 * (lens_.height_px - 1));
    const Instant now = at(Duration{});
    int drawings = 1;
    int bands = 1;
    if (moves(at, exposure + readout)) {
      const std::vector<Scouted> seen = scout(draw, now);
      drawings = drawings_over(motion_px(seen, at, exposure));
      bands = std::clamp(static_cast<int>(std::ceil(motion_px(seen, at, readout) / kRowsStep_px)),
                         1, std::min(kMostBands, lens_.height_px));
    }
    SensorImage image;
    if (drawings == 1 && bands == 1) {
      RenderedImage rendered = render(draw, now, outputs);
      return {rendered.bgr, rendered.floor_label, rendered.depth_m, rendered.instance};
    }
    const cv::Size size(lens_.width_px, lens_.height_px);
    image.bgr.create(size, CV_8UC3);
    if (outputs.floor_label) {
      image.floor_label.create(size, CV_8UC1);
    }
    if (outputs.depth) {
      image.depth_m.create(size, CV_32FC1);
    }
    if (outputs.instance) {
      image.instance.create(size, CV_16UC1);
    }
    const int rows_a_band = (lens_.height_px + bands - 1) / bands;
    for (int first = 0; first < lens_.height_px; first += rows_a_band) {
      const int end = std::min(first + rows_a_band, lens_.height_px);
      const double after_middle = (first + end - lens_.height_px) / 2.0;  // rows
      const Duration band_at =
          bands == 1 ? Duration{} : from_seconds(options_.row_us * 1e-6 * after_middle);
      place(integrated(draw, at, band_at, exposure, drawings, outputs, first, end), first, image);
    }
    return image;
  }

  /// The mean light on some rows over an exposure about `middle`; the truth is the middle's.
  RenderedImage integrated(const DrawScene& draw, const At& at, Duration middle, Duration exposure,
                           int drawings, const RenderOutputs& outputs, int first, int end) {
    RenderedImage out;
    cv::Mat light;
    for (int i = 0; i < drawings; ++i) {
      const double part = (i + 0.5) / drawings - 0.5;
      const Instant now = at(middle + from_seconds(part * to_seconds(exposure)));
      const bool is_middle = 2 * i + 1 == drawings;
      RenderedImage rendered = render(draw, now, is_middle ? outputs : RenderOutputs{}, first, end);
      if (drawings == 1) {
        return rendered;
      }
      add_light(rendered.bgr, light);
      if (is_middle) {
        out = rendered;
      }
    }
    out.bgr = mean_light(light, drawings);
    return out;
  }

  /// Whether anything in the picture could move by more than is let pass within `span` about the
  /// middle.
  bool moves(const At& at, Duration span) const {
    const Instant first = at(-span / 2);
    const Instant last = at(span / 2);
    if (!same_places(first.scene_state, last.scene_state)) {
      return true;
    }
    const Pose3& before = first.T_scene_camera;
    const Pose3& after = last.T_scene_camera;
    if (same(before, after)) {
      return false;
    }
    const double turn_rad = before.rotation.angularDistance(after.rotation);
    const double shift_m = (before.translation - after.translation).norm();
    const double finest_px =
        std::max(view_.faces().front().pinhole.fx_px, std::max(lens_.fx_px, lens_.fy_px));
    return (turn_rad + shift_m / kNearest_m) * finest_px > std::min(kBlurStep_px, kRowsStep_px);
  }

  /// Points all over the picture, from a small drawing; what they are of only where objects move.
  std::vector<Scouted> scout(const DrawScene& draw, const Instant& now) const {
    std::vector<Scouted> seen;
    for (const PinholeFaces::Face& face : view_.faces()) {
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
      view.T_scene_camera = now.T_scene_camera * face.T_camera_face;
      const bool has_dynamic_objects = !now.scene_state.T_scene_object.empty();
      const RenderedImage rendered =
          draw(view, {.depth = true, .instance = has_dynamic_objects}, now.scene_state);
      for (int v = 0; v < rendered.depth_m.rows; ++v) {
        for (int u = 0; u < rendered.depth_m.cols; ++u) {
          const auto z_m = static_cast<double>(rendered.depth_m.at<float>(v, u));
          const Vec3 p_face = small.ray(Vec2(u, v)) * (std::isfinite(z_m) ? z_m : kFar_m);
          const Vec3 p_camera = face.T_camera_face * p_face;
          if (lens_.sees(p_camera)) {
            seen.push_back({p_camera, has_dynamic_objects
                                          ? rendered.instance.at<std::uint16_t>(v, u)
                                          : std::size_t{0}});
          }
        }
      }
    }
    return seen;
  }

  /// How far anything of it moves over the picture within `span` about the middle.
  double motion_px(const std::vector<Scouted>& seen, const At& at, Duration span) const {
    if (span == Duration{}) {
      return 0;
    }
    const Instant now = at(Duration{});
    const Shift before(at(-span / 2), now);
    const Shift after(at(span / 2), now);
    double most_px = 0;
    for (const Scouted& point : seen) {
      const Vec3 p_before = before(point);
      const Vec3 p_after = after(point);
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
  SensorResponse response_;
  double exposure_ms_ = 0;
  double gain_ = 1;
  std::optional<std::int64_t> last_picture_;
};

CameraSensor::CameraSensor(const std::string& name, const Intrinsics& lens,
                           const SensorOptions& options, const Rng& rng)
    : impl_(std::make_unique<Impl>(name, lens, options, rng)) {}
CameraSensor::~CameraSensor() = default;
CameraSensor::CameraSensor(CameraSensor&&) noexcept = default;

SensorImage CameraSensor::take(const DrawScene& draw, const std::function<Instant(Duration)>& at,
                               std::int64_t picture, const RenderOutputs& outputs, Before before) {
  return impl_->take(draw, at, picture, outputs, before);
}

SensorImage CameraSensor::take(const Draw& draw,
                               const std::function<Pose3(Duration)>& T_scene_camera_at,
                               std::int64_t picture, const RenderOutputs& outputs) {
  return impl_->take([&](const View& view, const RenderOutputs& of_view,
                         const SceneState&) { return draw(view, of_view); },
                     [&](Duration after) {
                       return Instant{T_scene_camera_at(after), {}};
                     },
                     picture, outputs, Before::kNothing);
}

double CameraSensor::exposure_ms() const { return impl_->exposure_ms(); }
double CameraSensor::gain() const { return impl_->gain(); }

}  // namespace panoptes::sim
