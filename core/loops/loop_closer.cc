// SPDX-License-Identifier: BSD-3-Clause
#include "core/loops/loop_closer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "core/base/check.h"
#include "core/geometry/covariance.h"
#include "core/map/contours.h"
#include "core/motion/motion_by_rig.h"
#include "core/motion/triangulation.h"

namespace panoptes {
namespace {

constexpr int kHalf = 3;      // keyframes on either side of the middle of seven
constexpr int kWords = 1000;  // of a vocabulary: each costs time with every picture
constexpr int kLearned = 10;  // distances needed before their quantile means something
constexpr int kSuppress = 4;  // keyframes to either side of a chosen candidate
constexpr double kThreeSigma = 3;
constexpr double kMountingShare = 3;  // of these, where two cameras do not fit as mounted
constexpr double kExplained = 0.8;    // of the features that agree on what one camera says alone

// What the thesis's rule claims, which knows no covariance of its own: a hand's breadth, 3 degrees.
constexpr double kHistogramSigma_m = 0.1;
constexpr double kHistogramSigma_rad = 0.05;
constexpr double kUnknown_m = 10;  // as good as nothing in a room

double square(double x) { return x * x; }

bool same_cameras(const Facing& facing) {
  return std::all_of(facing.pairs.begin(), facing.pairs.end(),
                     [](const CameraPair& pair) { return pair.a == pair.b; });
}

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

// What part of a sigma comes from where the cameras are.
std::string of_mounting(const Mat3& covariance) {
  return fmt::format("mounting and lens known to {:.1f} cm and {:.1f} degrees",
                     100 * largest_sigma_m(covariance), rad_to_deg(std::sqrt(covariance(2, 2))));
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

SharedEdge closure_edge(const ClosureReport& closure) {
  return {{closure.earlier, closure.recent, closure.T_earlier_recent, closure.information, true},
          closure.state,
          closure.by_state};
}

double diagonal_max_grey(const DistanceMatrix& matrix, Heading heading) {
  if (heading == Heading::kOther) {
    return matrix[kHalf][kHalf];
  }
  double largest = 0;
  for (int k = 0; k <= 2 * kHalf; ++k) {
    const int column = heading == Heading::kSame ? k : 2 * kHalf - k;
    largest = std::max(largest, static_cast<double>(matrix[k][column]));
  }
  return largest;
}

LoopCloser::LoopCloser(const LoopOptions& options, const LoopCameras& cameras, Rng rng)
    : options_(options), cameras_(cameras), facings_(facings(cameras)), rng_(rng) {
  if (options.shortlist == Shortlist::kWords) {
    words_.emplace(kWords, static_cast<int>(cameras.size()), rng.fork("words"));
  }
}

void LoopCloser::add(LoopPlace place, const SharedGraph& graph) {
  PANOPTES_CHECK(graph.T_map_node.size() == places_.size() + 1,
                 "the newest keyframe is the graph's last node");
  PANOPTES_CHECK(place.features.size() == cameras_.size(), "a picture's features a camera");
  Remembered remembered;
  remembered.place = std::move(place);
  remembered.place.taken.late_s.resize(cameras_.size(), 0);
  if (!places_.empty()) {
    const Pose2& before = graph.T_map_node[places_.size() - 1];
    remembered.path_m = places_.back().path_m +
                        (graph.T_map_node[places_.size()].position() - before.position()).norm();
  }
  places_.push_back(std::move(remembered));
  search_.reset();
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
}

// The keyframe that is tried; none where there is nothing to compare.
std::optional<int> LoopCloser::to_try() const {
  const int recent = newest() - kHalf;
  if (recent < kHalf || places_[recent].place.featureless()) {
    return std::nullopt;
  }
  return recent;
}

void LoopCloser::look(const SharedGraph& graph, const ContourSource& contours) {
  search_.reset();
  const auto* method = std::get_if<VerifiedMethod>(&options_.method);
  const std::optional<int> recent = to_try();
  if (method == nullptr || !recent ||
      std::none_of(facings_.begin(), facings_.end(), [&](const Facing& facing) {
        return spaced(*recent, heading_of(facing.turn_rad));
      })) {
    return;
  }
  search_.emplace(SharedUncertainty(graph));
  search_->candidates = shortlist(*method, *recent, graph, search_->uncertainty);
  verify_next(*method, graph, contours);
}

std::vector<ClosureReport> LoopCloser::close(SharedGraph& graph, const ContourSource& contours) {
  if (const auto* histogram = std::get_if<HistogramMethod>(&options_.method)) {
    const std::optional<int> recent = to_try();
    return recent ? close_by_histogram(*histogram, *recent, graph, contours)
                  : std::vector<ClosureReport>();
  }
  if (!search_) {
    look(graph, contours);
  }
  if (!search_) {
    return {};
  }
  const auto& method = std::get<VerifiedMethod>(options_.method);
  while (search_->agreed) {
    ClosureReport& report = search_->reports.back();
    SharedGraph relaxed;
    if (const std::optional<Refusal> refusal = check_graph(method, graph, report, relaxed)) {
      report.verdict = refusal->why;
      verify_next(method, graph, contours);
    } else {
      accept(report);
      graph = std::move(relaxed);
      break;
    }
  }
  std::vector<ClosureReport> reports = std::move(search_->reports);
  search_.reset();
  return reports;
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

ClosureReport LoopCloser::report_of(int recent, int earlier, const Facing& facing) const {
  ClosureReport report;
  report.recent = recent;
  report.earlier = earlier;
  report.heading = heading_of(facing.turn_rad);
  for (int row = 0; row <= 2 * kHalf; ++row) {
    for (int column = 0; column <= 2 * kHalf; ++column) {
      report.matrix[row][column] =
          static_cast<float>(emd_grey(places_[earlier - kHalf + column].place.signature,
                                      places_[recent - kHalf + row].place.signature, facing));
    }
  }
  report.emd_grey = report.matrix[kHalf][kHalf];
  report.diagonal_max_grey = diagonal_max_grey(report.matrix, report.heading);
  return report;
}

LoopCameras LoopCloser::cameras_at(int keyframe, const SharedGraph& graph) const {
  return at_keyframe(cameras_, graph.state, places_[keyframe].place.taken);
}

void LoopCloser::forget(int camera, int keyframe) {
  search_.reset();
  for (int k = 0; k < std::min(keyframe, static_cast<int>(places_.size())); ++k) {
    Remembered& place = places_[k];
    if (!place.place.features.empty()) {
      place.place.features[camera] = LocalFeatures();
    }
    place.depths = PlaceDepths();
    place.depths_until = -1;
  }
}

const PlaceDepths& LoopCloser::depths(int keyframe, const SharedGraph& graph) {
  Remembered& here = places_[keyframe];
  constexpr int kNeighbours = 2;  // to each side: half a metre of baseline
  const int until = std::min(newest(), keyframe + kNeighbours);
  if (here.depths_until >= until) {
    return here.depths;
  }
  const int from = std::max(0, keyframe - kNeighbours);
  std::vector<LoopCameras> cameras;
  for (int other = from; other <= until; ++other) {
    cameras.push_back(cameras_at(other, graph));
  }
  std::vector<Neighbour> neighbours;
  for (int other = from; other <= until; ++other) {
    if (other != keyframe) {
      neighbours.push_back({cameras[other - from], places_[other].place.features,
                            graph.T_map_node[keyframe].inverse() * graph.T_map_node[other]});
    }
  }
  here.depths = triangulate(options_.features, options_.motion, cameras[keyframe - from],
                            here.place.features, neighbours);
  here.depths_until = until;
  return here.depths;
}

std::vector<LoopCloser::Candidate> LoopCloser::shortlist(
    const VerifiedMethod& method, int recent, const SharedGraph& graph,
    const SharedUncertainty& uncertainty) const {
  const double threshold_grey = nearby_threshold_grey(method);
  const std::vector<Mat3> covariances = path_covariances(graph, recent, uncertainty.states());
  const Pose2 T_recent_map = graph.T_map_node[recent].inverse();
  const std::vector<std::vector<double>> shared =
      words_ ? words_->shared(recent, recent, facings_) : std::vector<std::vector<double>>();
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
    for (std::size_t k = 0; k < facings_.size(); ++k) {
      const Facing& facing = facings_[k];
      const double turned = std::abs(wrap_angle(T_recent_earlier.theta_rad + facing.turn_rad));
      if (!spaced(recent, heading_of(facing.turn_rad)) ||
          !(turned - method.tolerance_rad <= kThreeSigma * std::sqrt(covariance(2, 2)))) {
        continue;
      }
      Candidate candidate;
      candidate.earlier = earlier;
      candidate.facing = &facing;
      candidate.emd_grey =
          emd_grey(places_[earlier].place.signature, places_[recent].place.signature, facing);
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
      const Pose2 centre{0, 0, facing.turn_rad};
      const Mat3 gain = expected * (expected + Mat3(tolerance.asDiagonal())).inverse();
      const Vec3 pulled = gain * difference(centre, T_earlier_recent);
      candidate.prior.T_a_b = {T_earlier_recent.x_m + pulled.x(), T_earlier_recent.y_m + pulled.y(),
                               wrap_angle(T_earlier_recent.theta_rad + pulled.z())};
      const Mat3 together = expected - gain * expected;
      candidate.prior.covariance = 0.5 * (together + together.transpose());
      const Vec3 off = difference(centre, T_earlier_recent);
      const Mat3 allowed = expected + Mat3(tolerance.asDiagonal());
      const double unlike =
          words_ ? 1 - shared[earlier][k] : candidate.emd_grey / std::max(threshold_grey, 1e-3);
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
      return other.facing == candidate.facing &&
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
  const SharedUncertainty& uncertainty;
  const ContourSource& contours;
  ClosureReport& report;
  double limit = chi_square_3_quantile(method.gate_probability);
  LoopCameras cameras_earlier = {};
  LoopCameras cameras_recent = {};
  std::vector<PlaceMatch> matches = {};
  MotionOptions tolerant = {};     // what the motion was found with,
  double floor_share = 1;          // and by how much more than usual the model may be wrong
  PlanarMotion motion = {};        // recent seen from earlier
  Mat3 floor = Mat3::Zero();       // what no picture makes surer
  Mat3 covariance = Mat3::Zero();  // of the motion by the pictures alone, were the rig known,
  Mat3 of_rig = Mat3::Zero();      // and by what is not known of it
};

// Candidates are tried until the pictures agree on one.
void LoopCloser::verify_next(const VerifiedMethod& method, const SharedGraph& graph,
                             const ContourSource& contours) {
  Search& search = *search_;
  search.agreed = false;
  while (search.tried < search.candidates.size() && !search.agreed) {
    const Candidate& candidate = search.candidates[search.tried++];
    search.reports.push_back(report_of(newest() - kHalf, candidate.earlier, *candidate.facing));
    ClosureReport& report = search.reports.back();
    report.T_earlier_recent = candidate.prior.T_a_b;
    CandidateCheck check{method, candidate, graph, search.uncertainty, contours, report};
    const std::optional<Refusal> refusal = verify(check);
    search.agreed = !refusal;
    report.verdict = refusal ? refusal->why : std::string();
  }
}

std::optional<LoopCloser::Refusal> LoopCloser::verify(CandidateCheck& check) {
  std::optional<Refusal> refusal = check_diagonals(check);
  refusal = refusal ? refusal : check_features(check);
  refusal = refusal ? refusal : check_certainty(check);
  refusal = refusal ? refusal : check_cameras(check);
  refusal = refusal ? refusal : check_gate(check);
  refusal = refusal ? refusal : check_tolerance(check);
  return refusal ? refusal : check_contours(check);
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
  if (!words_ && report.heading != Heading::kOther && rows < check.method.rows_needed) {
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
  check.matches =
      match_places(options_.features, features_earlier, features_recent, *check.candidate.facing);
  const std::vector<PlaceMatch>& matches = check.matches;
  if (static_cast<int>(matches.size()) < method.min_inliers) {
    return Refusal{
        fmt::format("features: {} matches, {} needed", matches.size(), method.min_inliers)};
  }
  check.cameras_earlier = cameras_at(report.earlier, check.graph);
  check.cameras_recent = cameras_at(report.recent, check.graph);
  const SeenPlace earlier{check.cameras_earlier, features_earlier,
                          depths(report.earlier, check.graph)};
  const SeenPlace now{check.cameras_recent, features_recent, depths(report.recent, check.graph)};
  Rng rng = rng_.fork(std::to_string(report.recent) + "-" + std::to_string(report.earlier));
  const auto too_few = [&](const std::optional<PlanarMotion>& motion) {
    return !motion || motion->inliers < method.min_inliers ||
           motion->inliers < method.min_inlier_share * motion->matches;
  };
  check.tolerant = options_.motion;
  std::optional<PlanarMotion> motion =
      motion_by_features(check.tolerant, earlier, now, matches, check.candidate.prior, &rng);
  if (too_few(motion) && !same_cameras(*check.candidate.facing)) {
    check.floor_share = kMountingShare;
    check.tolerant.noise_px = std::max(check.tolerant.noise_px, method.mounting_px);
    motion = motion_by_features(check.tolerant, earlier, now, matches, check.candidate.prior, &rng);
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
std::optional<LoopCloser::Refusal> LoopCloser::check_certainty(CandidateCheck& check) {
  const std::optional<Mat3> seen = inverse_of(check.motion.information_seen);
  if (!seen) {
    return Refusal{"features: the pose is not known in every direction"};
  }
  ClosureReport& report = check.report;
  const Remembered& earlier = places_[report.earlier];
  const Remembered& now = places_[report.recent];
  report.state = check.graph.state;
  report.by_state = motion_by_rig(check.tolerant, cameras_, report.state,
                                  {earlier.place.taken, earlier.place.features, earlier.depths},
                                  {now.place.taken, now.place.features, now.depths},
                                  check.motion.inlier_matches, check.motion.T_a_b_seen);
  if (!report.by_state.allFinite()) {
    return Refusal{"features: the pose is not known in every direction"};
  }
  check.of_rig = report.by_state * check.uncertainty.states() * report.by_state.transpose();
  check.covariance = *seen;
  const Mat3 both = check.covariance + check.of_rig;
  const double sigma_m = largest_sigma_m(both);
  if (!(sigma_m <= check.method.max_sigma_m) ||
      !(both(2, 2) <= square(check.method.max_sigma_rad))) {
    return Refusal{fmt::format("features: pose known to {:.2f} m and {:.1f} degrees only, {}",
                               sigma_m, rad_to_deg(std::sqrt(both(2, 2))),
                               of_mounting(check.of_rig))};
  }
  const Vec3 floor = square(check.floor_share) * Vec3(square(check.method.min_sigma_m),
                                                      square(check.method.min_sigma_m),
                                                      square(check.method.min_sigma_rad));
  check.floor = floor.asDiagonal();
  check.covariance += check.floor;
  report.T_earlier_recent = check.motion.T_a_b_seen;
  report.information = check.covariance.inverse();
  return std::nullopt;
}

// Any two cameras alone say the same. One before a plain wall says nothing, with infinite
// covariance; one before things that hardly tell a shift from a turn may say something else and
// still show nearly as much where all cameras together say.
std::optional<LoopCloser::Refusal> LoopCloser::check_cameras(CandidateCheck& check) {
  const Remembered& earlier = places_[check.report.earlier];
  const Remembered& now = places_[check.report.recent];
  const std::vector<std::optional<PlanarMotion>> alone = motion_by_each_camera(
      check.tolerant, {check.cameras_earlier, earlier.place.features, earlier.depths},
      {check.cameras_recent, now.place.features, now.depths}, check.matches,
      {check.motion.T_a_b, check.candidate.prior.covariance});
  struct Voice {
    std::size_t camera;
    Mat3 covariance;
    Eigen::MatrixXd by_state;
  };
  std::vector<Voice> voices;
  for (std::size_t camera = 0; camera < alone.size(); ++camera) {
    const std::optional<Mat3> says =
        alone[camera] ? inverse_of(alone[camera]->information_seen) : std::nullopt;
    if (says) {
      voices.push_back({camera, *says,
                        motion_by_rig(check.tolerant, cameras_, check.report.state,
                                      {earlier.place.taken, earlier.place.features, earlier.depths},
                                      {now.place.taken, now.place.features, now.depths},
                                      alone[camera]->inlier_matches, alone[camera]->T_a_b_seen)});
    }
  }
  const auto explained = [&](const Voice& voice) {
    return check.motion.inliers_by_camera[voice.camera] >=
           kExplained * alone[voice.camera]->inliers;
  };
  for (std::size_t i = 0; i < voices.size(); ++i) {
    for (std::size_t j = i + 1; j < voices.size(); ++j) {
      const Voice& one = voices[i];
      const Voice& other = voices[j];
      const Vec3 off = difference(alone[one.camera]->T_a_b_seen, alone[other.camera]->T_a_b_seen);
      const Eigen::MatrixXd by_state = one.by_state - other.by_state;
      if (!by_state.allFinite()) {
        continue;  // near nothing is said by one of them
      }
      const Mat3 of_rig = by_state * check.uncertainty.states() * by_state.transpose();
      const Mat3 allowed = one.covariance + other.covariance + 2 * check.floor + of_rig;
      const double sigma = std::sqrt(squared_sigmas(off, allowed));
      check.report.cameras_sigma = std::max(check.report.cameras_sigma, sigma);
      if (!(square(sigma) <= check.limit) &&
          !(std::isfinite(sigma) && explained(one) && explained(other))) {
        return Refusal{fmt::format(
            "cameras: {} and {} are {:.1f} cm and {:.1f} degrees apart, {:.1f} sigma, {:.1f} "
            "allowed, {}",
            cameras_[one.camera].name, cameras_[other.camera].name, 100 * off.head<2>().norm(),
            rad_to_deg(std::abs(off.z())), sigma, std::sqrt(check.limit), of_mounting(of_rig))};
      }
    }
  }
  return std::nullopt;
}

// The graph expects it there.
std::optional<LoopCloser::Refusal> LoopCloser::check_gate(const CandidateCheck& check) const {
  const int earlier = check.report.earlier;
  const int recent = check.report.recent;
  const Pose2 expected = check.graph.T_map_node[earlier].inverse() * check.graph.T_map_node[recent];
  const Vec3 surprise = difference(check.motion.T_a_b_seen, expected);
  const Mat3 allowed =
      check.uncertainty.relative(earlier, recent, check.report.by_state) + check.covariance;
  check.report.gate_sigma = std::sqrt(squared_sigmas(surprise, allowed));
  if (!(square(check.report.gate_sigma) <= check.limit)) {
    return Refusal{
        fmt::format("gate: {:.1f} sigma from where the graph expects it, {:.1f} allowed, {}",
                    check.report.gate_sigma, std::sqrt(check.limit), of_mounting(check.of_rig))};
  }
  return std::nullopt;
}

// It is surely one place.
std::optional<LoopCloser::Refusal> LoopCloser::check_tolerance(const CandidateCheck& check) const {
  const double apart_m = check.motion.T_a_b_seen.position().norm();
  const double unsure_m = kThreeSigma * largest_sigma_m(check.covariance + check.of_rig);
  if (!(apart_m + unsure_m <= check.method.tolerance_m)) {
    return Refusal{fmt::format("place: {:.2f} m apart, known to {:.2f} m, {:.2f} allowed", apart_m,
                               unsure_m, check.method.tolerance_m)};
  }
  const double turned =
      std::abs(wrap_angle(check.motion.T_a_b_seen.theta_rad - check.candidate.facing->turn_rad));
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
  Mat3 tolerated = check.covariance + check.of_rig + match->covariance;
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
std::optional<LoopCloser::Refusal> LoopCloser::check_graph(const VerifiedMethod& method,
                                                           const SharedGraph& graph,
                                                           ClosureReport& report,
                                                           SharedGraph& relaxed) const {
  relaxed = graph;
  const double before = chi2(relaxed);
  relaxed.edges.push_back(closure_edge(report));
  const RelaxReport done = relax(relaxed);
  report.chi2_growth = done.chi2_end - before;
  const double limit = chi_square_3_quantile(method.chi2_probability);
  if (!done.converged || !(report.chi2_growth <= limit)) {
    return Refusal{fmt::format("chi2: grows by {:.1f}, {:.1f} allowed", report.chi2_growth, limit)};
  }
  return std::nullopt;
}

std::vector<ClosureReport> LoopCloser::close_by_histogram(const HistogramMethod& method, int recent,
                                                          SharedGraph& graph,
                                                          const ContourSource& contours) {
  std::optional<ClosureReport> best;
  const Facing* facing = nullptr;
  for (int earlier = kHalf; earlier < recent - 2 * kHalf &&
                            places_[recent].path_m - places_[earlier].path_m >= options_.min_path_m;
       ++earlier) {
    for (const Facing& tried : facings_) {
      const Heading heading = heading_of(tried.turn_rad);
      if (heading == Heading::kOther || places_[earlier].place.featureless() ||
          emd_grey(places_[earlier].place.signature, places_[recent].place.signature, tried) >=
              method.threshold_grey) {
        continue;
      }
      const ClosureReport report = report_of(recent, earlier, tried);
      if (!best || report.diagonal_max_grey < best->diagonal_max_grey) {
        best = report;
        facing = &tried;
      }
    }
  }
  if (!best || !spaced(recent, best->heading)) {
    return {};  // the other diagonal, less alike, would say of the same place that it is turned
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
  anywhere.T_a_b = {0, 0, facing->turn_rad};
  anywhere.covariance = Vec3(0.09, 0.09, square(0.2)).asDiagonal();
  const PlaceFeatures& features_earlier = places_[report.earlier].place.features;
  const PlaceFeatures& features_recent = places_[recent].place.features;
  const LoopCameras cameras_earlier = cameras_at(report.earlier, graph);
  const LoopCameras cameras_recent = cameras_at(recent, graph);
  const PlaceDepths unknown;
  Rng rng = rng_.fork(std::to_string(recent) + "-" + std::to_string(report.earlier));
  const std::optional<PlanarMotion> motion = motion_by_features(
      options_.motion, {cameras_earlier, features_earlier, unknown},
      {cameras_recent, features_recent, unknown},
      match_places(options_.features, features_earlier, features_recent, *facing), anywhere, &rng);
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
  graph.edges.push_back(closure_edge(report));
  relax(graph);
  return {report};
}

}  // namespace panoptes
