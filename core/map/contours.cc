// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/contours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

namespace panoptes {
namespace {

constexpr std::size_t kPointsMin = 20;

// The distance of each cell from the fixed contour, cut off at reach, on a lattice around it.
class DistanceField {
 public:
  DistanceField(const std::vector<Vec2>& fixed, double cell_m, double margin_m, double cutoff_m)
      : cell_m_(cell_m), cutoff_m_(static_cast<float>(cutoff_m)) {
    Vec2 low = fixed.front();
    Vec2 high = fixed.front();
    for (const Vec2& p : fixed) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    origin_ = low - Vec2::Constant(margin_m);
    const Vec2 size = (high - low + Vec2::Constant(2 * margin_m)) / cell_m;
    cv::Mat empty(static_cast<int>(size.y()) + 1, static_cast<int>(size.x()) + 1, CV_8U,
                  cv::Scalar(255));
    for (const Vec2& p : fixed) {
      const Vec2 at = (p - origin_) / cell_m;
      empty.at<std::uint8_t>(static_cast<int>(at.y()), static_cast<int>(at.x())) = 0;
    }
    cv::distanceTransform(empty, distance_, cv::DIST_L2, 5, CV_32F);
    distance_ *= cell_m;
    distance_ = cv::min(distance_, cutoff_m);
  }

  float at(double x_m, double y_m) const {
    const auto c = static_cast<int>((x_m - origin_.x()) / cell_m_);
    const auto r = static_cast<int>((y_m - origin_.y()) / cell_m_);
    if (x_m < origin_.x() || y_m < origin_.y() || c >= distance_.cols || r >= distance_.rows) {
      return cutoff_m_;
    }
    return distance_.ptr<float>(r)[c];
  }

  double mean(const std::vector<Vec2>& moving, const Pose2& T) const {
    const double c = std::cos(T.theta_rad);
    const double s = std::sin(T.theta_rad);
    double sum = 0;
    for (const Vec2& p : moving) {
      sum += at(T.x_m + c * p.x() - s * p.y(), T.y_m + s * p.x() + c * p.y());
    }
    return sum / static_cast<double>(moving.size());
  }

  // Distance and its gradient, between the lattice's cells.
  Vec3 smooth(const Vec2& p) const {
    const Vec2 at = (p - origin_) / cell_m_ - Vec2(0.5, 0.5);
    const Vec2 base(std::floor(at.x()), std::floor(at.y()));
    if (!(base.x() >= 0 && base.y() >= 0 && base.x() + 1 < distance_.cols &&
          base.y() + 1 < distance_.rows)) {
      return {0, 0, cutoff_m_};
    }
    const Vec2 f = at - base;
    const float* low =
        distance_.ptr<float>(static_cast<int>(base.y())) + static_cast<int>(base.x());
    const float* high = low + distance_.cols;
    const double dx = (1 - f.y()) * (low[1] - low[0]) + f.y() * (high[1] - high[0]);
    const double dy = (1 - f.x()) * (high[0] - low[0]) + f.x() * (high[1] - low[1]);
    const double d = (1 - f.y()) * ((1 - f.x()) * low[0] + f.x() * low[1]) +
                     f.y() * ((1 - f.x()) * high[0] + f.x() * high[1]);
    return {dx / cell_m_, dy / cell_m_, d};
  }

  double mean_square(const std::vector<Vec2>& moving, const Pose2& T) const {
    double sum = 0;
    for (const Vec2& p : moving) {
      const Vec2 q = T * p;
      const double d = at(q.x(), q.y());
      sum += d * d;
    }
    return sum / static_cast<double>(moving.size());
  }

 private:
  double cell_m_;
  float cutoff_m_;
  Vec2 origin_;
  cv::Mat distance_;
};

std::vector<Vec2> thinned(const std::vector<Vec2>& points, int count_max) {
  const std::size_t stride = (points.size() - 1) / static_cast<std::size_t>(count_max) + 1;
  std::vector<Vec2> out;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    out.push_back(points[i]);
  }
  return out;
}

// Poses of a window turn about the moving contour's own middle, so that turning does not sweep it
// away.
struct Window {
  Vec2 middle;       // of the moving contour
  Vec2 middle_at;    // where the prior puts it
  double theta_rad;  // the prior's

  Pose2 pose(double dx, double dy, double dtheta) const {
    Pose2 T{0, 0, wrap_angle(theta_rad + dtheta)};
    const Vec2 turned = T.rotation() * middle;
    T.x_m = middle_at.x() + dx - turned.x();
    T.y_m = middle_at.y() + dy - turned.y();
    return T;
  }
};

struct Offset {
  double dx = 0;
  double dy = 0;
  double dtheta = 0;
  double cost = 0;
};

bool separate(const Offset& a, const Offset& b, double apart_m, double apart_rad) {
  return std::hypot(a.dx - b.dx, a.dy - b.dy) > apart_m ||
         std::abs(a.dtheta - b.dtheta) > apart_rad;
}

// Gauss-Newton on the squared distances of the points that have a partner; kept only where it
// helps.
void settle(const DistanceField& field, const std::vector<Vec2>& points, const Window& window,
            double partner_m, Offset& o) {
  for (int round = 0; round < 4; ++round) {
    const Pose2 T = window.pose(o.dx, o.dy, o.dtheta);
    const Vec2 middle = T * window.middle;
    Mat3 A = 1e-6 * Mat3::Identity();  // what no point holds stays where it is
    Vec3 b = Vec3::Zero();
    for (const Vec2& p : points) {
      const Vec2 q = T * p;
      const Vec3 g = field.smooth(q);
      if (g.z() > partner_m) {
        continue;
      }
      const Vec2 r = q - middle;
      const Vec3 J(g.x(), g.y(), g.y() * r.x() - g.x() * r.y());
      A += J * J.transpose();
      b += J * g.z();
    }
    const Vec3 d = -A.ldlt().solve(b);
    Offset next{o.dx + d.x(), o.dy + d.y(), o.dtheta + d.z(), 0};
    next.cost = field.mean(points, window.pose(next.dx, next.dy, next.dtheta));
    if (!d.allFinite() || next.cost >= o.cost) {
      return;
    }
    o = next;
  }
}

// How a search goes: where it may, and in what steps.
struct Search {
  const ContourOptions& options;
  const DistanceField& field;
  const Window& window;
  double arm_m = 0;  // how far a turn carries a point
  double step_m = 0;
  double step_rad = 0;
};

bool by_cost(const Offset& a, const Offset& b) { return a.cost < b.cost; }

// The whole window, at a step that the cut-off distance still bridges: the best separate places.
std::vector<Offset> starts_of(const Search& search, const std::vector<Vec2>& points) {
  const ContourOptions& options = search.options;
  const int count_m = static_cast<int>(std::ceil(options.search_m / search.step_m));
  const int count_rad = static_cast<int>(std::ceil(options.search_rad / search.step_rad));
  std::vector<Offset> tried;
  for (int k = -count_rad; k <= count_rad; ++k) {
    for (int j = -count_m; j <= count_m; ++j) {
      for (int i = -count_m; i <= count_m; ++i) {
        Offset o{std::clamp(i * search.step_m, -options.search_m, options.search_m),
                 std::clamp(j * search.step_m, -options.search_m, options.search_m),
                 std::clamp(k * search.step_rad, -options.search_rad, options.search_rad), 0};
        o.cost = search.field.mean(points, search.window.pose(o.dx, o.dy, o.dtheta));
        tried.push_back(o);
      }
    }
  }
  std::stable_sort(tried.begin(), tried.end(), by_cost);
  std::vector<Offset> starts;
  constexpr std::size_t kStarts = 8;
  for (const Offset& o : tried) {
    if (starts.size() == kStarts) {
      break;
    }
    if (std::all_of(starts.begin(), starts.end(), [&](const Offset& s) {
          return separate(o, s, 1.5 * search.step_m, 1.5 * search.step_rad);
        })) {
      starts.push_back(o);
    }
  }
  return starts;
}

// To the best neighbour, for as long as it helps.
void walk(const Search& search, const std::vector<Vec2>& points, double step_m, int rounds,
          Offset& o) {
  const ContourOptions& options = search.options;
  for (int round = 0; round < rounds; ++round) {
    const Offset centre = o;
    for (int k = -1; k <= 1; ++k) {
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
          Offset n{std::clamp(centre.dx + i * step_m, -options.search_m, options.search_m),
                   std::clamp(centre.dy + j * step_m, -options.search_m, options.search_m),
                   std::clamp(centre.dtheta + k * step_m / search.arm_m, -options.search_rad,
                              options.search_rad),
                   0};
          n.cost = search.field.mean(points, search.window.pose(n.dx, n.dy, n.dtheta));
          if (n.cost < o.cost) {
            o = n;
          }
        }
      }
    }
    if (o.cost == centre.cost) {
      break;
    }
  }
}

// From the starts at ever smaller steps, the best first.
std::vector<Offset> finalists_of(const Search& search, std::vector<Offset> starts,
                                 const std::vector<Vec2>& coarse_points,
                                 const std::vector<Vec2>& points) {
  for (Offset& o : starts) {
    walk(search, coarse_points, search.step_m / 2, 4, o);
    walk(search, coarse_points, search.step_m / 4, 4, o);
  }
  std::stable_sort(starts.begin(), starts.end(), by_cost);
  std::vector<Offset> finalists;
  constexpr std::size_t kFinalists = 3;
  for (const Offset& o : starts) {
    if (finalists.size() < kFinalists &&
        std::all_of(finalists.begin(), finalists.end(), [&](const Offset& f) {
          return separate(o, f, search.step_m, search.step_rad);
        })) {
      finalists.push_back(o);
    }
  }
  for (Offset& o : finalists) {
    o.cost = search.field.mean(points, search.window.pose(o.dx, o.dy, o.dtheta));
    walk(search, points, search.step_m / 4, 2, o);
    walk(search, points, search.step_m / 8, 3, o);
    settle(search.field, points, search.window, search.options.partner_m, o);
  }
  std::stable_sort(finalists.begin(), finalists.end(), by_cost);
  return finalists;
}

double overlap_of(const DistanceField& field, const std::vector<Vec2>& points,
                  const Pose2& T_fixed_moving, double partner_m) {
  int partners = 0;
  for (const Vec2& p : points) {
    const Vec2 q = T_fixed_moving * p;
    partners += field.at(q.x(), q.y()) <= partner_m ? 1 : 0;
  }
  return static_cast<double>(partners) / static_cast<double>(points.size());
}

// The curvature of the mean squared distance about an offset, over a window wide enough that the
// lattice does not show. In the turned window the parameters hardly mix: there it is measured.
Mat3 hessian_of(const Search& search, const std::vector<Vec2>& points, const Offset& best,
                double at_best) {
  const double h = 0.05;
  const std::array<double, 3> steps{h, h, h / search.arm_m};
  const auto cost = [&](const Vec3& d) {
    return search.field.mean_square(
        points, search.window.pose(best.dx + d.x(), best.dy + d.y(), best.dtheta + d.z()));
  };
  Mat3 hessian;
  for (int a = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b) {
      Vec3 da = Vec3::Zero();
      Vec3 db = Vec3::Zero();
      da(a) = steps[static_cast<std::size_t>(a)];
      db(b) = steps[static_cast<std::size_t>(b)];
      const double curvature =
          a == b ? (cost(da) - 2 * at_best + cost(-da)) / (da(a) * da(a))
                 : (cost(da + db) - cost(da - db) - cost(db - da) + cost(-da - db)) /
                       (4 * da(a) * db(b));
      hessian(a, b) = curvature;
      hessian(b, a) = curvature;
    }
  }
  return hessian;
}

// Of x, y, theta of the pose. Each correlation length of contour is one measurement, and no
// direction is known worse than the window it was looked for in.
Mat3 information_of(const Search& search, const std::vector<Vec2>& points, const Offset& best,
                    double contour_m, const Pose2& T_fixed_moving) {
  const ContourOptions& options = search.options;
  const double at_best =
      search.field.mean_square(points, search.window.pose(best.dx, best.dy, best.dtheta));
  const Mat3 hessian = hessian_of(search, points, best, at_best);
  const double measurements = std::max(1.0, contour_m / options.correlation_m);
  const double variance = std::max(options.sigma_m * options.sigma_m, at_best);
  // half the Hessian of a squared distance is J^T J
  const Mat3 information_window = 0.5 * hessian * measurements / variance;
  const Vec3 unit(1, 1, 1 / search.arm_m);
  const Mat3 scaled = unit.asDiagonal() * information_window * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(scaled);
  const double least = 1 / (options.search_m * options.search_m);
  const Mat3 kept = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(least).asDiagonal() *
                    eigen.eigenvectors().transpose();
  const Vec3 back(1, 1, search.arm_m);
  const Mat3 bounded = back.asDiagonal() * kept * back.asDiagonal();
  // window offsets (of the middle, and the turn) from offsets of the pose: the middle moves by the
  // translation and by the turn times its own arm
  const Vec2 turned = T_fixed_moving.rotation() * search.window.middle;
  Mat3 J = Mat3::Identity();
  J(0, 2) = -turned.y();
  J(1, 2) = turned.x();
  return J.transpose() * bounded * J;
}

}  // namespace

void bind(Fields& f, ContourOptions& o) {
  f("search_m", o.search_m, between(0.02, 3));
  f.angle("search", o.search_rad, between(0.005, 1));
  f("cutoff_m", o.cutoff_m, between(0.05, 2));
  f("partner_m", o.partner_m, between(0.01, 1));
  f("correlation_m", o.correlation_m, between(0.01, 1));
  f("sigma_m", o.sigma_m, positive);
  f("points_max", o.points_max, at_least(20));
  f.renamed("reach_m", "cutoff_m");
}

std::vector<Vec2> obstacle_contour(const OccupancyMap& map, double free_min_m2,
                                   int border_min_cells) {
  std::vector<Vec2> points;
  if (map.columns == 0 || map.rows == 0) {
    return points;
  }
  cv::Mat free(map.rows, map.columns, CV_8U, cv::Scalar(0));
  cv::Mat occupied = free.clone();
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const Cell cell = map.at(column, row);
      free.at<std::uint8_t>(row, column) = cell == Cell::kFree ? 1 : 0;
      occupied.at<std::uint8_t>(row, column) = cell == Cell::kOccupied ? 1 : 0;
    }
  }
  cv::Mat free_labels;
  cv::Mat stats;
  cv::Mat centroids;
  cv::connectedComponentsWithStats(free, free_labels, stats, centroids, 4);
  const double cells_min = free_min_m2 / (map.cell_m * map.cell_m);
  cv::Mat occupied_labels;
  const int things = cv::connectedComponents(occupied, occupied_labels, 8);
  std::vector<int> border(static_cast<std::size_t>(things), 0);
  std::vector<std::pair<Vec2, int>> found;
  constexpr std::array<std::array<int, 2>, 4> kNeighbours{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      if (free.at<std::uint8_t>(row, column) == 0 ||
          stats.at<int>(free_labels.at<int>(row, column), cv::CC_STAT_AREA) < cells_min) {
        continue;
      }
      for (const auto& [dc, dr] : kNeighbours) {
        if (map.at(column + dc, row + dr) != Cell::kOccupied) {
          continue;
        }
        const int thing = occupied_labels.at<int>(row + dr, column + dc);
        ++border[static_cast<std::size_t>(thing)];
        found.emplace_back(map.centre(column, row) + 0.5 * map.cell_m * Vec2(dc, dr), thing);
      }
    }
  }
  for (const auto& [p, thing] : found) {
    if (border[static_cast<std::size_t>(thing)] >= border_min_cells) {
      points.push_back(p);
    }
  }
  return points;
}

std::optional<ContourMatch> align_contours(const ContourOptions& options,
                                           const std::vector<Vec2>& fixed,
                                           const std::vector<Vec2>& moving,
                                           const Pose2& prior_T_fixed_moving) {
  if (fixed.size() < kPointsMin || moving.size() < kPointsMin) {
    return std::nullopt;
  }
  constexpr double kFieldCell_m = 0.01;
  const DistanceField field(fixed, kFieldCell_m, options.cutoff_m, options.cutoff_m);
  const std::vector<Vec2> points = thinned(moving, options.points_max);
  const std::vector<Vec2> coarse_points = thinned(moving, std::max(20, options.points_max / 4));

  Window window;
  window.middle = Vec2::Zero();
  for (const Vec2& p : points) {
    window.middle += p;
  }
  window.middle /= static_cast<double>(points.size());
  window.middle_at = prior_T_fixed_moving * window.middle;
  window.theta_rad = prior_T_fixed_moving.theta_rad;
  Search search{options, field, window};
  for (const Vec2& p : points) {
    search.arm_m += (p - window.middle).norm();
  }
  search.arm_m = std::max(search.arm_m / static_cast<double>(points.size()), 0.1);
  search.step_m = std::min({0.08, options.cutoff_m / 3, options.search_m});
  search.step_rad = std::min(search.step_m / search.arm_m, options.search_rad);

  const std::vector<Offset> finalists =
      finalists_of(search, starts_of(search, coarse_points), coarse_points, points);
  const Offset best = finalists.front();
  ContourMatch match;
  match.T_fixed_moving = window.pose(best.dx, best.dy, best.dtheta);
  match.mean_distance_m = best.cost;
  match.second_distance_m = options.cutoff_m;
  match.T_fixed_second = match.T_fixed_moving;
  for (const Offset& o : finalists) {
    if (separate(o, best, 2 * search.step_m, 2 * search.step_rad)) {
      match.second_distance_m = o.cost;
      match.T_fixed_second = window.pose(o.dx, o.dy, o.dtheta);
      break;
    }
  }
  match.overlap = overlap_of(field, points, match.T_fixed_moving, options.partner_m);
  const double contour_m = match.overlap * static_cast<double>(moving.size()) * kFieldCell_m;
  match.information = information_of(search, points, best, contour_m, match.T_fixed_moving);
  match.covariance = match.information.inverse();
  return match;
}

}  // namespace panoptes
