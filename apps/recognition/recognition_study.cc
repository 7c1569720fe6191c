// SPDX-License-Identifier: BSD-3-Clause
#include "apps/recognition/recognition_study.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/csv.h"

namespace panoptes {
namespace {

template <class Enum>
using Words = std::vector<std::pair<std::string, Enum>>;

const Words<HistogramKind> kHistograms{{"grey", HistogramKind::kGrey},
                                       {"colour", HistogramKind::kColour},
                                       {"gradient", HistogramKind::kGradient},
                                       {"two_dimensional", HistogramKind::kTwoDimensional}};
const Words<HistogramDistance> kDistances{{"emd", HistogramDistance::kEmd},
                                          {"chi_square", HistogramDistance::kChiSquare},
                                          {"intersection", HistogramDistance::kIntersection},
                                          {"l2", HistogramDistance::kL2}};
const Words<MosaicPictures> kPictures{{"front", MosaicPictures::kFront},
                                      {"front_back", MosaicPictures::kFrontBack},
                                      {"four_corners", MosaicPictures::kFourCorners}};

template <class Enum>
const std::string& name_of(const Words<Enum>& words, Enum meaning) {
  const auto found = std::find_if(words.begin(), words.end(),
                                  [&](const auto& word) { return word.second == meaning; });
  PANOPTES_CHECK(found != words.end(), "every choice has a name");
  return found->first;
}

// A list of some of the words, each at most once.
template <class Enum>
void bind_words(Fields& f, const std::string& key, const Words<Enum>& words,
                std::vector<Enum>& values) {
  std::vector<std::string> known;
  for (const auto& [name, meaning] : words) {
    known.push_back(name);
  }
  std::vector<std::string> names(values.size());
  std::transform(values.begin(), values.end(), names.begin(),
                 [&](Enum value) { return name_of(words, value); });
  f(key, names);
  f.require(!names.empty(), key, "must have at least one of " + joined(known));
  values.clear();
  for (const std::string& name : names) {
    const auto found = std::find(known.begin(), known.end(), name);
    const std::string near = nearest_word(name, known);
    f.require(found != known.end(), key,
              "must be some of " + joined(known) + ", got " + name +
                  (near.empty() ? "" : "; did you mean " + near + "?"));
    if (found == known.end()) {
      continue;
    }
    const Enum value = words[static_cast<std::size_t>(found - known.begin())].second;
    f.require(std::find(values.begin(), values.end(), value) == values.end(), key,
              "has " + name + " twice; leave one out");
    values.push_back(value);
  }
}

template <class Enum>
bool holds(const std::vector<Enum>& values, Enum value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}

std::vector<std::string> corner_cameras(const Rig& rig) {
  std::vector<std::string> names;
  for (const auto& [name, camera] : rig.cameras) {
    if (camera.has_role("corner")) {
      names.push_back(name);
    }
  }
  return names;
}

constexpr std::size_t kCorners = 4;

std::optional<double> share(int part, int of) {
  return of > 0 ? std::optional(static_cast<double>(part) / of) : std::nullopt;
}

const std::vector<std::string> kColumns{"histogram",     "distance",          "pictures",
                                        "recall",        "recall_same",       "recall_opposite",
                                        "recognised",    "keyframes",         "recalled_same",
                                        "revisits_same", "recalled_opposite", "revisits_opposite"};

int whole_number(const std::string& text, const std::filesystem::path& path) {
  const bool digits =
      !text.empty() && text.size() < 10 &&
      std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!digits) {
    throw IoError(path.string() + ": '" + text + "' is no number of keyframes or revisits");
  }
  return std::stoi(text);
}

}  // namespace

void bind(Fields& f, RecognitionStudyOptions& o) {
  bind_words(f, "histogram", kHistograms, o.histograms);
  bind_words(f, "distance", kDistances, o.distances);
  bind_words(f, "pictures", kPictures, o.pictures);
}

std::string pictures_fault(const RecognitionStudyOptions& options, const Rig& rig, bool recorded) {
  const bool only_corners =
      options.pictures == std::vector<MosaicPictures>{MosaicPictures::kFourCorners};
  if (!only_corners &&
      (rig.with_role("loop_front").empty() || rig.with_role("loop_back").empty())) {
    return "compares pictures ahead and back, and the rig has no camera with the role loop_front "
           "or "
           "none with loop_back; take another rig";
  }
  if (!holds(options.pictures, MosaicPictures::kFourCorners)) {
    return {};
  }
  if (recorded) {
    return "cannot have four_corners of a recording: its cameras take no picture when asked to; "
           "leave them out";
  }
  const std::vector<std::string> corners = corner_cameras(rig);
  if (corners.size() != kCorners) {
    return fmt::format(
        "four_corners needs four cameras with the role corner, and the rig has {}; take another "
        "one (--set rig=scenes/rigs/front-back-floor-corners.yaml, and platform.nominal_rig as "
        "well), or leave them out",
        corners.size());
  }
  for (const std::string& name : corners) {
    if (rig.cameras.at(name).rate_hz > 0) {
      return "four_corners asks the camera " + name +
             " for a picture at each keyframe alone; give it rate_hz: 0";
    }
  }
  return {};
}

std::optional<double> RecognitionRow::recall() const {
  return share(found.recognised, found.keyframes);
}

std::optional<double> RecognitionRow::recall_same() const {
  return share(found.recalled_same, found.revisits_same);
}

std::optional<double> RecognitionRow::recall_opposite() const {
  return share(found.recalled_opposite, found.revisits_opposite);
}

bool RecognitionRow::is_thesis() const {
  return histogram == "grey" && distance == "emd" && pictures == "front_back";
}

void write_recognition_rows(const std::filesystem::path& path,
                            const std::vector<RecognitionRow>& rows) {
  CsvWriter csv(path, kColumns);
  for (const RecognitionRow& row : rows) {
    csv << row.histogram << row.distance << row.pictures;
    for (const std::optional<double>& recall :
         {row.recall(), row.recall_same(), row.recall_opposite()}) {
      if (recall) {
        csv << *recall;
      } else {
        csv.skip();
      }
    }
    csv << row.found.recognised << row.found.keyframes << row.found.recalled_same
        << row.found.revisits_same << row.found.recalled_opposite << row.found.revisits_opposite;
    csv.end_row();
  }
  csv.finish();
}

std::vector<RecognitionRow> read_recognition_rows(const std::filesystem::path& path) {
  const CsvTable table = read_csv(path);
  std::vector<RecognitionRow> rows;
  for (const std::vector<std::string>& fields : table.rows) {
    const auto text = [&](const char* column) { return fields[table.column(column)]; };
    const auto number = [&](const char* column) { return whole_number(text(column), path); };
    rows.push_back(
        {text("histogram"),
         text("distance"),
         text("pictures"),
         {number("keyframes"), number("recognised"), number("revisits_same"),
          number("revisits_opposite"), number("recalled_same"), number("recalled_opposite")}});
  }
  return rows;
}

RecognitionStudy::RecognitionStudy(const RecognitionStudyOptions& options, const Rig& rig,
                                   Capture capture)
    : options_(options), rig_(rig), capture_(std::move(capture)) {
  for (const MosaicPictures pictures : options_.pictures) {
    for (const HistogramKind kind : options_.histograms) {
      series_.push_back({kind, pictures, {}});
    }
  }
}

void RecognitionStudy::add(const Observation& seen, const SlamStep& at, const PilotStep& /*step*/) {
  if (!at.keyframe_made) {
    return;
  }
  std::map<MosaicPictures, std::vector<cv::Mat>> taken;
  for (const MosaicPictures pictures : options_.pictures) {
    std::vector<cv::Mat>& mosaic = taken[pictures];
    if (pictures == MosaicPictures::kFourCorners) {
      for (const std::string& camera : corner_cameras(rig_)) {
        mosaic.push_back(capture_(camera).bgr);
      }
      continue;
    }
    mosaic.push_back(seen.pictures.at(rig_.with_role("loop_front")).bgr);
    if (pictures == MosaicPictures::kFrontBack) {
      mosaic.push_back(seen.pictures.at(rig_.with_role("loop_back")).bgr);
    }
  }
  for (Series& series : series_) {
    series.histograms.push_back(place_histogram(series.kind, taken.at(series.pictures)));
  }
}

std::vector<RecognitionRow> RecognitionStudy::rows(const std::vector<Pose2>& true_T_scene_body,
                                                   const std::vector<double>& path_m) const {
  std::vector<RecognitionRow> rows;
  for (const Series& series : series_) {
    for (const HistogramDistance distance : options_.distances) {
      const DistanceTable distances(static_cast<int>(series.histograms.size()), [&](int i, int j) {
        return histogram_distance(distance, series.histograms[static_cast<std::size_t>(i)],
                                  series.histograms[static_cast<std::size_t>(j)]);
      });
      const bool all_round = series.pictures != MosaicPictures::kFront;
      rows.push_back({name_of(kHistograms, series.kind), name_of(kDistances, distance),
                      name_of(kPictures, series.pictures),
                      recall_at_full_precision(place_candidates(distances, all_round, path_m),
                                               true_T_scene_body, path_m)});
    }
  }
  return rows;
}

}  // namespace panoptes
