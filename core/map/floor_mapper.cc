// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_mapper.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/check.h"

namespace panoptes {
namespace {

// What one picture may say of one cell: errors of colour are shared by neighbouring cells and
// pictures, so a clear colour counts for three nats, not for the four that the table holds.
constexpr int kGainNumerator = 3;
constexpr int kGainDenominator = 4;

// Of the table's 32: what a floor's own colours average, with room for noise and texture.
constexpr int kClearly = FloorColour::kClip / 3;

// What is drawn on the floor is floor, if not as surely as what has its colour.
constexpr int kStain = kClearly / 2;

// Of what stands up around a point of it: what it hides, and what surely is its own.
constexpr double kUprightWidth_m = 0.05;
constexpr double kUprightCore_m = 0.015;

// Things that stand no farther apart are one to a robot, which is wider.
constexpr double kJoin_m = 0.35;

// A line that is drawn on the floor, such as the joint of tiles, is no wider.
constexpr double kLine_m = 0.025;
constexpr double kLineShare = 0.5;  // of it; where lines cross they are wider

// A mark is found again so near, noted so often, and known for so long.
constexpr double kMarkReach_m = 0.05;
constexpr double kMarkApart_m = 0.03;
constexpr double kMarkKept_m = 4;

// Enough colours for three Gaussians; more cost time and say nothing new.
constexpr std::size_t kTrainedColours = 1500;

Bgr colour_at(const cv::Mat& bgr, std::int32_t pixel) {
  const std::uint8_t* p = bgr.data + 3 * static_cast<std::ptrdiff_t>(pixel);
  return {p[0], p[1], p[2]};
}

// The mean of 3 x 3 samples; at the borders the nearest row or ray stands in.
std::vector<std::int8_t> mean_of_neighbours(const std::vector<std::int8_t>& scan,
                                            std::size_t rays) {
  const std::size_t rows = scan.size() / rays;
  std::vector<std::int8_t> mean(scan.size());
  std::vector<std::int16_t> sum(rays);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::int8_t* here = &scan[row * rays];
    const std::int8_t* below = &scan[(row > 0 ? row - 1 : row) * rays];
    const std::int8_t* above = &scan[(row + 1 < rows ? row + 1 : row) * rays];
    for (std::size_t ray = 0; ray < rays; ++ray) {
      sum[ray] = static_cast<std::int16_t>(here[ray] + below[ray] + above[ray]);
    }
    std::int8_t* out = &mean[row * rays];
    const auto ninth = [](int total) { return static_cast<std::int8_t>((total * 455) / 4096); };
    out[0] = ninth(2 * sum[0] + sum[1]);
    for (std::size_t ray = 1; ray + 1 < rays; ++ray) {
      out[ray] = ninth(sum[ray - 1] + sum[ray] + sum[ray + 1]);
    }
    out[rays - 1] = ninth(2 * sum[rays - 1] + sum[rays - 2]);
  }
  return mean;
}

}  // namespace

void bind(Fields& f, FloorMapperOptions& o) {
  f("colour", o.colour);
  f("parallax", o.parallax);
  f("parallax_check", o.parallax_check);
  f("upright", o.upright);
  f("faces", o.faces);
  f("stereo", o.stereo);
  f("obstacle_height_m", o.obstacle_height_m, between(0.005, 0.3));
  f("foot_depth_m", o.foot_depth_m, between(0.01, 0.3));
  f("start_far_m", o.start_far_m, positive);
  f("trusted_m", o.trusted_m, between(0.02, 1));
  f("learn_to_m", o.learn_to_m, between(0.1, 5));
  f("learn_every_s", o.learn_every_s, between(0.01, 60));
  f.renamed("learn_every", "learn_every_s");
}

FloorMapper::FloorMapper(const FloorMapperOptions& options, const RigCamera& floor_camera,
                         const Body& body, const RigCamera* second_camera)
    : options_(options),
      learn_every_(
          std::max(1, static_cast<int>(std::lround(options.learn_every_s * floor_camera.rate_hz)))),
      learn_every_s_(floor_camera.rate_hz > 0 ? learn_every_ / floor_camera.rate_hz
                                              : options.learn_every_s),
      projection_(std::make_shared<FloorProjection>(project_floor(floor_camera, body))),
      colour_(options.colour, learn_every_s_),
      body_radius_m_(body.radius_m) {
  const FloorProjection& p = *projection_;
  if (options_.parallax) {
    parallax_.emplace(options_.parallax_check, projection_);
  }
  if (options_.upright) {
    upright_.emplace(projection_, floor_camera.rate_hz);
    edges_.emplace(projection_,
                   second_camera != nullptr ? second_view(p, *second_camera) : std::nullopt);
  }
  if (options_.stereo && options_.upright && second_camera != nullptr) {
    stereo_ = FloorStereo::of(projection_, floor_camera.intrinsics, *second_camera);
  }
  if (options_.faces && second_camera != nullptr) {
    faces_ = UprightFaces::of(p, *second_camera, options_.colour.sigma_min_grey);
  }
  const auto rays = static_cast<std::size_t>(p.rays);
  const auto rows = static_cast<std::size_t>(p.rows);
  const int width = floor_camera.intrinsics.width_px;
  const int height = floor_camera.intrinsics.height_px;
  first_pixel_ = width * height;
  std::int32_t last = 0;
  for (const std::int32_t pixel : p.pixel) {
    if (pixel >= 0) {
      first_pixel_ = std::min(first_pixel_, pixel);
      last = std::max(last, pixel);
    }
  }
  first_pixel_ -= first_pixel_ % width;
  rated_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  ratio_.assign(rays * rows, 0);
  smooth_.assign(rays * rows, 0);
  across_.assign(rays * rows, 0);
  evidence_.assign(rays * rows, 0);
  first_.assign(rays, 0);
  hidden_.assign(rays, static_cast<std::int16_t>(p.rows));
  stands_.assign(rays, 0);
  face_.assign(rays, static_cast<std::int16_t>(p.rows));
  face_ends_.assign(rays, 0);
  mark_ranges_m_.resize(rays);

  // An upright object of height z at range r hides the floor from r to r h / (h - z).
  const double low = std::min(options_.obstacle_height_m, 0.5 * p.height_m);
  const double stretch = p.height_m / (p.height_m - low);
  min_run_.resize(rows);
  foot_run_.resize(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const float range = p.range_m[row * rays];
    int run = 0;
    int foot = 0;
    for (std::size_t beyond = row; beyond < rows; ++beyond) {
      run += p.range_m[beyond * rays] < range * stretch ? 1 : 0;
      foot += p.range_m[beyond * rays] < range + options_.foot_depth_m ? 1 : 0;
    }
    min_run_[row] = std::max(run, 3);  // the mean of 3 x 3 alone makes a run of two
    foot_run_[row] = std::max(foot, 1);
  }

  // The floor just ahead: the disc that is assumed free at the start, as far as it is seen.
  const double trusted_radius = p.front_m + options_.trusted_m;
  double least_side = 1e9;
  for (int ray = 0; ray < p.rays; ++ray) {
    for (int row = 0; row < p.rows; ++row) {
      const auto i = static_cast<std::size_t>(row) * rays + static_cast<std::size_t>(ray);
      if (p.pixel[i] < 0) {
        continue;
      }
      const int u = p.pixel[i] % width;
      const int v = p.pixel[i] / width;
      const Vec3 h = p.H_view_px * Vec3(u, v, 1);
      const Vec2 at = h.hnormalized();
      if (at.norm() <= trusted_radius) {
        trusted_.push_back(p.pixel[i]);
      }
      const double side = std::abs(at.y() - p.foot_view.y()) / p.range_m[i];
      if (side < least_side) {
        least_side = side;
        ahead_ray_ = ray;
      }
    }
  }
}

void FloorMapper::learn_at_start(const cv::Mat& bgr) {
  fault_.clear();
  colour_ = FloorColour(options_.colour, learn_every_s_);
  if (trusted_.size() < 100) {
    fault_ = "the floor just ahead of the robot is not in the picture";
    return;
  }
  std::vector<Bgr> colours;
  double sum = 0;
  for (const std::int32_t pixel : trusted_) {
    colours.push_back(colour_at(bgr, pixel));
    sum += (colours.back()[0] + 2.0 * colours.back()[1] + colours.back()[2]) / 4;
  }
  const double mean = sum / static_cast<double>(colours.size());
  if (mean < 8 || mean > 248) {
    fault_ = "the picture is too dark or too bright to tell the floor by its colour";
    return;
  }
  colour_.learn(fit_colours(colours, options_.colour.trained));
  // What is one floor stands out from "any colour" by its own model; a jumble does not.
  std::size_t clear = 0;
  for (const Bgr& c : colours) {
    clear += colour_.quick(c.data()) > 0 ? 1U : 0U;
  }
  if (clear * 10 < colours.size() * 9) {
    fault_ = "what lies just ahead of the robot has too many colours to be one floor";
    return;
  }
  // One floor, or two where they meet; three colours that no shading joins are an object's.
  if (colour_.voting() > 2) {
    fault_ = "what lies just ahead of the robot has more colours than two floors that meet";
    return;
  }
  if (reaches_horizon(bgr)) {
    fault_ =
        "what lies just ahead of the robot looks the same up to the horizon: a thing, no floor";
    return;
  }
  sees_floor_ = true;
}

// A floor ends somewhere below the horizon; the face of a desk or a wall does not. True when most
// columns of the picture keep the colour of the trusted patch until the floor would be too far.
bool FloorMapper::reaches_horizon(const cv::Mat& bgr) {
  constexpr int kGap_px = 3;  // what is thinner does not end it
  const Mat3& H = projection_->H_view_px;
  std::map<int, int> lowest;  // of the trusted pixels in each column
  for (const std::int32_t pixel : trusted_) {
    int& v = lowest[pixel % bgr.cols];
    v = std::max(v, pixel / bgr.cols);
  }
  std::size_t plain = 0;
  for (const auto& [u, bottom] : lowest) {
    const double sign = (H * Vec3(u, bottom, 1)).z();
    int missed = 0;
    for (int v = bottom; v >= 0 && missed < kGap_px; --v) {
      missed = colour_.quick(bgr.ptr(v) + 3 * static_cast<std::ptrdiff_t>(u)) > 0 ? 0 : missed + 1;
      const Vec3 h = H * Vec3(u, v, 1);
      if (missed == 0 && (h.z() * sign <= 0 || h.hnormalized().norm() > options_.start_far_m)) {
        ++plain;
        break;
      }
    }
  }
  return 2 * plain > lowest.size();
}

void FloorMapper::rate(const cv::Mat& bgr) {
  const std::size_t pixels = rated_.size();
  const std::uint8_t* at = bgr.data + 3 * static_cast<std::ptrdiff_t>(first_pixel_);
  for (auto i = static_cast<std::size_t>(first_pixel_); i < pixels; ++i, at += 3) {
    rated_[i] = colour_.quick(at);
  }
}

// The row of the first sample at this range or beyond.
int FloorMapper::row_at(double range_m) const {
  const FloorProjection& p = *projection_;
  int row = 0;
  while (row < p.rows &&
         p.range_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(p.rays)] < range_m) {
    ++row;
  }
  return row;
}

double FloorMapper::ray_at(const Vec2& from_foot_view) const {
  return (std::atan2(from_foot_view.y(), from_foot_view.x()) - projection_->first_ray_rad) /
         projection_->ray_step_rad;
}

// Where two things stand so near together that no robot passes between them, what shows there
// hides the floor as they do: a wall above a skirting board of the floor's colour has few corners,
// far apart. Neighbours are joined that no third point lies between (Gabriel and Sokal 1969).
void FloorMapper::join_upright(const std::vector<UprightPoint>& found) {
  const std::vector<UprightPoint>& points = upright_->points();
  joins_.clear();
  joined_new_.clear();
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2& a = points[i].p_odom;
    near.clear();
    for (std::size_t j = 0; j < points.size(); ++j) {
      if (j != i && (points[j].p_odom - a).squaredNorm() < kJoin_m * kJoin_m) {
        near.push_back(j);
      }
    }
    for (const std::size_t j : near) {
      const Vec2& b = points[j].p_odom;
      const Vec2 middle = 0.5 * (a + b);
      const double radius2 = 0.25 * (b - a).squaredNorm();
      if (j > i && std::none_of(near.begin(), near.end(), [&](std::size_t k) {
            return k != j && (points[k].p_odom - middle).squaredNorm() < radius2;
          })) {
        joins_.push_back({points[i], points[j]});
      }
    }
  }
  const auto is_new = [&](const UprightPoint& point) {
    return std::any_of(found.begin(), found.end(),
                       [&](const UprightPoint& other) { return other.p_odom == point.p_odom; });
  };
  for (const Join& join : joins_) {
    const double length_m = (join.b.p_odom - join.a.p_odom).norm();
    const int parts = static_cast<int>(std::ceil(length_m / (2 * kUprightWidth_m)));
    if (parts < 2 || !(is_new(join.a) || is_new(join.b))) {
      continue;
    }
    for (int k = 1; k < parts; ++k) {
      const double share = static_cast<double>(k) / parts;
      joined_new_.push_back({join.a.p_odom + share * (join.b.p_odom - join.a.p_odom),
                             std::min(join.a.height_m, join.b.height_m),
                             std::max(join.a.sigma_m, join.b.sigma_m)});
    }
  }
}

// What stands up hides the floor behind its foot, and has a width besides the point that was found.
void FloorMapper::hide(const Vec2& from_foot, double sigma_m) {
  const FloorProjection& p = *projection_;
  const double range_m = from_foot.norm();
  const double middle = ray_at(from_foot);
  const double reach = kUprightWidth_m / range_m / p.ray_step_rad;
  const double core = kUprightCore_m / range_m / p.ray_step_rad;
  const int begin = std::max(0, static_cast<int>(std::ceil(middle - reach)));
  const int end = std::min(p.rays, static_cast<int>(std::floor(middle + reach)) + 1);
  const int row = begin < end ? row_at(range_m + sigma_m) : 0;
  for (int ray = begin; ray < end; ++ray) {
    const auto at = static_cast<std::size_t>(ray);
    // what stands before the floor that is seen is not to be drawn on that
    const bool stands = std::abs(ray - middle) <= std::max(core, 0.5) &&
                        range_m + sigma_m >= static_cast<double>(p.range_m[0]);
    if (row < hidden_[at]) {
      hidden_[at] = static_cast<std::int16_t>(row);
      stands_[at] = stands ? 1 : 0;
    } else if (row == hidden_[at] && stands) {
      stands_[at] = 1;
    }
  }
}

// Calls `of_ray` with each ray between two points near each other, and the range there.
template <class OfRay>
void FloorMapper::between(const Vec2& from_foot_a, const Vec2& from_foot_b, OfRay&& of_ray) const {
  const FloorProjection& p = *projection_;
  const double ray_a = ray_at(from_foot_a);
  const double ray_b = ray_at(from_foot_b);
  const int begin = std::max(0, static_cast<int>(std::ceil(std::min(ray_a, ray_b))));
  const int end = std::min(p.rays, static_cast<int>(std::floor(std::max(ray_a, ray_b))) + 1);
  for (int ray = begin; ray < end; ++ray) {
    const double share = (ray - ray_a) / (ray_b - ray_a);  // near enough: they are close together
    of_ray(static_cast<std::size_t>(ray),
           (from_foot_a + share * (from_foot_b - from_foot_a)).norm());
  }
}

void FloorMapper::hide_between(const Vec2& from_foot_a, const Vec2& from_foot_b, double sigma_m) {
  between(from_foot_a, from_foot_b, [&](std::size_t ray, double range_m) {
    const auto row = static_cast<std::int16_t>(row_at(range_m + sigma_m));
    if (row < hidden_[ray]) {
      hidden_[ray] = row;
      stands_[ray] = 0;
    }
  });
}

void FloorMapper::find_upright(const Pose2& T_odom_body) {
  const FloorProjection& p = *projection_;
  std::fill(hidden_.begin(), hidden_.end(), static_cast<std::int16_t>(p.rows));
  std::fill(stands_.begin(), stands_.end(), std::uint8_t{0});
  const Pose2 T_view_odom = (T_odom_body * p.T_body_view).inverse();
  const auto from_foot = [&](const UprightPoint& point) {
    return Vec2(T_view_odom * point.p_odom - p.foot_view);
  };
  const auto ahead = [](const Vec2& at) { return at.norm() >= kUprightWidth_m && at.x() > 0; };
  for (const UprightPoint& point : upright_->points()) {
    if (const Vec2 at = from_foot(point); ahead(at)) {
      hide(at, point.sigma_m);
    }
  }
  for (const Join& join : joins_) {
    const Vec2 a = from_foot(join.a);
    const Vec2 b = from_foot(join.b);
    if (ahead(a) && ahead(b)) {
      hide_between(a, b, std::max(join.a.sigma_m, join.b.sigma_m));
    }
  }
}

// What stands up on a ray, by where it reaches: floor's colour from its foot on is no floor.
void FloorMapper::find_faces(const Pose2& T_odom_body, const SecondPicture& second_picture) {
  constexpr double kTogether_m = 0.2;  // feet of one face
  const FloorProjection& p = *projection_;
  const Pose2 T_view_then =
      (T_odom_body * p.T_body_view).inverse() * (second_picture.T_odom_body * p.T_body_view);
  const std::vector<std::optional<UprightFaces::Face>> faces =
      faces_->find(second_picture.bgr, levels_ ? &*levels_ : nullptr, colour_);
  for (std::size_t k = 0; k + 1 < faces.size(); ++k) {
    if (!faces[k] || !faces[k + 1]) {
      continue;
    }
    const Vec2 a = T_view_then * faces[k]->foot_view - p.foot_view;
    const Vec2 b = T_view_then * faces[k + 1]->foot_view - p.foot_view;
    if ((a - b).norm() >= kTogether_m || a.x() <= 0 || b.x() <= 0) {
      continue;
    }
    const bool ends = faces[k]->ends && faces[k + 1]->ends;
    const double sigma_m = std::max(faces[k]->depth_m, faces[k + 1]->depth_m);
    between(a, b, [&](std::size_t ray, double range_m) {
      const auto row = static_cast<std::int16_t>(row_at(range_m + sigma_m));
      if (row < face_[ray]) {
        face_[ray] = row;
        face_ends_[ray] = ends ? 1 : 0;
      }
    });
  }
}

// What stands up by where another camera sees it at the same instant.
void FloorMapper::find_stereo(const cv::Mat& bgr, const Pose2& T_odom_body,
                              const SecondPicture& second_picture) {
  constexpr double kSame_m = 0.01;
  constexpr double kSame_rad = deg_to_rad(0.5);
  constexpr double kOther_m = 0.02;  // pictures that show the same say no more than one
  constexpr double kOther_rad = deg_to_rad(3);
  const auto moved = [&](const Pose2& T_odom_then, double m, double rad) {
    const Pose2 T_then_now = T_odom_then.inverse() * T_odom_body;
    return T_then_now.position().norm() > m || std::abs(T_then_now.theta_rad) > rad;
  };
  if (!levels_ || moved(second_picture.T_odom_body, kSame_m, kSame_rad) ||
      (T_odom_stereo_ && !moved(*T_odom_stereo_, kOther_m, kOther_rad))) {
    return;
  }
  T_odom_stereo_ = T_odom_body;
  upright_->suggest(stereo_->find({bgr, smooth_, first_}, second_picture.bgr, *levels_,
                                  T_odom_body * projection_->T_body_view));
}

// How wide across the rays what is no floor is, in rays.
void FloorMapper::measure_across() {
  const FloorProjection& p = *projection_;
  const auto rays = static_cast<std::size_t>(p.rays);
  for (std::size_t row = 0; row < static_cast<std::size_t>(p.rows); ++row) {
    std::size_t ray = 0;
    while (ray < rays) {
      std::size_t end = ray;
      while (end < rays && smooth_[row * rays + end] <= 0) {
        ++end;
      }
      std::fill(across_.begin() + static_cast<std::ptrdiff_t>(row * rays + ray),
                across_.begin() + static_cast<std::ptrdiff_t>(row * rays + end),
                static_cast<std::int16_t>(end - ray));
      ray = end + 1;
    }
  }
}

// Whether samples `row` to `end` of a ray, which show no floor, are of a line that is drawn on it:
// thin along the ray, or across it for the most part.
bool FloorMapper::is_line(std::size_t ray, std::size_t row, std::size_t end) const {
  const FloorProjection& p = *projection_;
  const auto rays = static_cast<std::size_t>(p.rays);
  const auto range_m = [&](std::size_t at) { return static_cast<double>(p.range_m[at * rays]); };
  if (range_m(end) - range_m(row) <= kLine_m) {
    return true;
  }
  std::size_t thin = 0;
  for (std::size_t at = row; at < end; ++at) {
    const double across_m = across_[at * rays + ray] * p.ray_step_rad * range_m(at);
    thin += across_m <= kLine_m ? 1U : 0U;
  }
  return static_cast<double>(thin) >= kLineShare * static_cast<double>(end - row);
}

void FloorMapper::note_edges(const cv::Mat& bgr, const Pose2& T_odom_body,
                             const SecondPicture* second_picture) {
  std::optional<EdgeHeights::Second> second;
  if (second_picture != nullptr && edges_->second()) {
    levels_ = levels_alike(*edges_->second(), second_picture->bgr, *projection_, bgr, smooth_);
    if (levels_ && edges_->is_due(T_odom_body)) {
      const std::vector<std::int8_t> rated =
          rate_second(*edges_->second(), second_picture->bgr, *levels_, colour_);
      second = {mean_of_neighbours(rated, static_cast<std::size_t>(projection_->rays)),
                second_picture->T_odom_body};
    }
  }
  const EdgeHeights::Found found = edges_->add(smooth_, T_odom_body, second);
  upright_->suggest(found.upright);
  std::erase_if(marks_odom_, [&](const Vec2& mark) {
    return (mark - T_odom_body.position()).norm() > kMarkKept_m;
  });
  for (const Vec2& p_odom : found.marks_odom) {
    if (std::none_of(marks_odom_.begin(), marks_odom_.end(), [&](const Vec2& mark) {
          return (mark - p_odom).squaredNorm() < kMarkApart_m * kMarkApart_m;
        })) {
      marks_odom_.push_back(p_odom);
    }
  }
}

void FloorMapper::find_marks(const Pose2& T_odom_body) {
  const FloorProjection& p = *projection_;
  for (std::vector<float>& ranges : mark_ranges_m_) {
    ranges.clear();
  }
  const Pose2 T_view_odom = (T_odom_body * p.T_body_view).inverse();
  for (const Vec2& mark : marks_odom_) {
    const Vec2 at = T_view_odom * mark - p.foot_view;
    const double range_m = at.norm();
    if (!(at.x() > 0 && range_m > kUprightWidth_m)) {
      continue;
    }
    const double middle = ray_at(at);
    const double reach = kMarkReach_m / range_m / p.ray_step_rad;
    const int begin = std::max(0, static_cast<int>(std::ceil(middle - reach)));
    const int end = std::min(p.rays, static_cast<int>(std::floor(middle + reach)) + 1);
    for (int ray = begin; ray < end; ++ray) {
      mark_ranges_m_[static_cast<std::size_t>(ray)].push_back(static_cast<float>(range_m));
    }
  }
}

// Whether what ends at sample `end` of a ray ends on the floor: it is painted there.
bool FloorMapper::is_mark(std::size_t ray, std::size_t end) const {
  const FloorProjection& p = *projection_;
  const std::vector<float>& ranges = mark_ranges_m_[ray];
  if (ranges.empty()) {
    return false;
  }
  const std::size_t i = end * static_cast<std::size_t>(p.rays) + ray;
  const float reach_m = static_cast<float>(kMarkReach_m) + p.depth_m[i];
  return std::any_of(ranges.begin(), ranges.end(),
                     [&](float range_m) { return std::abs(range_m - p.range_m[i]) < reach_m; });
}

void FloorMapper::scan() {
  const FloorProjection& p = *projection_;
  const auto rays = static_cast<std::size_t>(p.rays);
  const auto rows = static_cast<std::size_t>(p.rows);
  for (std::size_t i = 0; i < ratio_.size(); ++i) {
    const std::int32_t pixel = p.pixel[i];
    ratio_[i] = pixel >= 0 ? rated_[static_cast<std::size_t>(pixel)] : std::int8_t{0};
  }
  smooth_ = mean_of_neighbours(ratio_, rays);
  measure_across();
  std::fill(evidence_.begin(), evidence_.end(), std::int8_t{0});
  painted_.clear();
  constexpr int kDivisor = FloorProjection::kFullWeight * kGainDenominator;
  const auto weighed = [&](std::size_t i, int ratio) {
    const int scaled = ratio * p.weight[i] * kGainNumerator;
    return static_cast<std::int8_t>((scaled + (scaled < 0 ? -kDivisor : kDivisor) / 2) / kDivisor);
  };
  const auto mark_foot = [&](std::size_t ray, std::size_t foot) {
    const std::size_t end = std::min(foot + static_cast<std::size_t>(foot_run_[foot]), rows);
    for (std::size_t row = foot; row < end; ++row) {
      if (p.pixel[row * rays + ray] >= 0) {
        evidence_[row * rays + ray] = weighed(row * rays + ray, -kClearly);
      }
    }
  };
  for (std::size_t ray = 0; ray < rays; ++ray) {
    first_[ray] = static_cast<std::int16_t>(rows);
    std::size_t row = 0;
    while (row < rows) {
      const std::size_t i = row * rays + ray;
      const bool is_hidden = static_cast<int>(row) >= hidden_[ray];
      if (is_hidden || (static_cast<int>(row) >= face_[ray] && smooth_[i] > 0)) {
        first_[ray] = static_cast<std::int16_t>(row);
        if (!is_hidden && face_ends_[ray] != 0) {
          mark_foot(ray, row);
        }
        if (stands_[ray] != 0 && hidden_[ray] < static_cast<int>(rows)) {
          mark_foot(ray, static_cast<std::size_t>(hidden_[ray]));
        }
        break;
      }
      if (p.pixel[i] < 0) {
        ++row;
        continue;
      }
      if (smooth_[i] > 0) {
        evidence_[i] = weighed(i, smooth_[i]);
        ++row;
        continue;
      }
      // a run of another colour: an object if it is as tall as one, else a stain or a line
      const auto wanted = static_cast<std::size_t>(min_run_[row]);
      const auto stop = std::min(rows, static_cast<std::size_t>(hidden_[ray]));
      std::size_t end = row;
      int total = 0;
      while (end < stop) {
        const std::size_t j = end * rays + ray;
        if (p.pixel[j] < 0 || smooth_[j] > 0) {
          break;
        }
        total += end - row < wanted ? smooth_[j] : 0;
        ++end;
      }
      const bool left_picture = end == stop || p.pixel[end * rays + ray] < 0;
      const bool line = end - row >= wanted;
      const bool marked = line && !left_picture && is_mark(ray, end);
      if (!left_picture && (!line || marked || is_line(ray, row, end))) {
        // floor goes on behind a stain as clearly as before it; what merely resembles floor there
        // is an object of nearly its colour that stands on its own shadow
        int beyond = 0;
        int samples = 0;
        int clear = 0;
        for (std::size_t k = end; k < stop && k < end + (line ? 2 : 1) * wanted; ++k) {
          if (p.pixel[k * rays + ray] >= 0) {
            beyond += smooth_[k * rays + ray];
            clear += smooth_[k * rays + ray] >= kClearly ? 1 : 0;
            ++samples;
          }
        }
        // behind a line the next one may follow soon
        if (line ? 2 * clear >= static_cast<int>(wanted) : beyond >= kClearly * samples) {
          for (; row < end; ++row) {
            evidence_[row * rays + ray] = weighed(row * rays + ray, kStain);
            if (marked && p.pixel[row * rays + ray] >= 0) {
              painted_.push_back(static_cast<std::int32_t>(row * rays + ray));
            }
          }
          continue;
        }
      }
      first_[ray] = static_cast<std::int16_t>(row);
      const int mean = total / static_cast<int>(std::min(end - row, wanted));
      const std::size_t foot_end = std::min(row + static_cast<std::size_t>(foot_run_[row]), rows);
      for (; row < foot_end; ++row) {
        if (p.pixel[row * rays + ray] >= 0) {
          evidence_[row * rays + ray] = weighed(row * rays + ray, mean);
        }
      }
      break;
    }
  }
}

void FloorMapper::learn(const cv::Mat& bgr) {
  const FloorProjection& p = *projection_;
  const auto rays = static_cast<std::size_t>(p.rays);
  const auto rows = static_cast<std::size_t>(p.rows);
  std::vector<std::int32_t> pixels;
  pixels.reserve(rays * rows);
  for (std::size_t row = 0; row < rows; ++row) {
    if (p.range_m[row * rays] > options_.learn_to_m) {
      break;
    }
    for (std::size_t ray = 0; ray < rays; ++ray) {
      const std::size_t i = row * rays + ray;
      if (static_cast<int>(row) < first_[ray] && p.pixel[i] >= 0 &&
          smooth_[i] > FloorColour::kClip / 2) {
        pixels.push_back(p.pixel[i]);
      }
    }
  }
  const std::size_t stride = pixels.size() / kTrainedColours + 1;
  std::vector<Bgr> colours;
  // an odd start a frame, so that the same columns are not asked every time
  for (std::size_t i = static_cast<std::size_t>(frame_) % stride; i < pixels.size(); i += stride) {
    colours.push_back(colour_at(bgr, pixels[i]));
  }
  colour_.learn(fit_colours(colours, options_.colour.trained));
}

FloorReading FloorMapper::read(const cv::Mat& bgr, const Pose2& T_odom_body, bool may_learn,
                               const SecondPicture* second_picture) {
  PANOPTES_CHECK(bgr.type() == CV_8UC3 && bgr.total() == rated_.size(),
                 "the floor camera's picture is 8-bit BGR of the size its rig says");
  const cv::Mat picture = bgr.isContinuous() ? bgr : bgr.clone();
  if (!sees_floor_) {  // nor has it so far
    learn_at_start(picture);
  }
  const FloorProjection& p = *projection_;
  FloorReading reading;
  reading.projection = projection_;
  reading.sees_floor = sees_floor_;
  reading.fault = fault_;
  rate(picture);
  if (upright_) {
    reading.upright_odom = upright_->add(picture, T_odom_body);
    join_upright(reading.upright_odom);
    reading.upright_odom.insert(reading.upright_odom.end(), joined_new_.begin(), joined_new_.end());
    find_upright(T_odom_body);
    find_marks(T_odom_body);
  }
  std::fill(face_.begin(), face_.end(), static_cast<std::int16_t>(p.rows));
  if (faces_ && second_picture != nullptr) {
    find_faces(T_odom_body, *second_picture);
  }
  scan();
  if (edges_ && sees_floor_) {
    note_edges(picture, T_odom_body, second_picture);
  }
  if (stereo_ && sees_floor_ && second_picture != nullptr) {
    find_stereo(picture, T_odom_body, *second_picture);
  }
  if (sees_floor_ && may_learn) {
    if (parallax_) {
      const FloorParallax::Learned learned =
          parallax_->learn(picture, T_odom_body * projection_->T_body_view, smooth_, first_);
      for (const ColourGaussian& g : learned.floors) {
        colour_.adopt(g);
        reading.learned_new_floor = true;
      }
      if (upright_) {
        upright_->suggest(learned.upright);
      }
    }
    if (frame_ % learn_every_ == 0) {
      learn(picture);
    }
  }
  ++frame_;

  reading.log_ratio = cv::Mat::zeros(picture.size(), CV_32F);
  auto* log_ratio = reading.log_ratio.ptr<float>();
  for (auto i = static_cast<std::size_t>(first_pixel_); i < rated_.size(); ++i) {
    log_ratio[i] = 0.125F * static_cast<float>(rated_[i]);
  }
  reading.evidence.resize(p.sample.size());
  for (std::size_t i = 0; i < p.sample.size(); ++i) {
    const std::int32_t s = p.sample[i];
    reading.evidence[i] = s >= 0 ? evidence_[static_cast<std::size_t>(s)] : std::int8_t{0};
  }
  const Pose2 T_odom_view = T_odom_body * p.T_body_view;
  for (const std::int32_t s : painted_) {
    const double angle = p.first_ray_rad + static_cast<int>(s % p.rays) * p.ray_step_rad;
    reading.painted_odom.push_back(
        T_odom_view * (p.foot_view + static_cast<double>(p.range_m[static_cast<std::size_t>(s)]) *
                                         Vec2(std::cos(angle), std::sin(angle))));
  }
  const auto ahead = static_cast<std::size_t>(ahead_ray_);
  double free_to = 0;
  for (std::size_t row = 0; row < static_cast<std::size_t>(first_[ahead]); ++row) {
    const std::size_t i = row * static_cast<std::size_t>(p.rays) + ahead;
    free_to = p.pixel[i] >= 0 ? static_cast<double>(p.range_m[i]) : free_to;
  }
  reading.free_ahead_m = std::max(0.0, p.foot_view.x() + free_to - body_radius_m_);
  reading.floors = colour_.voting();
  return reading;
}

}  // namespace panoptes
