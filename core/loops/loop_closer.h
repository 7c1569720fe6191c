// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/base/rng.h"
#include "core/config/fields.h"
#include "core/graph/shared_graph.h"
#include "core/loops/closure.h"
#include "core/map/contours.h"
#include "core/motion/relative_motion.h"
#include "core/motion/rig_correction.h"
#include "core/vision/local_features.h"
#include "core/vision/place_signature.h"
#include "core/vision/word_index.h"

namespace panoptes {

/// The thesis's own rule (6.3.2): all seven elements of one diagonal of the 7x7 matrix of signature
/// distances lie below a threshold. Blind to look-alike places: kept for comparison.
struct HistogramMethod {
  static constexpr std::string_view kName = "histogram";
  double threshold_grey = 1.5;  ///< for signatures of the mosaic
};
void bind(Fields& f, HistogramMethod& o);

/// A chain of checks, each cheaper than the next and each able to refuse: signature and diagonals
/// (thresholds learned from the run), where the graph expects the place, matched features and their
/// geometry, contours, and the whole graph's agreement after relaxing.
struct VerifiedMethod {
  static constexpr std::string_view kName = "verified";
  double tolerance_m = 0.5;     ///< how far apart two keyframes of one place may be, three sigma on
  double tolerance_rad = 0.44;  ///< and how much turned: two thirds of an 80 degree picture remain
  double nearby_quantile = 0.95;  ///< of the signature distances of neighbours, farther than which
                                  ///< no place is: of true ones one in twenty
  int rows_needed =
      4;  ///< of seven, near the diagonal: two paths may share but part of seven keyframes
  double prior_floor_m = 0.1;     ///< the graph is never trusted more than this when searching: ten
  double prior_floor_rad = 0.03;  ///< times min_sigma, the surest closure
  double gate_probability =
      0.9973;  ///< of three sigma: what the graph expects, with this certainty
  double chi2_probability = 0.9973;  ///< by how much the relaxed graph's chi2 may grow, with this
  int verify_per_keyframe = 2;       ///< pairs whose features are matched: bounds the time
  int min_inliers = 30;
  double min_inlier_share = 0.4;  ///< of the matches
  double mounting_px = 3;  ///< two cameras that show the same may be mounted wrong by this much, a
                           ///< degree, in a second try
  double min_sigma_m = 0.01;     ///< lens, mounting and floor are not as ideal as the model: no
  double min_sigma_rad = 0.003;  ///< closure is taken for surer,
  double max_sigma_m = 0.15;     ///< and one less sure is not worth its risk
  double max_sigma_rad = 0.026;
  ContourOptions contours;
  double contour_overlap = 0.5;    ///< below it contours share too little to contradict anything,
  double contour_ambiguity = 0.8;  ///< above it they fit elsewhere as well
  double contour_apart_m = 0.1;    ///< blurred by what the floor colour smears: 5 cm a contour
  double contour_apart_rad = 0.07;
};
void bind(Fields& f, VerifiedMethod& o);

/// What picks, within what odometry allows, the few earlier places whose features are matched.
enum class Shortlist {
  kSignature,  ///< nearest signatures, none farther than neighbours are, nor on the diagonal
  kWords       ///< most words shared; signatures, which may differ where words are the same, refuse
               ///< nothing
};

struct LoopOptions {
  std::variant<VerifiedMethod, HistogramMethod> method;
  Shortlist shortlist = Shortlist::kSignature;
  double min_path_m = 5;  ///< driven since an earlier place before coming back counts
  double spacing_m = 1;  ///< driven between two accepted closures of one heading: one is enough for
                         ///< a revisit
  /// Of one level: those of coarser ones are found less precisely, and a place is met again from
  /// where things look as large as before.
  FeatureOptions features = {.levels = 1};
  MotionOptions motion;
};
void bind(Fields& f, LoopOptions& o);

/// One keyframe as loops see it. A camera that shows nothing, or nothing that was accepted, has no
/// features.
struct LoopPlace {
  PlaceSignature signature;
  PlaceFeatures features;
  PictureTimes taken = {};  ///< empty: all at once
  bool partial = false;     ///< a camera was lost: the signature is not whole

  /// Such a place is never closed, however alike another looks, and teaches nothing.
  bool featureless() const {
    return partial || std::all_of(features.begin(), features.end(),
                                  [](const LocalFeatures& one) { return one.px.empty(); });
  }
};

/// Contour points of the free space around a keyframe, in its frame, from the keyframes around it.
using ContourSource = std::function<std::vector<Vec2>(int keyframe)>;

/// The edge an accepted closure stands for.
SharedEdge closure_edge(const ClosureReport& closure);

/// The matrix of signature distances around a pair, [recent][earlier], and the largest on the
/// diagonal along which a robot going the same or the opposite way would meet the same places; of
/// one that crosses its path, the pair's own.
using DistanceMatrix = std::array<std::array<float, 7>, 7>;
double diagonal_max_grey(const DistanceMatrix& matrix, Heading heading);

/// Remembers every keyframe and says where the robot has come back.
class LoopCloser {
 public:
  LoopCloser(const LoopOptions& options, const LoopCameras& cameras, Rng rng);

  /// Takes the newest keyframe, which is the graph's last node.
  void add(LoopPlace place, const SharedGraph& graph);

  /// The first half of close(), which a caller with little time may have by itself: what pictures
  /// say of the keyframe that close() tries next. The graph stays as it is until then.
  void look(const SharedGraph& graph, const ContourSource& contours);

  /// Tries the keyframe three before the newest, so that each pair has seven keyframes on either
  /// side. Reports every pair that came as far as the diagonals; where one is accepted the graph
  /// has its `closure_edge`, and is relaxed.
  std::vector<ClosureReport> close(SharedGraph& graph, const ContourSource& contours);

  /// What a camera showed at keyframes before `keyframe` is not compared any more: it sits
  /// otherwise now.
  void forget(int camera, int keyframe);

  /// How far away things are that a keyframe shows, by those around it.
  const PlaceDepths& depths(int keyframe, const SharedGraph& graph);

  const LoopPlace& place(int keyframe) const {
    return places_.at(static_cast<std::size_t>(keyframe)).place;
  }

 private:
  struct Remembered {
    LoopPlace place;
    double path_m = 0;      ///< driven up to here
    PlaceDepths depths;     ///< by the neighbours known when last asked
    int depths_until = -1;  ///< the last keyframe they were seen from
  };
  struct Candidate {
    int earlier = 0;
    const Facing* facing = nullptr;
    double emd_grey = 0;
    double score = 0;
    MotionPrior prior;  ///< recent seen from earlier
  };

  int newest() const { return static_cast<int>(places_.size()) - 1; }
  ClosureReport report_of(int recent, int earlier, const Facing& facing) const;
  double nearby_threshold_grey(const VerifiedMethod& method) const;
  bool spaced(int recent, Heading heading) const;
  void accept(ClosureReport& report);
  LoopCameras cameras_at(int keyframe, const SharedGraph& graph) const;
  std::vector<Candidate> shortlist(const VerifiedMethod& method, int recent,
                                   const SharedGraph& graph,
                                   const SharedUncertainty& uncertainty) const;
  std::optional<int> to_try() const;
  void verify_next(const VerifiedMethod& method, const SharedGraph& graph,
                   const ContourSource& contours);
  std::vector<ClosureReport> close_by_histogram(const HistogramMethod& method, int recent,
                                                SharedGraph& graph, const ContourSource& contours);

  /// Why a pair is no closure.
  struct Refusal {
    std::string why;
  };
  struct CandidateCheck;  // of one pair: what the checks hand on to those after them
  std::optional<Refusal> verify(CandidateCheck& check);
  std::optional<Refusal> check_diagonals(const CandidateCheck& check) const;
  std::optional<Refusal> check_features(CandidateCheck& check);
  std::optional<Refusal> check_certainty(CandidateCheck& check);
  std::optional<Refusal> check_cameras(CandidateCheck& check);
  std::optional<Refusal> check_gate(const CandidateCheck& check) const;
  std::optional<Refusal> check_tolerance(const CandidateCheck& check) const;
  std::optional<Refusal> check_contours(const CandidateCheck& check) const;
  std::optional<Refusal> check_graph(const VerifiedMethod& method, const SharedGraph& graph,
                                     ClosureReport& report, SharedGraph& relaxed) const;

  /// Between look() and close().
  struct Search {
    explicit Search(SharedUncertainty of) : uncertainty(std::move(of)) {}

    SharedUncertainty uncertainty;
    std::vector<Candidate> candidates;
    std::size_t tried = 0;               ///< of the candidates
    std::vector<ClosureReport> reports;  ///< one for each that was tried
    bool agreed = false;                 ///< pictures agree on the last of them
  };

  LoopOptions options_;
  LoopCameras cameras_;  ///< as the rig file has them
  std::vector<Facing> facings_;
  Rng rng_;
  std::vector<Remembered> places_;
  std::optional<Search> search_;
  std::optional<WordIndex> words_;  ///< where they make the shortlist
  std::vector<float> nearby_emd_;   ///< between keyframes two apart, sorted
  std::array<double, 3> accepted_path_m_{
      -1e9, -1e9, -1e9};  ///< driven up to the last accepted closure of each heading
};

}  // namespace panoptes
