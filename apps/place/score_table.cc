// SPDX-License-Identifier: BSD-3-Clause
#include "apps/place/score_table.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "core/base/text.h"
#include "core/geometry/pose2.h"

namespace panoptes {
namespace {

constexpr std::size_t kWhat = 52;
constexpr std::size_t kLeastColumn = 12;

/// What the first word of a key stands for.
const std::map<std::string, std::string>& chapters() {
  static const std::map<std::string, std::string> kChapters{
      {"cameras", "What it takes"},
      {"floor", "Floor"},
      {"sampling_m", "How finely the floor is seen"},
      {"obstacle_m", "What is small enough to be missed"},
      {"blind", "What is not seen near by, and how soon the robot stands"},
      {"blind_spot", "What is not seen at some heights"},
      {"overlap", "Views"},
      {"odometry", "How well pictures tell a motion (two of them, one sigma)"},
      {"loss", "When one camera is lost, at worst"},
      {"bus", "Bus"},
      {"calibratability", "How well a programmed motion tells the mountings (one sigma, worst)"}};
  return kChapters;
}

std::string number(const NamedScore& score) {
  return score.value ? fmt::format("{:.{}f}", *score.value * score.scale, score.digits) : "-";
}

/// With the scores that take longer.
std::vector<NamedScore> all_scores(const PlacedRig& placed) {
  std::vector<NamedScore> all = named_scores(placed.scores);
  if (placed.calibratability) {
    const std::vector<NamedScore> more = named_scores(placed.calibratability);
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

/// Where nine of ten have it; empty where that is what it is as drawn.
std::string spread_of(const PlacedRig& placed, std::size_t row, const NamedScore& score) {
  const auto& spreads = placed.sensitivity->spreads;
  if (row >= spreads.size() || !spreads[row]) {
    return "";
  }
  const auto shown = [&](double value) {
    return fmt::format("{:.{}f}", value * score.scale, score.digits);
  };
  const std::string low = shown(spreads[row]->low);
  const std::string high = shown(spreads[row]->high);
  return low == high ? "" : fmt::format("{} .. {}", low, high);
}

std::string in_words(Better better) {
  return better == Better::kHigher  ? "more is better"
         : better == Better::kLower ? "less is better"
                                    : "";
}

/// What the second rig has more, and whether that is better.
std::string difference(const NamedScore& first, const NamedScore& second) {
  if (!first.value && !second.value) {
    return "";
  }
  if (!first.value || !second.value) {
    return second.value ? "has it" : "has it not";
  }
  const double more = (*second.value - *first.value) * first.scale;
  const std::string text = fmt::format("{:+.{}f}", more, first.digits);
  if (text == fmt::format("{:+.{}f}", 0.0, first.digits) ||
      text == fmt::format("{:+.{}f}", -0.0, first.digits)) {
    return "the same";
  }
  if (first.better == Better::kNeither) {
    return text;
  }
  return text + ((more > 0) == (first.better == Better::kHigher) ? "  better" : "  worse");
}

std::string percent(double share) { return fmt::format("{:.0f} %", 100 * share); }

void add_cameras(const PlacedRig& placed, std::string& text) {
  for (std::size_t i = 0; i < placed.scores.losses.size(); ++i) {
    const CameraLoss& loss = placed.scores.losses[i];
    std::vector<std::string> words;
    const auto add = [&words](std::optional<double> share, const char* of_what) {
      constexpr double kTold = 0.005;
      if (share.value_or(0) >= kTold) {
        words.push_back(percent(*share) + " of " + of_what);
      }
    };
    add(loss.floor_seen, "the floor seen");
    add(loss.floor_mapped, "the floor mapped");
    add(loss.panorama, "the panorama");
    add(loss.opposite, "the opposite heading");
    text += fmt::format("  without {}: {} lost", loss.camera,
                        words.empty() ? "nothing seen is" : joined(words) + " are");
    if (!loss.blind_ahead_m && placed.scores.blind_ahead_m) {
      text += "; nothing is seen ahead";
    }
    if (placed.scores.driving.heading_rad) {
      text += loss.heading_sigma ? fmt::format("; the heading's sigma grows by {:.0f} %",
                                               100 * (*loss.heading_sigma - 1))
                                 : "; pictures tell no heading";
    }
    text += "\n";
    if (placed.scores.hull_share[i] > 0) {
      text += fmt::format("    {} of its picture shows the robot's own hull\n",
                          percent(placed.scores.hull_share[i]));
    }
  }
  for (const CameraOverlap& overlap : placed.scores.overlap.overlaps) {
    text += fmt::format("  {} and {} see the same in {} of the narrower view\n",
                        placed.scores.cameras[overlap.a], placed.scores.cameras[overlap.b],
                        percent(overlap.share));
  }
}

std::string about(const PlacedRig& placed) {
  std::string text = "\n" + placed.name + "\n";
  add_cameras(placed, text);
  const BusLoad& bus = placed.scores.bus;
  text += fmt::format("  bus: {:.0f} of {:.0f} {}{}\n", bus.load, bus.allowed, bus.unit,
                      bus.fits() ? "" : "; IT DOES NOT FIT: " + joined(bus.faults, "; "));
  if (placed.scores.margin_m && *placed.scores.margin_m < 0) {
    text +=
        "  what appears in the blind zone ahead could be stopped for, but is not seen: the "
        "zone is longer than the stopping distance\n";
  }
  if (placed.scores.far_m && *placed.scores.far_m < placed.scores.stopping_m) {
    text += "  it does not see as far as it needs to stop from full speed\n";
  }
  if (placed.calibratability) {
    std::map<std::string, std::vector<std::string>> open;  // what, and of which cameras
    for (const CameraCalibratability& camera : placed.calibratability->cameras) {
      for (const std::string& what : camera.unobservable) {
        open[what].push_back(camera.camera);
      }
    }
    for (const auto& [what, cameras] : open) {
      text += fmt::format("  a rose does not show, of {}: {}\n", joined(cameras), what);
    }
  }
  return text;
}

}  // namespace

std::string score_table(const std::vector<PlacedRig>& rigs) {
  std::vector<std::vector<NamedScore>> columns;
  std::size_t width = kLeastColumn;
  std::string text = fmt::format("{:<{}}", "", kWhat);
  for (const PlacedRig& placed : rigs) {
    columns.push_back(all_scores(placed));
    width = std::max(width, placed.name.size() + 2);
  }
  for (const PlacedRig& placed : rigs) {
    text += fmt::format("{:>{}}", placed.name, width);
  }
  const bool has_spread = rigs.size() == 1 && rigs.front().sensitivity.has_value();
  constexpr std::size_t kSpread = 18;
  text += rigs.size() > 1 ? "  difference\n"
          : has_spread    ? fmt::format("{:>{}}\n", "mounted off", kSpread)
                          : "\n";
  for (std::size_t row = 0; row < columns.front().size(); ++row) {
    const NamedScore& first = columns.front()[row];
    const std::string chapter = first.key.substr(0, first.key.find('.'));
    const bool opens = row == 0 || !columns.front()[row - 1].key.starts_with(chapter + ".");
    if (const auto heading = chapters().find(chapter); opens && heading != chapters().end()) {
      text += heading->second + "\n";
    }
    const std::string what =
        first.unit.empty() ? first.what : fmt::format("{} ({})", first.what, first.unit);
    text += fmt::format("  {:<{}}", what, kWhat - 2);
    for (const std::vector<NamedScore>& column : columns) {
      text += fmt::format("{:>{}}", number(column[row]), width);
    }
    if (has_spread) {
      text += fmt::format("{:>{}}", spread_of(rigs.front(), row, first), kSpread);
    }
    const std::string last =
        rigs.size() > 1 ? difference(first, columns[1][row]) : in_words(first.better);
    text += (last.empty() ? "" : "  " + last) + "\n";
  }
  if (has_spread) {
    const RigSensitivityOptions& off = rigs.front().sensitivity->off;
    text += fmt::format(
        "mounted off: where nine of ten such rigs are whose cameras are off by {:.0f} deg and "
        "{:.0f} "
        "cm (one sigma, each way; {} draws)\n",
        rad_to_deg(off.rotation_rad), 100 * off.position_m, off.draws);
  }
  for (const PlacedRig& placed : rigs) {
    text += about(placed);
  }
  return text;
}

}  // namespace panoptes
