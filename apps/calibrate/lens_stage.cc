// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/lens_stage.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/board_picture.h"
#include "apps/calibrate/camera_pictures.h"
#include "apps/calibrate/lens_by_boards.h"
#include "apps/command/out_dir.h"
#include "apps/draw/pictures.h"
#include "apps/process/fault.h"
#include "apps/process/process.h"
#include "apps/process/progress.h"
#include "apps/process/stage_clock.h"
#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/camera/lens_parameters.h"
#include "core/io/csv.h"
#include "core/io/file.h"
#include "core/io/picture.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// The part of a rig file that boards tell of one camera.
struct CalibratedLens {
  Intrinsics intrinsics;
  double focal_ratio = 0;
  double centre_px = 0;
};

void bind(Fields& f, CalibratedLens& o) {
  bind(f, o.intrinsics);
  std::map<std::string, double> sigma{{"focal_ratio", o.focal_ratio}, {"centre_px", o.centre_px}};
  f("sigma", sigma);
}

struct CalibratedLenses {
  std::map<std::string, CalibratedLens> cameras;
};

void bind(Fields& f, CalibratedLenses& o) { f("cameras", o.cameras); }

CalibratedLens calibrated(const LensFit& fit) {
  const Eigen::VectorXd sigma = fit.covariance.diagonal().cwiseSqrt();
  return {fit.lens, std::max(sigma[0] / fit.lens.fx_px, sigma[1] / fit.lens.fy_px),
          std::max(sigma[2], sigma[3])};
}

// What keeps a rig's camera from taking the lens that its pictures tell; empty where nothing does.
std::string rig_fault(const Rig& rig, const CameraPictures& pictures) {
  const auto found = rig.cameras.find(pictures.camera);
  if (found == rig.cameras.end()) {
    return fmt::format(
        "has no camera {}, of which there are pictures; name the folder of the pictures as the rig "
        "file names the camera",
        pictures.camera);
  }
  const RigCamera& camera = found->second;
  const auto size = picture_size(read_file(pictures.files.front()));
  if (size && (size->width_px != camera.intrinsics.width_px ||
               size->height_px != camera.intrinsics.height_px)) {
    return fmt::format("says that {} has pictures of {} x {} pixels, and {} has {} x {}",
                       pictures.camera, camera.intrinsics.width_px, camera.intrinsics.height_px,
                       pictures.files.front(), size->width_px, size->height_px);
  }
  if (camera.floor && camera.floor->H_body_px) {
    return fmt::format(
        "has a floor homography for {}, which goes with the lens as it was; give marks in its "
        "place",
        pictures.camera);
  }
  return {};
}

// Refused before anything is looked at: a rig that cannot take the lenses.
std::optional<Rig> rig_of(const LensStage& args, const std::vector<CameraPictures>& cameras) {
  const std::optional<Rig> rig =
      args.rig.empty() ? rig_beside(args.pictures) : read_settings<Rig>(args.rig);
  const std::string file =
      args.rig.empty() ? (fs::path(args.pictures) / "rig.yaml").string() : args.rig;
  std::vector<std::string> faults;
  for (const CameraPictures& camera : cameras) {
    const std::string fault = rig ? rig_fault(*rig, camera) : "";
    if (!fault.empty()) {
      faults.push_back(file + ": " + fault);
    }
  }
  if (!faults.empty()) {
    throw ConfigError(faults);
  }
  return rig;
}

Json figures_of(const LensByBoards& told) {
  const LensFit& fit = told.fit;
  Json figures{{"verdict", name(fit.verdict)},
               {"warnings", fit.reasons},
               {"boards",
                {{"given", told.pictures},
                 {"pictures", told.looked_at.size()},
                 {"found", told.corners.size()},
                 {"copies", fit.copies()},
                 {"used", fit.used()}}},
               {"picture_use", fit.picture_use}};
  if (fit.verdict == Verdict::kFailed) {
    return figures;
  }
  const Eigen::VectorXd numbers = lens_parameters(fit.lens);
  const Eigen::VectorXd sigma = fit.covariance.diagonal().cwiseSqrt();
  const std::vector<std::string> names = lens_parameter_names(fit.lens);
  Json lens{{"model", std::visit([](const auto& o) { return o.kName; }, fit.lens.distortion)},
            {"size_px", {fit.lens.width_px, fit.lens.height_px}}};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    lens[names[i]] = numbers[at];
    lens[names[i] + "_sigma"] = sigma[at];
  }
  Json covariance = Json::array();
  for (Eigen::Index row = 0; row < fit.covariance.rows(); ++row) {
    const Eigen::VectorXd of_row = fit.covariance.row(row);
    covariance.push_back(std::vector<double>(of_row.begin(), of_row.end()));
  }
  lens["order"] = names;
  lens["covariance"] = covariance;
  figures["intrinsics"] = lens;
  figures["reprojection_rms_px"] = fit.reprojection_rms_px;
  figures["corner_noise_px"] = fit.noise_px;
  figures["board_shape"] = {{"stretch", fit.shape.stretch},
                            {"stretch_sigma", fit.shape_sigma.stretch},
                            {"skew_rad", fit.shape.skew_rad},
                            {"skew_rad_sigma", fit.shape_sigma.skew_rad},
                            {"bow_rows_m", fit.shape.bow_rows_m},
                            {"bow_rows_m_sigma", fit.shape_sigma.bow_rows_m},
                            {"bow_columns_m", fit.shape.bow_columns_m},
                            {"bow_columns_m_sigma", fit.shape_sigma.bow_columns_m},
                            {"twist_m", fit.shape.twist_m},
                            {"twist_m_sigma", fit.shape_sigma.twist_m},
                            {"corner_spread_m", fit.corner_spread_m}};
  figures["field_sigma_px"] = {{"rms", fit.field_sigma_rms_px}, {"max", fit.field_sigma_most_px}};
  return figures;
}

void write_table(const fs::path& path, const std::vector<LensByBoards>& all) {
  CsvWriter table(path, {"camera", "picture", "board", "rms_px"});
  for (const LensByBoards& told : all) {
    std::size_t next = 0;
    for (std::size_t i = 0; i < told.looked_at.size(); ++i) {
      table << as_utf8(told.camera) << as_utf8(fs::path(told.looked_at[i]).filename().string());
      if (next >= told.with_board.size() || told.with_board[next] != i) {
        table << "not seen";
        table.skip().end_row();
        continue;
      }
      const FittedView& view = told.fit.views[next++];
      if (view.used) {
        table << "used" << view.rms_px;
        table.end_row();
      } else {
        table << (view.copy ? "copy" : "left out");
        table.skip().end_row();
      }
    }
  }
  table.finish();
}

void say(const LensByBoards& told) {
  const LensFit& fit = told.fit;
  std::printf("%s: %s; the board in %zu of %zu pictures", told.camera.c_str(),
              std::string(name(fit.verdict)).c_str(), told.corners.size(), told.looked_at.size());
  if (told.looked_at.size() < told.pictures) {
    std::printf(" (of the %zu there are, evenly)", told.pictures);
  }
  if (fit.copies() > 0) {
    std::printf(", %d of them copied", fit.copies());
  }
  std::printf(", %d used", fit.used());
  if (fit.verdict != Verdict::kFailed) {
    const CalibratedLens lens = calibrated(fit);
    std::printf(
        "; %s, f %.2f %.2f px to %.3f %%, centre %.2f %.2f px to %.2f px, corners to %.3f px",
        std::string(std::visit([](const auto& o) { return o.kName; }, fit.lens.distortion)).c_str(),
        fit.lens.fx_px, fit.lens.fy_px, 100 * lens.focal_ratio, fit.lens.cx_px, fit.lens.cy_px,
        lens.centre_px, fit.noise_px);
    std::printf(
        "; the board's rows stretched by %.2f %%, bowed by %.2f mm, columns bowed by %.2f mm, "
        "corners off that by %.2f mm",
        100 * fit.shape.stretch, 1000 * fit.shape.bow_rows_m, 1000 * fit.shape.bow_columns_m,
        1000 * fit.corner_spread_m);
  }
  std::printf("\n");
  for (const std::string& reason : fit.reasons) {
    std::printf("  %s\n", reason.c_str());
  }
}

// The rig with these lenses, to be used as it is; without a rig the part of one that is known.
fs::path write_lenses(const fs::path& folder, std::optional<Rig> rig,
                      const std::vector<LensByBoards>& all) {
  CalibratedLenses lenses;
  for (const LensByBoards& told : all) {
    if (told.fit.verdict == Verdict::kFailed) {
      continue;
    }
    const CalibratedLens lens = calibrated(told.fit);
    lenses.cameras[told.camera] = lens;
    if (rig) {
      rig->covariance.reset();  // it was of other lenses
      RigCamera& camera = rig->cameras.at(told.camera);
      camera.intrinsics = lens.intrinsics;
      camera.sigma.focal_ratio = lens.focal_ratio;
      camera.sigma.centre_px = lens.centre_px;
    }
  }
  if (lenses.cameras.empty()) {
    return {};
  }
  const fs::path file = folder / (rig ? "rig_calibrated.yaml" : "lenses.yaml");
  write_file(file, rig ? write_settings(*rig) : write_settings(lenses));
  return file;
}

Verdict worst(const std::vector<LensByBoards>& all) {
  Verdict verdict = Verdict::kGood;
  for (const LensByBoards& told : all) {
    verdict = std::max(verdict, told.fit.verdict);
  }
  return verdict;
}

std::optional<LensModel> model_of(const std::string& word) {
  return word == "brown_conrady" ? std::optional(LensModel::kBrownConrady)
         : word == "equidistant" ? std::optional(LensModel::kEquidistant)
                                 : std::nullopt;
}

}  // namespace

int calibrate_lenses(const LensStage& args) {
  LensByBoardsOptions options;
  const std::optional<Board> board = parse_board(args.board);
  if (!board) {
    throw ConfigError(fmt::format(
        "--board {}: must be COLUMNSxROWSxSQUARE, as 9x6x0.025: {} to {} inner corners each way, "
        "and the side of a square in metres, at most {:g} (25 mm are 0.025)",
        args.board, Board::kFewestCorners, Board::kMostCorners, Board::kLargestSquare_m));
  }
  options.board = *board;
  options.model = model_of(args.lens);
  options.num_threads = args.threads.value_or(
      std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 16));
  const std::vector<CameraPictures> cameras = camera_pictures(args.pictures);
  const std::optional<Rig> rig = rig_of(args, cameras);
  OutDir out(args.out);
  std::vector<LensByBoards> all;
  {
    ProgressLine line(args.quiet);
    for (const CameraPictures& camera : cameras) {
      all.push_back(lens_by_boards(options, camera, [&](double done) {
        if (line.due()) {
          const double share =
              (static_cast<double>(all.size()) + done) / static_cast<double>(cameras.size());
          line.show(share_line("boards of " + camera.camera, share, line.wall_s()));
        }
      }));
    }
  }
  const Verdict verdict = worst(all);
  const ProcessUse use = process_use();
  Json figures{
      {"schema", "panoptes.metrics/1"},
      {"command", "calibrate"},
      {"version", PANOPTES_VERSION},
      {"outcome", verdict == Verdict::kFailed ? "failed" : "completed"},
      {"board",
       {{"columns", board->columns}, {"rows", board->rows}, {"square_m", board->square_m}}},
      {"verdict", name(verdict)}};
  for (const LensByBoards& told : all) {
    figures["cameras"][as_utf8(told.camera)] = figures_of(told);
  }
  figures["wall_s"] = use.wall_s;
  figures["cpu_s"] = use.cpu_s;
  figures["peak_memory_mb"] = use.peak_memory_mb;
  out.keep();
  Faults faults;
  fs::path lenses;
  faults.attempt([&] { lenses = write_lenses(out.path(), rig, all); });
  faults.attempt([&] { write_table(out.path() / "boards.csv", all); });
  for (const LensByBoards& told : all) {
    faults.attempt([&] {
      write_file(out.path() / ("boards_" + told.camera + ".png"), png(draw_boards(told, *board)));
    });
  }
  if (!faults.none()) {
    figures["outcome"] = "failed";
    figures["fault"] = as_utf8(faults.text());
  }
  faults.attempt([&] { write_file(out.path() / "metrics.json", figures.dump(2) + "\n"); });
  for (const LensByBoards& told : all) {
    say(told);
  }
  if (!lenses.empty()) {
    std::printf("%s\n", lenses.c_str());
  }
  return !faults.none() ? faults.status() : verdict == Verdict::kFailed ? 1 : 0;
}

}  // namespace panoptes
