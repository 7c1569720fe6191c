// SPDX-License-Identifier: BSD-3-Clause
#include "core/loops/loop_closer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "core/base/check.h"
#include "core/geometry/covariance.h"
#include "core/map/contours.h"

namespace panoptes {
namespace {

constexpr int kHalf = 3;      // keyframes on either side of the middle of seven
constexpr int kWords = 1000;  // of a vocabulary: each costs time with every picture
constexpr int kLearned = 10;  // distances needed before their quantile means something
constexpr int kSuppress = 4;  // keyframes to either side of a chosen candidate
constexpr double kThreeSigma = 3;
constexpr double kMountingShare = 3;  // of these, where front and back do not fit as mounted

// What the thesis's rule claims, which knows no covariance of its own: a hand's breadth, 3 degrees.
constexpr double kHistogramSigma_m = 0.1;
constexpr double kHistogramSigma_rad = 0.05;
constexpr double kUnknown_m = 10;  // as good as nothing in a room

double square(double x) { return x * x; }

constexpr std::array<Heading, 2> kHeadings{Heading::kSame, Heading::kOpposite};

double class_heading(Heading heading) { return heading == Heading::kSame ? 0 : std::numbers::pi; }

// Probability that a chi-square variable of three degrees of freedom stays below x.
double chi_square_3(double x) {
  return std::erf(std::sqrt(x / 2)) - std::sqrt(2 * x / std::numbers::pi) * std::exp(-x / 2);
}

double chi_square_3_quantile(double probability) {
  double low = 0;
  double high = 200;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (chi_square_3(middle) < probability ? low : high) = middle;
  }
  return high;
}

Vec3 difference(const Pose2& a, const Pose2& b) {
  return {a.x_m - b.x_m, a.y_m - b.y_m, wrap_angle(a.theta_rad - b.theta_rad)};
}

// Covariance of the inverse of a relative pose.
Mat3 inverted(const Pose2& T_a_b, const Mat3& covariance) {
  const Mat2 Rt = T_a_b.rotation().transpose();
  const Vec2 t = Rt * T_a_b.position();
  Mat3 A = Mat3::Zero();
  A.topLeftCorner<2, 2>() = -Rt;
  A(0, 2) = -t.y();
  A(1, 2) = t.x();
  A(2, 2) = -1;
  return A * covariance * A.transpose();
}

// Of a covariance; no number where it is none.
double largest_sigma_m(const Mat3& covariance) {
  const Mat2 xy = covariance.topLeftCorner<2, 2>();
  const double mean = xy.trace() / 2;
  const double swing = std::hypot((xy(0, 0) - xy(1, 1)) / 2, xy(0, 1));
  return std::sqrt(mean + swing);
}

}  // namespace

void bind(Fields& f, HistogramMethod& o) { f("threshold_grey", o.threshold_grey, positive); }

void bind(Fields& f, VerifiedMethod& o) {
  f("tolerance_m", o.tolerance_m, between(0.1, 3));
  f.angle("tolerance", o.tolerance_rad, between(0.05, 1.2));
  f("nearby_quantile", o.nearby_quantile, between(0, 1));
  f("rows_needed", o.rows_needed, between(0, 2 * kHalf + 1));
  f("prior_floor_m", o.prior_floor_m, between(0, 3));
  f.angle("prior_floor", o.prior_floor_rad, between(0, 1));
  f("gate_probability", o.gate_probability, between(0.5, 0.999999));
  f("chi2_probability", o.chi2_probability, between(0.5, 0.999999));
  f("verify_per_keyframe", o.verify_per_keyframe, between(1, 20));
  f("min_inliers", o.min_inliers, at_least(6));
  f("min_inlier_share", o.min_inlier_share, between(0, 1));
  f("mounting_px", o.mounting_px, not_negative);
  f("min_sigma_m", o.min_sigma_m, between(0, 1));
  f.angle("min_sigma", o.min_sigma_rad, between(0, 1));
  f("max_sigma_m", o.max_sigma_m, between(0, 10));
  f.angle("max_sigma", o.max_sigma_rad, between(0, 1));
  f("contours", o.contours);
  f("contour_overlap", o.contour_overlap, between(0, 1));
  f("contour_ambiguity", o.contour_ambiguity, between(0, 1));
  f("contour_apart_m", o.contour_apart_m, between(0, 10));
  f.angle("contour_apart", o.contour_apart_rad, between(0, 1));
  f.renamed("reach_m", "tolerance_m");
  f.renamed("reach_deg", "tolerance_deg");
  f.renamed("reach_rad", "tolerance_rad");
}

void bind(Fields& f, LoopOptions& o) {
  f.choice("method", o.method);
  f.word("shortlist", o.shortlist,
         {{"signature", Shortlist::kSignature}, {"words", Shortlist::kWords}});
  f.require(
      o.shortlist == Shortlist::kSignature || std::holds_alternative<VerifiedMethod>(o.method),
      "shortlist", "words needs the verified method: the histogram method has no shortlist");
  f("min_path_m", o.min_path_m, at_least(1));
  f("spacing_m", o.spacing_m, not_negative);
  f("features", o.features);
  f("motion", o.motion);
  f.renamed("min_way_m", "min_path_m");
}

GraphEdge closure_edge(const ClosureReport& closure) {
  return {closure.earlier, closure.recent, closure.T_earlier_recent, closure.information, true};
}

double diagonal_max_grey(const DistanceMatrix& matrix, Heading heading) {
  double largest = 0;
  for (int k = 0; k <= 2 * kHalf; ++k) {
    const int column = heading == Heading::kSame ? k : 2 * kHalf - k;
    largest = std::max(largest, static_cast<double>(matrix[k][column]));
  }
  return largest;
}

LoopCloser::LoopCloser(const LoopOptions& options, const LoopCameras& cameras, Rng rng)
    : options_(options), cameras_(cameras), rng_(rng) {
  if (options.shortlist == Shortlist::kWords) {
    words_.emplace(kWords, static_cast<int>(cameras.size()), rng.fork("words"));
  }
}

std::vector<ClosureReport> LoopCloser::close(LoopPlace place, const SharedGraph& graph,
                                             const ContourSource& contours) {
  PANOPTES_CHECK(graph.T_map_node.size() == places_.size() + 1,
                 "the newest keyframe is the graph's last node");
  PANOPTES_CHECK(place.features.size() == cameras_.size(), "a picture's features a camera");
  Remembered remembered;
  remembered.place = std::move(place);
  if (!places_.empty()) {
    const Pose2& before = graph.T_map_node[places_.size() - 1];
    remembered.path_m = places_.back().path_m +
                        (graph.T_map_node[places_.size()].position() - before.position()).norm();
  }
  places_.push_back(std::move(remembered));
  if (words_) {
    words_->add(places_.back().place.features);
  }
  depths(newest(), graph);
  if (places_.size() >= 3 && !places_.back().place.featureless() &&
      !places_[places_.size() - 3].place.partial) {
    const auto emd = static_cast<float>(
        emd_grey(places_.back().place.signature, places_[places_.size() - 3].place.signature));
    nearby_emd_.insert(std::upper_bound(nearby_emd_.begin(), nearby_emd_.end(), emd), emd);
  }
  const int recent = newest() - kHalf;
  if (recent < kHalf || places_[recent].place.featureless()) {
    return {};
  }
  if (const auto* histogram = std::get_if<HistogramMethod>(&options_.method)) {
    return close_by_histogram(*histogram, recent, contours);
  }
  return close_verified(std::get<VerifiedMethod>(options_.method), recent, graph, contours);
}

bool LoopCloser::spaced(int recent, Heading heading) const {
  return places_[recent].path_m >=
         accepted_path_m_[static_cast<std::size_t>(heading)] + options_.spacing_m;
}

void LoopCloser::accept(ClosureReport& report) {
  report.verdict = "accepted";
  report.accepted = true;
  accepted_path_m_[static_cast<std::size_t>(report.heading)] = places_[report.recent].path_m;
}

double LoopCloser::nearby_threshold_grey(const VerifiedMethod& method) const {
  if (static_cast<int>(nearby_emd_.size()) < kLearned) {
    return std::numeric_limits<double>::infinity();
  }
  const double rank = method.nearby_quantile * static_cast<double>(nearby_emd_.size() - 1);
  return nearby_emd_[static_cast<std::size_t>(rank)];
}

ClosureReport LoopCloser::report_of(int recent, int earlier, Heading heading) const {
  ClosureReport report;
  report.recent = recent;
  report.earlier = earlier;
  report.heading = heading;
  for (int row = 0; row <= 2 * kHalf; ++row) {
    for (int column = 0; column <= 2 * kHalf; ++column) {
      report.matrix[row][column] = static_cast<float>(emd_grey(
          places_[recent - kHalf + row].place.signature,
          places_[earlier - kHalf + column].place.signature, heading == Heading::kOpposite));
    }
  }
  report.emd_grey = report.matrix[kHalf][kHalf];
  report.diagonal_max_grey = diagonal_max_grey(report.matrix, heading);
  return report;
}

const PlaceDepths& LoopCloser::depths(int keyframe, const SharedGraph& graph) {
  Remembered& here = places_[keyframe];
  constexpr int kNeighbours = 2;  // to each side: half a metre of baseline
  const int until = std::min(newest(), keyframe + kNeighbours);
  if (here.depths_until >= until) {
    return here.depths;
  }
  std::vector<Neighbour> neighbours;
  for (int other = std::max(0, keyframe - kNeighbours); other <= until; ++other) {
    if (other != keyframe) {
      neighbours.push_back({&places_[other].place.features,
                            graph.T_map_node[keyframe].inverse() * graph.T_map_node[other]});
    }
  }
  here.depths =
      triangulate(options_.features, options_.motion, cameras_, here.place.features, neighbours);
  here.depths_until = until;
  return here.depths;
}

std::vector<LoopCloser::Candidate> LoopCloser::shortlist(const VerifiedMethod& method, int recent,
                                                         const SharedGraph& graph) const {
  std::vector<Heading> headings;
  std::copy_if(kHeadings.begin(), kHeadings.end(), std::back_inserter(headings),
               [&](Heading heading) { return spaced(recent, heading); });
  if (headings.empty()) {
    return {};
  }
  const double threshold_grey = nearby_threshold_grey(method);
  const std::vector<Mat3> covariances = path_covariances(graph, recent);
  const Pose2 T_recent_map = graph.T_map_node[recent].inverse();
  const std::vector<std::array<double, 2>> shared =
      words_ ? words_->shared(recent, recent) : std::vector<std::array<double, 2>>();
  std::vector<Candidate> candidates;
  for (int earlier = kHalf; earlier < recent - 2 * kHalf &&
                            places_[recent].path_m - places_[earlier].path_m >= options_.min_path_m;
       ++earlier) {
    const Pose2 T_recent_earlier = T_recent_map * graph.T_map_node[earlier];
    const Mat3& covariance = covariances[earlier];
    const double distance_m = T_recent_earlier.position().norm();
    const double beyond = std::max(0.0, distance_m - method.tolerance_m);
    if (places_[earlier].place.partial || !covariance.allFinite() ||
        !(beyond <= kThreeSigma * largest_sigma_m(covariance))) {
      continue;
    }
    for (const Heading heading : headings) {
      const double turned =
          std::abs(wrap_angle(T_recent_earlier.theta_rad - class_heading(heading)));
      if (!(turned - method.tolerance_rad <= kThreeSigma * std::sqrt(covariance(2, 2)))) {
        continue;
      }
      Candidate candidate;
      candidate.earlier = earlier;
      candidate.heading = heading;
      candidate.emd_grey =
          emd_grey(places_[recent].place.signature, places_[earlier].place.signature,
                   heading == Heading::kOpposite);
      if (!words_ && candidate.emd_grey > threshold_grey) {
        continue;
      }
      // where the graph expects it, within what one place can mean
      const Vec3 tolerance(square(method.tolerance_m), square(method.tolerance_m),
                           square(method.tolerance_rad));
      const Vec3 floor(square(method.prior_floor_m), square(method.prior_floor_m),
                       square(method.prior_floor_rad));
      const Pose2 T_earlier_recent = T_recent_earlier.inverse();
      Mat3 expected = inverted(T_recent_earlier, covariance);
      expected.diagonal() += floor;
      const Pose2 centre{0, 0, class_heading(heading)};
      const Mat3 gain = expected * (expected + Mat3(tolerance.asDiagonal())).inverse();
      const Vec3 pulled = gain * difference(centre, T_earlier_recent);
      candidate.prior.T_a_b = {T_earlier_recent.x_m + pulled.x(), T_earlier_recent.y_m + pulled.y(),
                               wrap_angle(T_earlier_recent.theta_rad + pulled.z())};
      const Mat3 together = expected - gain * expected;
      candidate.prior.covariance = 0.5 * (together + together.transpose());
      const Vec3 off = difference(centre, T_earlier_recent);
      const Mat3 allowed = expected + Mat3(tolerance.asDiagonal());
      const double unlike = words_ ? 1 - shared[earlier][static_cast<std::size_t>(heading)]
                                   : candidate.emd_grey / std::max(threshold_grey, 1e-3);
      candidate.score = unlike + squared_sigmas(off, allowed);
      if (std::isfinite(candidate.score)) {
        candidates.push_back(candidate);
      }
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score < b.score; });
  std::vector<Candidate> chosen;
  for (const Candidate& candidate : candidates) {
    const bool near = std::any_of(chosen.begin(), chosen.end(), [&](const Candidate& other) {
      return other.heading == candidate.heading &&
             std::abs(other.earlier - candidate.earlier) <= kSuppress;
    });
    if (!near) {
      chosen.push_back(candidate);
      if (static_cast<int>(chosen.size()) == method.verify_per_keyframe) {
        break;
      }
    }
  }
  return chosen;
}

struct LoopCloser::CandidateCheck {
  const VerifiedMethod& method;
  const Candidate& candidate;
  const SharedGraph& graph;
  const ContourSource& contours;
  ClosureReport& report;
  double limit = chi_square_3_quantile(method.gate_probability);
  std::vector<PlaceMatch> matches = {};
  MotionOptions tolerant = {};     // what the motion was found with,
  double floor_share = 1;          // and by how much more than usual the model may be wrong
  PlanarMotion motion = {};        // recent seen from earlier
  Mat3 floor = Mat3::Zero();       // what no picture makes surer
  Mat3 covariance = Mat3::Zero();  // of the motion by the pictures alone
};

std::vector<ClosureReport> LoopCloser::close_verified(const VerifiedMethod& method, int recent,
                                                      const SharedGraph& graph,
                                                      const ContourSource& contours) {
  std::vector<ClosureReport> reports;
  for (const Candidate& candidate : shortlist(method, recent, graph)) {
    reports.push_back(report_of(recent, candidate.earlier, candidate.heading));
    ClosureReport& report = reports.back();
    report.T_earlier_recent = candidate.prior.T_a_b;
    CandidateCheck check{method, candidate, graph, contours, report};
    if (const std::optional<Refusal> refusal = verify(check)) {
      report.verdict = refusal->why;
    } else {
      accept(report);
      break;
    }
  }
  return reports;
}

std::optional<LoopCloser::Refusal> LoopCloser::verify(CandidateCheck& check) {
  std::optional<Refusal> refusal = check_diagonals(check);
  refusal = refusal ? refusal : check_features(check);
  refusal = refusal ? refusal : check_certainty(check);
  refusal = refusal ? refusal : check_cameras(check);
  refusal = refusal ? refusal : check_gate(check);
  refusal = refusal ? refusal : check_tolerance(check);
  refusal = refusal ? refusal : check_contours(check);
  return refusal ? refusal : check_graph(check);
}

// Enough of the keyframes to either side look alike as well.
std::optional<LoopCloser::Refusal> LoopCloser::check_diagonals(const CandidateCheck& check) const {
  const ClosureReport& report = check.report;
  const double threshold_grey = nearby_threshold_grey(check.method);
  int rows = 0;
  for (int row = 0; row <= 2 * kHalf; ++row) {
    const int middle = report.heading == Heading::kSame ? row : 2 * kHalf - row;
    bool near = false;
    for (int column = std::max(0, middle - 1); column <= std::min(2 * kHalf, middle + 1);
         ++column) {
      near = near || report.matrix[row][column] <= threshold_grey;
    }
    rows += near ? 1 : 0;
  }
  if (!words_ && rows < check.method.rows_needed) {
    return Refusal{fmt::format("diagonal: {} of 7 within {:.2f} grey levels, {} needed", rows,
                               threshold_grey, check.method.rows_needed)};
  }
  return std::nullopt;
}

// Enough features agree on one motion.
std::optional<LoopCloser::Refusal> LoopCloser::check_features(CandidateCheck& check) {
  const VerifiedMethod& method = check.method;
  ClosureReport& report = check.report;
  const PlaceFeatures& features_earlier = places_[report.earlier].place.features;
  const PlaceFeatures& features_recent = places_[report.recent].place.features;
  check.matches = match_places(options_.features, features_earlier, features_recent,
                               report.heading == Heading::kOpposite);
  const std::vector<PlaceMatch>& matches = check.matches;
  if (static_cast<int>(matches.size()) < method.min_inliers) {
    return Refusal{
        fmt::format("features: {} matches, {} needed", matches.size(), method.min_inliers)};
  }
  const PlaceDepths& depths_earlier = depths(report.earlier, check.graph);
  const PlaceDepths& depths_recent = depths(report.recent, check.graph);
  Rng rng = rng_.fork(std::to_string(report.recent) + "-" + std::to_string(report.earlier));
  const auto too_few = [&](const std::optional<PlanarMotion>& motion) {
    return !motion || motion->inliers < method.min_inliers ||
           motion->inliers < method.min_inlier_share * motion->matches;
  };
  check.tolerant = options_.motion;
  std::optional<PlanarMotion> motion =
      motion_by_features(check.tolerant, cameras_, features_earlier, depths_earlier,
                         features_recent, depths_recent, matches, check.candidate.prior, &rng);
  if (too_few(motion) && report.heading == Heading::kOpposite) {
    check.floor_share = kMountingShare;
    check.tolerant.noise_px = std::max(check.tolerant.noise_px, method.mounting_px);
    motion =
        motion_by_features(check.tolerant, cameras_, features_earlier, depths_earlier,
                           features_recent, depths_recent, matches, check.candidate.prior, &rng);
  }
  if (motion) {
    report.feature_inliers = motion->inliers;
    report.flow_heading_rad = motion->T_a_b_seen.theta_rad;
  }
  if (too_few(motion)) {
    return Refusal{fmt::format("features: {} of {} agree, {} and {:.0f} % needed",
                               report.feature_inliers, matches.size(), method.min_inliers,
                               100 * method.min_inlier_share)};
  }
  check.motion = *motion;
  return std::nullopt;
}

// The pictures alone tell where it is, and surely enough to be worth its risk.
std::optional<LoopCloser::Refusal> LoopCloser::check_certainty(CandidateCheck& check) const {
  const std::optional<Mat3> seen = inverse_of(check.motion.information_seen);
  if (!seen) {
    return Refusal{"features: the pose is not known in every direction"};
  }
  check.covariance = *seen;
  const double sigma_m = largest_sigma_m(check.covariance);
  if (!(sigma_m <= check.method.max_sigma_m) ||
      !(check.covariance(2, 2) <= square(check.method.max_sigma_rad))) {
    return Refusal{fmt::format("features: pose known to {:.2f} m only", sigma_m)};
  }
  const Vec3 floor = square(check.floor_share) * Vec3(square(check.method.min_sigma_m),
                                                      square(check.method.min_sigma_m),
                                                      square(check.method.min_sigma_rad));
  check.floor = floor.asDiagonal();
  check.covariance += check.floor;
  check.report.T_earlier_recent = check.motion.T_a_b_seen;
  check.report.information = check.covariance.inverse();
  return std::nullopt;
}

// Front and back alone say the same. A camera before a plain wall says nothing, with infinite
// covariance.
std::optional<LoopCloser::Refusal> LoopCloser::check_cameras(CandidateCheck& check) {
  const int earlier = check.report.earlier;
  const int recent = check.report.recent;
  const auto alone = motion_by_each_camera(
      check.tolerant, cameras_, places_[earlier].place.features, depths(earlier, check.graph),
      places_[recent].place.features, depths(recent, check.graph), check.matches,
      {check.motion.T_a_b, check.candidate.prior.covariance});
  const auto says = [&](std::size_t camera) {
    return alone[camera] ? inverse_of(alone[camera]->information_seen) : std::nullopt;
  };
  const std::optional<Mat3> front = says(kLoopFront);
  const std::optional<Mat3> back = says(kLoopBack);
  if (!front || !back) {
    return std::nullopt;
  }
  const Vec3 off = difference(alone[kLoopFront]->T_a_b_seen, alone[kLoopBack]->T_a_b_seen);
  const Mat3 allowed = *front + *back + 2 * check.floor;
  check.report.cameras_sigma = std::sqrt(squared_sigmas(off, allowed));
  if (!(square(check.report.cameras_sigma) <= check.limit)) {
    return Refusal{fmt::format("cameras: front and back are {:.1f} sigma apart, {:.1f} allowed",
                               check.report.cameras_sigma, std::sqrt(check.limit))};
  }
  return std::nullopt;
}

// The graph expects it there.
std::optional<LoopCloser::Refusal> LoopCloser::check_gate(const CandidateCheck& check) const {
  const int earlier = check.report.earlier;
  const int recent = check.report.recent;
  const Pose2 expected = check.graph.T_map_node[earlier].inverse() * check.graph.T_map_node[recent];
  const Vec3 surprise = difference(check.motion.T_a_b_seen, expected);
  const Mat3 allowed = relative_covariance(check.graph, earlier, recent) + check.covariance;
  check.report.gate_sigma = std::sqrt(squared_sigmas(surprise, allowed));
  if (!(square(check.report.gate_sigma) <= check.limit)) {
    return Refusal{fmt::format("gate: {:.1f} sigma from where the graph expects it, {:.1f} allowed",
                               check.report.gate_sigma, std::sqrt(check.limit))};
  }
  return std::nullopt;
}

// It is one place.
std::optional<LoopCloser::Refusal> LoopCloser::check_tolerance(const CandidateCheck& check) const {
  const double apart_m = check.motion.T_a_b_seen.position().norm();
  if (!(apart_m <= check.method.tolerance_m)) {
    return Refusal{
        fmt::format("place: {:.2f} m apart, {:.2f} allowed", apart_m, check.method.tolerance_m)};
  }
  const double turned =
      std::abs(wrap_angle(check.motion.T_a_b_seen.theta_rad - class_heading(check.report.heading)));
  if (!(turned <= check.method.tolerance_rad)) {
    return Refusal{fmt::format("place: turned by {:.1f} degrees, {:.1f} allowed",
                               rad_to_deg(turned), rad_to_deg(check.method.tolerance_rad))};
  }
  return std::nullopt;
}

// The free space around both does not contradict. Contours that share too little, or fit elsewhere
// as well, say nothing.
std::optional<LoopCloser::Refusal> LoopCloser::check_contours(const CandidateCheck& check) const {
  if (!check.contours) {
    return std::nullopt;
  }
  ClosureReport& report = check.report;
  report.contour_earlier = check.contours(report.earlier);
  report.contour_recent = check.contours(report.recent);
  const std::optional<ContourMatch> match =
      align_contours(check.method.contours, report.contour_earlier, report.contour_recent,
                     check.motion.T_a_b_seen);
  if (!match) {
    return std::nullopt;
  }
  report.contour_cost_m = match->mean_distance_m;
  report.contour_overlap = match->overlap;
  const Vec3 off = difference(match->T_fixed_moving, check.motion.T_a_b_seen);
  Mat3 tolerated = check.covariance + match->covariance;
  tolerated.diagonal() += Vec3(square(check.method.contour_apart_m / kThreeSigma),
                               square(check.method.contour_apart_m / kThreeSigma),
                               square(check.method.contour_apart_rad / kThreeSigma));
  if (match->overlap >= check.method.contour_overlap &&
      match->ambiguity() <= check.method.contour_ambiguity &&
      !(squared_sigmas(off, tolerated) <= check.limit)) {
    return Refusal{fmt::format("contours: fit {:.2f} m and {:.1f} degrees away from the features",
                               off.head<2>().norm(), rad_to_deg(std::abs(off.z())))};
  }
  return std::nullopt;
}

// The whole graph agrees after relaxing.
std::optional<LoopCloser::Refusal> LoopCloser::check_graph(const CandidateCheck& check) const {
  SharedGraph tried = check.graph;
  const double before = chi2(tried);
  tried.edges.push_back({closure_edge(check.report), {}, {}});
  const RelaxReport relaxed = relax(tried);
  check.report.chi2_growth = relaxed.chi2_end - before;
  const double limit = chi_square_3_quantile(check.method.chi2_probability);
  if (!relaxed.converged || !(check.report.chi2_growth <= limit)) {
    return Refusal{
        fmt::format("chi2: grows by {:.1f}, {:.1f} allowed", check.report.chi2_growth, limit)};
  }
  return std::nullopt;
}

std::vector<ClosureReport> LoopCloser::close_by_histogram(const HistogramMethod& method, int recent,
                                                          const ContourSource& contours) {
  std::optional<ClosureReport> best;
  for (int earlier = kHalf; earlier < recent - 2 * kHalf &&
                            places_[recent].path_m - places_[earlier].path_m >= options_.min_path_m;
       ++earlier) {
    for (const Heading heading : kHeadings) {
      if (!spaced(recent, heading) || places_[earlier].place.featureless() ||
          emd_grey(places_[recent].place.signature, places_[earlier].place.signature,
                   heading == Heading::kOpposite) >= method.threshold_grey) {
        continue;
      }
      const ClosureReport report = report_of(recent, earlier, heading);
      if (!best || report.diagonal_max_grey < best->diagonal_max_grey) {
        best = report;
      }
    }
  }
  if (!best) {
    return {};
  }
  ClosureReport& report = *best;
  if (report.diagonal_max_grey >= method.threshold_grey) {
    report.verdict = fmt::format("diagonal: up to {:.2f} grey levels, {:.2f} allowed",
                                 report.diagonal_max_grey, method.threshold_grey);
    return {report};
  }
  // heading by the features' flow, position by contours where the robot goes the same way (6.3.3)
  const bool opposite = report.heading == Heading::kOpposite;
  MotionPrior anywhere;
  anywhere.T_a_b = {0, 0, class_heading(report.heading)};
  anywhere.covariance = Vec3(0.09, 0.09, square(0.2)).asDiagonal();
  const PlaceFeatures& features_earlier = places_[report.earlier].place.features;
  const PlaceFeatures& features_recent = places_[recent].place.features;
  Rng rng = rng_.fork(std::to_string(recent) + "-" + std::to_string(report.earlier));
  const std::optional<PlanarMotion> motion = motion_by_features(
      options_.motion, cameras_, features_earlier, {}, features_recent, {},
      match_places(options_.features, features_earlier, features_recent, opposite), anywhere, &rng);
  report.T_earlier_recent = anywhere.T_a_b;
  if (motion) {
    report.feature_inliers = motion->inliers;
    report.flow_heading_rad = motion->T_a_b.theta_rad;
    report.T_earlier_recent.theta_rad = motion->T_a_b.theta_rad;
  }
  double sigma_m = kUnknown_m;
  if (contours && !opposite) {
    report.contour_earlier = contours(report.earlier);
    report.contour_recent = contours(recent);
    const std::optional<ContourMatch> match = align_contours(
        ContourOptions(), report.contour_earlier, report.contour_recent, report.T_earlier_recent);
    if (match) {
      report.contour_cost_m = match->mean_distance_m;
      report.contour_overlap = match->overlap;
      report.T_earlier_recent.x_m = match->T_fixed_moving.x_m;
      report.T_earlier_recent.y_m = match->T_fixed_moving.y_m;
      sigma_m = kHistogramSigma_m;
    }
  }
  report.information =
      Vec3(1 / square(sigma_m), 1 / square(sigma_m), 1 / square(kHistogramSigma_rad)).asDiagonal();
  accept(report);
  return {report};
}

}  // namespace panoptes
