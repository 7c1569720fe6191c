// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/step/step_listener.h"
#include "core/camera/observation.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/eval/places.h"
#include "core/vision/place_histogram.h"

namespace panoptes {

/// Which pictures of a keyframe make up the mosaic that a histogram is taken of.
enum class MosaicPictures {
  kFront,
  kFrontBack,    ///< the thesis's (6.3.2)
  kFourCorners,  ///< of the four cameras with the role `corner`, which it tried before (6.3.1)
};

/// The comparison behind thesis 6.3.2: every histogram with every distance on all the pictures, all
/// of them on the keyframes of the same drive.
struct RecognitionStudyOptions {
  std::vector<HistogramKind> histograms{HistogramKind::kGrey};
  std::vector<HistogramDistance> distances{HistogramDistance::kEmd};
  std::vector<MosaicPictures> pictures{MosaicPictures::kFrontBack};
};
void bind(Fields& f, RecognitionStudyOptions& o);

/// Why these cameras cannot take the pictures asked for; empty when they can.
std::string pictures_fault(const RecognitionStudyOptions& options, const Rig& rig, bool recorded);

/// One method to tell places apart, and what it found.
struct RecognitionRow {
  std::string histogram;
  std::string distance;
  std::string pictures;
  PlaceRecall found;

  std::optional<double> recall() const;  ///< of keyframes on a revisit; empty where there is none
  std::optional<double> recall_same() const;  ///< of revisits
  std::optional<double> recall_opposite() const;
  bool is_thesis() const;  ///< the one it found best
};

/// `histogram,distance,pictures`, the three recalls and what they are made of, a row each.
void write_recognition_rows(const std::filesystem::path& path,
                            const std::vector<RecognitionRow>& rows);
std::vector<RecognitionRow> read_recognition_rows(const std::filesystem::path& path);

/// A picture of the last frame set's instant by a camera that takes one only when it is asked to.
using Capture = std::function<Picture(const std::string& camera)>;

/// Takes the histograms of each keyframe's pictures, and compares them when the run is over.
class RecognitionStudy : public StepListener {
 public:
  /// `capture` may be empty where no camera needs to be asked.
  RecognitionStudy(const RecognitionStudyOptions& options, const Rig& rig, Capture capture);

  /// Takes part in steps that make a keyframe of their frame set.
  void add(const Observation& seen, const SlamStep& at, const PilotStep& step) override;

  /// A row for each combination. `path_m`: the true path length up to each keyframe.
  std::vector<RecognitionRow> rows(const std::vector<Pose2>& true_T_scene_body,
                                   const std::vector<double>& path_m) const;

 private:
  struct Series {  // of one histogram on some pictures, a keyframe after the other
    HistogramKind kind;
    MosaicPictures pictures;
    std::vector<PlaceHistogram> histograms;
  };

  RecognitionStudyOptions options_;
  Rig rig_;
  Capture capture_;
  std::vector<Series> series_;
};

}  // namespace panoptes
