// SPDX-License-Identifier: BSD-3-Clause
#include "apps/recognition/recognition_table.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include <fmt/format.h>

#include "apps/draw/canvas.h"
#include "apps/draw/pictures.h"

namespace panoptes {
namespace {

bool same_method(const RecognitionRow& a, const RecognitionRow& b) {
  return a.histogram == b.histogram && a.distance == b.distance && a.pictures == b.pictures;
}

const RecognitionRow* find(const std::vector<RecognitionRow>& rows, const RecognitionRow& like) {
  const auto found = std::find_if(
      rows.begin(), rows.end(), [&](const RecognitionRow& row) { return same_method(row, like); });
  return found == rows.end() ? nullptr : &*found;
}

// Every combination that some world has, in order of appearance.
std::vector<RecognitionRow> methods_of(const std::vector<RecognitionWorld>& worlds) {
  std::vector<RecognitionRow> methods;
  for (const RecognitionWorld& world : worlds) {
    for (const RecognitionRow& row : world.rows) {
      if (find(methods, row) == nullptr) {
        methods.push_back({row.histogram, row.distance, row.pictures, {}});
      }
    }
  }
  return methods;
}

// Over the worlds that have it.
std::optional<double> mean_recall(const std::vector<RecognitionWorld>& worlds,
                                  const RecognitionRow& method) {
  double sum = 0;
  int count = 0;
  for (const RecognitionWorld& world : worlds) {
    const RecognitionRow* row = find(world.rows, method);
    if (row != nullptr && row->recall()) {
      sum += *row->recall();
      ++count;
    }
  }
  return count > 0 ? std::optional(sum / count) : std::nullopt;
}

std::string percent(const std::optional<double>& share) {
  return share ? fmt::format("{:.0f}", 100 * *share) : "-";
}

// Words of a list, in order of appearance.
void note(std::vector<std::string>& words, const std::string& word) {
  if (std::find(words.begin(), words.end(), word) == words.end()) {
    words.push_back(word);
  }
}

std::string spaced(std::string word) {
  std::replace(word.begin(), word.end(), '_', ' ');
  return word;
}

// From paper to a deep blue.
Colour shade(double share) {
  const auto mix = [&](int from, int to) {
    return static_cast<unsigned char>(std::lround(from + share * (to - from)));
  };
  return {mix(247, 16), mix(250, 72), mix(253, 138)};
}

}  // namespace

void add_rows(RecognitionWorld& world, const std::vector<RecognitionRow>& rows) {
  for (const RecognitionRow& row : rows) {
    const auto known =
        std::find_if(world.rows.begin(), world.rows.end(),
                     [&](const RecognitionRow& other) { return same_method(row, other); });
    if (known == world.rows.end()) {
      world.rows.push_back(row);
      continue;
    }
    known->found.keyframes += row.found.keyframes;
    known->found.recognised += row.found.recognised;
    known->found.revisits_same += row.found.revisits_same;
    known->found.revisits_opposite += row.found.revisits_opposite;
    known->found.recalled_same += row.found.recalled_same;
    known->found.recalled_opposite += row.found.recalled_opposite;
  }
}

std::vector<std::string> recognition_table(const std::vector<RecognitionWorld>& worlds) {
  std::vector<RecognitionRow> methods = methods_of(worlds);
  std::stable_sort(methods.begin(), methods.end(),
                   [&](const RecognitionRow& a, const RecognitionRow& b) {
                     return mean_recall(worlds, a) > mean_recall(worlds, b);
                   });
  std::string head =
      fmt::format("{:<16}{:<14}{:<14}{:>5}", "histogram", "distance", "pictures", "mean");
  for (const RecognitionWorld& world : worlds) {
    head += fmt::format("  {:>18}", world.name);
  }
  std::vector<std::string> lines{
      "keyframes recognised at full precision, % (revisits, same / opposite heading, %)", head};
  for (const RecognitionRow& method : methods) {
    std::string line = fmt::format("{:<16}{:<14}{:<14}{:>5}", method.histogram, method.distance,
                                   method.pictures, percent(mean_recall(worlds, method)));
    for (const RecognitionWorld& world : worlds) {
      const RecognitionRow* row = find(world.rows, method);
      const std::string cell =
          row == nullptr
              ? "-"
              : fmt::format("{} ({:>3} / {:>3})", percent(row->recall()),
                            percent(row->recall_same()), percent(row->recall_opposite()));
      line += fmt::format("  {:>{}}", cell, std::max<std::size_t>(18, world.name.size()));
    }
    lines.push_back(line + (method.is_thesis() ? "  the thesis's own" : ""));
  }
  return lines;
}

cv::Mat draw_recognition_table(const std::vector<RecognitionWorld>& worlds) {
  constexpr double kMargin_px = 24;
  constexpr double kNames_px = 250;
  constexpr double kCell_px = 104;
  constexpr double kRow_px = 46;
  constexpr double kHead_px = 118;
  constexpr double kFoot_px = 44;
  constexpr double kBetween_px = 10;  // pictures of one kind and of the next
  std::vector<std::string> histograms;
  std::vector<std::string> distances;
  std::vector<std::string> pictures;
  for (const RecognitionRow& method : methods_of(worlds)) {
    note(histograms, method.histogram);
    note(distances, method.distance);
    note(pictures, method.pictures);
  }
  const double panel_px = kCell_px * static_cast<double>(distances.size()) + kMargin_px;
  const double block_px = kRow_px * static_cast<double>(histograms.size()) + kBetween_px;
  const double height_px = kHead_px + block_px * static_cast<double>(pictures.size()) + kFoot_px;
  const std::string title = "Keyframes recognised at full precision, %";
  const std::string legend =
      "below: revisits found, same / opposite heading; framed: the thesis's own";
  const double width_px =
      std::max({kNames_px + panel_px * static_cast<double>(worlds.size()) + kMargin_px,
                2 * kMargin_px + Canvas::text_width(title, 19),
                2 * kMargin_px + Canvas::text_width(legend, 14)});
  Canvas canvas(static_cast<int>(width_px), static_cast<int>(height_px), kPaper);
  canvas.text(title, {kMargin_px, 34}, kInk, 19);
  canvas.text(legend, {kMargin_px, height_px - 16}, kFaint, 14);
  for (std::size_t p = 0; p < pictures.size(); ++p) {
    for (std::size_t h = 0; h < histograms.size(); ++h) {
      const double top =
          kHead_px + block_px * static_cast<double>(p) + kRow_px * static_cast<double>(h);
      canvas.text(spaced(pictures[p]) + ", " + spaced(histograms[h]),
                  {kNames_px - 10, top + 0.6 * kRow_px}, kInk, 14, 1);
    }
  }
  for (std::size_t w = 0; w < worlds.size(); ++w) {
    const double left = kNames_px + panel_px * static_cast<double>(w);
    canvas.text(worlds[w].name, {left, 74}, kInk, 16);
    for (std::size_t d = 0; d < distances.size(); ++d) {
      const double x = left + kCell_px * static_cast<double>(d);
      canvas.text(spaced(distances[d]), {x + kCell_px / 2, kHead_px - 12}, kFaint, 14, 0.5);
      for (std::size_t p = 0; p < pictures.size(); ++p) {
        for (std::size_t h = 0; h < histograms.size(); ++h) {
          const RecognitionRow* row =
              find(worlds[w].rows, {histograms[h], distances[d], pictures[p], {}});
          if (row == nullptr) {
            continue;
          }
          const Vec2 low(
              x, kHead_px + block_px * static_cast<double>(p) + kRow_px * static_cast<double>(h));
          const Vec2 high = low + Vec2(kCell_px - 2, kRow_px - 2);
          const double share = row->recall().value_or(0);
          const Colour ink = share > 0.5 ? kPaper : kInk;
          canvas.box(low, high, shade(share));
          canvas.text(percent(row->recall()), low + Vec2(kCell_px / 2, 21), ink, 17, 0.5);
          canvas.text(
              fmt::format("{}/{}  {}/{}", row->found.recalled_same, row->found.revisits_same,
                          row->found.recalled_opposite, row->found.revisits_opposite),
              low + Vec2(kCell_px / 2, 38), ink, 11, 0.5);
          if (row->is_thesis()) {
            canvas.frame(low, high, kWrongColour, 2);
          }
        }
      }
    }
  }
  return canvas.shrunk();
}

}  // namespace panoptes
