// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/study_pictures.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "apps/draw/bands.h"
#include "apps/draw/pictures.h"
#include "apps/draw/scatter.h"
#include "core/base/text.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

std::string title_of(const Study& study) {
  return std::filesystem::path(study.file).stem().string();
}

template <class Entry>
std::vector<std::string> names_of(const std::vector<Entry>& entries) {
  std::vector<std::string> names;
  for (const Entry& entry : entries) {
    names.push_back(entry.name);
  }
  return names;
}

std::string words_of(const std::string& mission, const std::string& other, const Study& study) {
  return study.missions.size() > 1 ? mission + ", " + other : other;
}

Bands bands_of(const Study& study, const StudyRanking& ranking) {
  const bool over_rungs = study.rungs.size() > study.rigs.size();
  Bands bands;
  bands.title = title_of(study);
  bands.steps = over_rungs ? names_of(study.rungs) : names_of(study.rigs);
  const std::vector<std::string> lines = over_rungs ? names_of(study.rigs) : names_of(study.rungs);
  const std::vector<StudyCell> cells = cells_of(study);
  for (std::size_t k = 0; k < ranking.scores.size(); ++k) {
    for (const StudyMission& mission : study.missions) {
      BandPanel panel;
      panel.label = words_of(mission.name, ranking.scores[k].figure(), study);
      for (const std::string& line : lines) {
        BandCurve curve{line, {}};
        curve.points.resize(bands.steps.size());
        for (std::size_t i = 0; i < cells.size(); ++i) {
          const StudyCell& cell = cells[i];
          const auto& standing = ranking.standings[i][k];
          if (cell.mission != mission.name || (over_rungs ? cell.rig : cell.rung) != line ||
              !standing) {
            continue;
          }
          const auto step =
              std::find(bands.steps.begin(), bands.steps.end(), over_rungs ? cell.rung : cell.rig);
          curve.points[static_cast<std::size_t>(step - bands.steps.begin())] =
              BandPoint{standing->mean.mean, standing->mean.low, standing->mean.high};
        }
        panel.curves.push_back(std::move(curve));
      }
      bands.panels.push_back(std::move(panel));
    }
  }
  return bands;
}

Scatter pareto_of(const Study& study, const StudyRanking& ranking) {
  constexpr Colour kOther{120, 126, 134};
  const auto axis = [&](std::size_t k) {
    return ScatterAxis{ranking.scores[k].figure(), !ranking.scores[k].less_is_better()};
  };
  Scatter scatter{title_of(study), axis(1), axis(0), {}};
  ScatterLayer others{"others", kOther, 4, {}, false};
  ScatterLayer pareto{study.missions.size() * study.rungs.size() > 1
                          ? "Pareto set of its mission and rung"
                          : "Pareto set",
                      kWrongColour,
                      5,
                      {},
                      false};
  const std::vector<StudyCell> cells = cells_of(study);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto& x = ranking.standings[i][1];
    const auto& y = ranking.standings[i][0];
    if (!x || !y) {
      continue;
    }
    std::string name = cells[i].rig;
    name += study.rungs.size() > 1 ? ", " + cells[i].rung : "";
    name += study.missions.size() > 1 ? ", " + cells[i].mission : "";
    (ranking.pareto[i] ? pareto : others)
        .points.push_back({{x->mean.mean, y->mean.mean},
                           {x->mean.high - x->mean.mean, y->mean.high - y->mean.mean},
                           name});
  }
  scatter.layers = {std::move(others), std::move(pareto)};
  return scatter;
}

struct Tile {
  std::string title;
  std::filesystem::path map;
};

// Of each cell's first seed, where its map was kept.
std::vector<Tile> maps_of(const TrialsOptions& options, const std::vector<Trial>& trials) {
  std::vector<Tile> tiles;
  std::vector<std::size_t> cells;
  for (const Trial& trial : trials) {
    const std::filesystem::path map = folder_of(trial, options.out_dir) / "map.png";
    if (!is_done(trial) || std::count(cells.begin(), cells.end(), trial.point->cell) > 0 ||
        !std::filesystem::exists(map)) {
      continue;
    }
    cells.push_back(trial.point->cell);
    tiles.push_back(
        {fmt::format("{}, {}, seed {}",
                     words_of(trial.point->mission, trial.point->values[0], *options.study),
                     trial.point->values[1], trial.seed),
         map});
  }
  return tiles;
}

void write_maps(const std::filesystem::path& file, const std::vector<Tile>& tiles,
                std::size_t columns) {
  constexpr std::size_t kMostColumns = 6;
  constexpr int kTile_px = 380;
  constexpr int kTitle_px = 26;
  std::vector<cv::Mat> maps;
  int tallest_px = 0;
  for (const Tile& tile : tiles) {
    const cv::Mat map = cv::imread(tile.map.string());
    if (map.empty()) {
      maps.emplace_back();
      continue;
    }
    const double scale =
        static_cast<double>(kTile_px * Canvas::kOver) / std::max(map.cols, map.rows);
    cv::resize(map, maps.emplace_back(), {}, scale, scale,
               scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
    tallest_px = std::max(tallest_px, (maps.back().rows + Canvas::kOver - 1) / Canvas::kOver);
  }
  columns = std::min({columns, kMostColumns, tiles.size()});
  const std::size_t rows = (tiles.size() + columns - 1) / columns;
  const int step_px = tallest_px + kTitle_px;
  Canvas canvas(static_cast<int>(columns) * kTile_px, static_cast<int>(rows) * step_px, kPaper);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const Vec2 corner(static_cast<double>(i % columns) * kTile_px,
                      static_cast<double>(i / columns) * step_px);
    canvas.text(tiles[i].title, corner + Vec2(8, 18), kInk, 14);
    if (!maps[i].empty()) {
      canvas.paste_over(maps[i], corner + Vec2(0, kTitle_px));
    }
  }
  write_file(file, png(canvas.shrunk()));
}

}  // namespace

void write_study_pictures(const TrialsOptions& options, const StudyRanking& ranking,
                          const std::vector<Trial>& trials) {
  constexpr std::size_t kMostMaps = 60;
  const Study& study = *options.study;
  for (const char* file : {"scores.png", "pareto.png", "maps.png"}) {
    std::filesystem::remove(options.out_dir / file);  // of a study as it was before
  }
  if (!ranking.scores.empty() && std::max(study.rigs.size(), study.rungs.size()) > 1) {
    write_file(options.out_dir / "scores.png", png(draw_bands(bands_of(study, ranking))));
  }
  if (study.scores.size() > 1) {
    const Scatter pareto = pareto_of(study, ranking);
    const bool any = std::any_of(pareto.layers.begin(), pareto.layers.end(),
                                 [](const ScatterLayer& layer) { return !layer.points.empty(); });
    if (any) {
      write_file(options.out_dir / "pareto.png", png(draw_scatter(pareto)));
    }
  }
  const std::vector<Tile> tiles = maps_of(options, trials);
  if (!tiles.empty() && tiles.size() <= kMostMaps) {
    write_maps(options.out_dir / "maps.png", tiles, study.rigs.size());
  }
}

}  // namespace panoptes
