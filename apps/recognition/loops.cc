// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>

#include "apps/command/command.h"
#include "apps/command/out_dir.h"
#include "apps/draw/pictures.h"
#include "apps/process/fault.h"
#include "apps/process/progress.h"
#include "apps/process/stage_clock.h"
#include "apps/recognition/recognition_picture.h"
#include "apps/recognition/recognition_truth.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/utf8.h"
#include "core/eval/places.h"
#include "core/eval/recognition.h"
#include "core/io/csv.h"
#include "core/io/file.h"
#include "core/io/picture.h"
#include "core/vision/run_recognition.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kLeastSide_px = 48;  // of which the descriptors of features leave some points

struct LoopsArguments {
  std::vector<std::string> pictures;
  std::string truth;
  std::string out;
  bool quiet = false;
};

// In the order in which they were taken, as far as their names tell.
std::vector<std::string> listed(const std::vector<std::string>& given) {
  std::vector<std::string> files;
  for (const std::string& name : given) {
    if (!fs::is_directory(name)) {
      if (!fs::exists(name)) {
        throw ConfigError(name + ": no such picture or folder");
      }
      files.push_back(name);
      continue;
    }
    const std::vector<std::string> of_folder = pictures_in(name);
    files.insert(files.end(), of_folder.begin(), of_folder.end());
    if (of_folder.empty()) {
      throw ConfigError(name + ": holds no pictures; name a folder of PNG or JPEG files");
    }
  }
  std::sort(files.begin(), files.end(), natural_less);
  if (files.size() < 2) {
    throw ConfigError(files.front() +
                      ": is one picture; give all that the camera took, two at the least");
  }
  return files;
}

struct Seen {
  std::vector<PlaceView> views;
  std::vector<PlaceSignature> mosaics;  ///< the thesis's own, to compare with
};

Seen look_at(const std::vector<std::string>& files, const RecogniserOptions& options,
             ProgressLine& line, StageClock& clock) {
  SignatureOptions mosaic;
  mosaic.method = SignatureMethod::kMosaic;
  Seen seen;
  std::vector<std::string> faults;
  cv::Size first;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (line.due()) {
      line.show(share_line("pictures", static_cast<double>(i) / files.size(), line.wall_s()));
    }
    cv::Mat grey;
    try {
      grey = decode_picture(read_file(files[i]), kMostPictureSide_px, PictureColours::kGrey);
      if (std::min(grey.cols, grey.rows) < kLeastSide_px) {
        throw ConfigError(fmt::format("is {} x {} pixels; {} are needed either way", grey.cols,
                                      grey.rows, kLeastSide_px));
      }
      if (first.empty()) {
        first = grey.size();
      } else if (grey.size() != first) {
        throw ConfigError(fmt::format(
            "is {} x {} pixels and others are {} x {}; give pictures of one camera and one size",
            grey.cols, grey.rows, first.width, first.height));
      }
    } catch (const ConfigError& error) {
      const std::string what = error.what();
      faults.push_back(what.starts_with(files[i]) ? what : files[i] + ": " + what);
      continue;
    }
    const TimedStage timed(clock, "view");
    seen.views.push_back(place_view(options, grey));
    seen.mosaics.push_back(place_signature(mosaic, {grey}));
  }
  if (!faults.empty()) {
    throw ConfigError(faults);
  }
  return seen;
}

// The signatures alone: the place whose diagonal is nearest.
std::vector<PlaceAnswer> by_signature(const std::vector<PlaceSignature>& signatures, int horizon,
                                      int around) {
  const int count = static_cast<int>(signatures.size());
  const DistanceTable distances(
      count, [&](int i, int j) { return emd_grey(signatures[i], signatures[j]); });
  std::vector<int> until(signatures.size());
  std::iota(until.begin(), until.end(), -horizon);
  std::vector<PlaceAnswer> answers(signatures.size());
  for (const DiagonalCandidate& found : diagonal_candidates(distances, around, false, until)) {
    answers[found.recent] = {found.earlier, -found.distance, false};
  }
  return answers;
}

Json truth_figures(const RunRecognition& run, const Seen& seen, const PlaceTruth& truth) {
  std::vector<PlaceAnswer> answers;
  for (const Recognised& recognised : run.pictures) {
    answers.push_back({recognised.earlier, recognised.confidence, recognised.accepted});
  }
  std::vector<PlaceSignature> grids;
  for (const PlaceView& view : seen.views) {
    grids.push_back(view.signature);
  }
  const RecognitionFigures figures = recognition_figures(answers, truth);
  const auto alone = [&](const std::vector<PlaceSignature>& signatures, int around) {
    return recognition_figures(by_signature(signatures, run.horizon, around), truth)
        .recall_at_full_precision;
  };
  return {{"revisits", figures.revisits},
          {"right", figures.right},
          {"wrong", figures.wrong},
          {"not_counted", figures.not_counted},
          {"precision", figures.precision},
          {"recall", figures.recall},
          {"recall_at_full_precision",
           {{"features", figures.recall_at_full_precision},
            {"grid_signature", alone(grids, 0)},
            {"histogram_diagonals", alone(seen.mosaics, kThesisAround)}}}};
}

const char* fault_name(PictureFault fault) {
  switch (fault) {
    case PictureFault::kNone:
      break;
    case PictureFault::kBlank:
      return "blank";
    case PictureFault::kDark:
      return "dark";
    case PictureFault::kOverExposed:
      return "over-exposed";
    case PictureFault::kBlurred:
      return "blurred";
  }
  return "";
}

// How many pictures show nothing, of each kind.
Json showing_nothing(const RunRecognition& run) {
  Json counts;
  for (const PictureFault fault : {PictureFault::kBlank, PictureFault::kDark,
                                   PictureFault::kOverExposed, PictureFault::kBlurred}) {
    counts[fault_name(fault)] =
        std::count_if(run.pictures.begin(), run.pictures.end(),
                      [fault](const Recognised& one) { return one.fault == fault; });
  }
  return counts;
}

void say_what_shows_nothing(const std::vector<std::string>& files, const RunRecognition& run) {
  constexpr int kNamed = 5;
  int count = 0;
  std::string named;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (run.pictures[i].fault != PictureFault::kNone && count++ < kNamed) {
      named +=
          fmt::format("{}{} ({})", named.empty() ? "" : ", ",
                      fs::path(files[i]).filename().string(), fault_name(run.pictures[i].fault));
    }
  }
  if (count > 0) {
    std::fprintf(stderr, "%d of %zu pictures show nothing and are left out: %s%s\n", count,
                 files.size(), named.c_str(),
                 count > kNamed ? fmt::format(" and {} more", count - kNamed).c_str() : "");
  }
}

void write_table(const fs::path& path, const std::vector<std::string>& files,
                 const RunRecognition& run, const std::optional<PlaceTruth>& truth) {
  CsvWriter table(path, {"picture", "earlier", "emd_grey", "inliers", "support", "seen_again",
                         "confidence", "verdict", "truth"});
  for (std::size_t i = 0; i < files.size(); ++i) {
    const Recognised& found = run.pictures[i];
    table << as_utf8(fs::path(files[i]).filename().string());
    if (found.earlier < 0) {
      table.skip().skip().skip().skip().skip().skip()
          << (found.fault == PictureFault::kNone
                  ? "nothing alike"
                  : fmt::format("shows nothing: {}", fault_name(found.fault)));
      table.skip().end_row();
      continue;
    }
    table << as_utf8(fs::path(files[found.earlier]).filename().string()) << found.emd_grey
          << found.inliers << found.support << found.seen_again << found.confidence
          << (found.accepted ? "same place" : "too little in common");
    if (truth) {
      const SamePlace same = truth->at(static_cast<int>(i), found.earlier);
      table << (same == SamePlace::kYes  ? "same place"
                : same == SamePlace::kNo ? "another place"
                                         : "not counted");
    } else {
      table.skip();
    }
    table.end_row();
  }
  table.finish();
}

cv::Mat drawn(const Seen& seen, const RunRecognition& run, const std::optional<PlaceTruth>& truth,
              const std::string& title) {
  const int count = static_cast<int>(seen.views.size());
  RecognitionPicture picture{cv::Mat::zeros(count, count, CV_32F), {}, title};
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < i; ++j) {
      picture.distance.at<float>(i, j) =
          static_cast<float>(emd_grey(seen.views[i].signature, seen.views[j].signature));
    }
    const Recognised& found = run.pictures[i];
    if (found.accepted) {
      picture.found.push_back({i, found.earlier, std::nullopt});
      if (truth && truth->at(i, found.earlier) != SamePlace::kNotCounted) {
        picture.found.back().right = truth->at(i, found.earlier) == SamePlace::kYes;
      }
    }
  }
  return draw_recognition(picture);
}

// Finds where the camera has come back, from its pictures alone.
int find_loops(const LoopsArguments& args) {
  const std::vector<std::string> files = listed(args.pictures);
  std::optional<PlaceTruth> truth;
  if (!args.truth.empty()) {
    truth = read_recognition_truth(args.truth, files);
  }
  OutDir out(args.out);
  ProgressLine line(args.quiet);
  StageClock clock;
  const RecogniserOptions options;
  const Seen seen = look_at(files, options, line, clock);
  const double from_s = process_use().cpu_s;
  const RunRecognition run = recognise_run(options, seen.views, Rng(0), [&line](double done) {
    if (line.due()) {
      line.show(share_line("places", done, line.wall_s()));
    }
  });
  const double query_s = process_use().cpu_s - from_s;
  const auto found = std::count_if(run.pictures.begin(), run.pictures.end(),
                                   [](const Recognised& one) { return one.accepted; });
  const ProcessUse use = process_use();
  const auto count = static_cast<double>(files.size());
  clock.end_frame();
  Json figures{{"schema", "panoptes.metrics/1"},  {"command", "loops"},
               {"version", PANOPTES_VERSION},     {"outcome", "completed"},
               {"pictures", files.size()},        {"recognised", found},
               {"horizon_pictures", run.horizon}, {"showing_nothing", showing_nothing(run)}};
  if (run.learned()) {
    figures["threshold_inliers"] = run.threshold;
    figures["threshold_with_support"] = run.threshold_support;
  }
  if (truth) {
    figures["truth"] = truth_figures(run, seen, *truth);
  }
  figures["timing_cpu_ms"] = {{"view", clock.figures().at("view").cpu_mean_ms / count},
                              {"query", 1e3 * query_s / count}};
  figures["wall_s"] = use.wall_s;
  figures["cpu_s"] = use.cpu_s;
  figures["peak_memory_mb"] = use.peak_memory_mb;
  std::string title = fmt::format("{} of {} pictures show places seen before", found, files.size());
  if (truth) {
    const Json& judged = figures["truth"];
    title += fmt::format("; precision {:.3f}, recall {:.3f} ({:.3f} without a false one)",
                         judged["precision"].get<double>(), judged["recall"].get<double>(),
                         judged["recall_at_full_precision"]["features"].get<double>());
  }
  out.keep();
  Faults faults;
  faults.attempt([&] { write_table(out.path() / "loops.csv", files, run, truth); });
  faults.attempt(
      [&] { write_file(out.path() / "loops.png", png(drawn(seen, run, truth, title))); });
  if (!faults.none()) {
    figures["outcome"] = "failed";
    figures["fault"] = as_utf8(faults.text());
  }
  faults.attempt([&] { write_file(out.path() / "metrics.json", figures.dump(2) + "\n"); });
  std::printf("%s\n%s\n", title.c_str(), (out.path() / "loops.csv").c_str());
  say_what_shows_nothing(files, run);
  if (!run.learned()) {
    const auto full =
        std::count_if(run.pictures.begin(), run.pictures.end(),
                      [](const Recognised& one) { return one.fault == PictureFault::kNone; });
    std::fprintf(stderr, "%td pictures are too few to learn from what another place looks like\n",
                 full);
  }
  return faults.status();
}

}  // namespace

void add_loops(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<LoopsArguments>();
  CLI::App* sub =
      app.add_subcommand("loops", "Which pictures of a camera show a place it has seen before?");
  sub->add_option(
         "PICTURES", args->pictures,
         "a folder of one camera's pictures, or the pictures; in the order of their names, "
         "10 after 9")
      ->required()
      ->type_name("FOLDER|FILE");
  sub->add_option("--truth", args->truth,
                  "which truly show one place: a table of picture,earlier (names, or numbers from "
                  "0), or a picture with a white pixel for each pair, grey where it does not count")
      ->type_name("FILE");
  sub->add_option("--out", args->out, "where loops.csv, loops.png and metrics.json go")
      ->required()
      ->type_name("DIR");
  sub->add_flag("--quiet", args->quiet, "no progress");
  sub->footer("Example: panoptes loops pictures/ --truth pairs.csv --out runs/corridor-loops");
  sub->callback([args, &chosen] { chosen = [args] { return find_loops(*args); }; });
}

}  // namespace panoptes
