// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study/study.h"

#include <algorithm>
#include <cctype>
#include <set>

#include <fmt/format.h>

#include "apps/report/figure_names.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace panoptes {
namespace {

// Names are cells of a table and parts of folders.
void bind_name(Fields& f, std::string& name, std::string& place) {
  f.needed("name", name);
  place = f.where("name");
  const bool starts_well =
      !name.empty() && std::isalnum(static_cast<unsigned char>(name.front())) != 0;
  const bool fine = starts_well && std::none_of(name.begin(), name.end(), [](unsigned char c) {
                      return c < ' ' || c == 0x7f || c == '/' || c == '|' || c == '*';
                    });
  f.require(!f.present("name") || fine, "name",
            "must begin with a letter or a digit, and have none of / | *");
}

std::string key_of(const std::string& setting) { return setting.substr(0, setting.find('=')); }

void add(StudySettings& to, const StudySettings& more) {
  to.set.insert(to.set.end(), more.set.begin(), more.set.end());
  to.places.insert(to.places.end(), more.places.begin(), more.places.end());
}

void add(StudySettings& to, const StudyRig& rig) {
  if (!rig.file.empty()) {
    for (const char* key : {"rig=", "platform.nominal_rig="}) {
      to.set.push_back(key + in_quotes(rig.file));
      to.places.push_back(rig.file_place);
    }
  }
  add(to, rig.settings);
}

bool names(const std::vector<std::string>& list, const std::string& name) {
  return list.empty() || std::find(list.begin(), list.end(), name) != list.end();
}

bool concerns(const StudyLimit& limit, const StudyCell& cell) {
  return names(limit.missions, cell.mission) && names(limit.rigs, cell.rig) &&
         names(limit.rungs, cell.rung);
}

// What does not fit together, a line each.
class CrossCheck {
 public:
  template <class T>
  std::vector<std::string> names_of(const std::string& key, const std::vector<T>& entries) {
    std::vector<std::string> all;
    for (const T& entry : entries) {
      if (std::find(all.begin(), all.end(), entry.name) != all.end()) {
        say(entry.name_place, key,
            "two are called '" + entry.name + "'; give one of them another name");
      }
      all.push_back(entry.name);
    }
    return all;
  }

  void check(const std::string& key, const std::vector<std::string>& asked,
             const std::vector<std::string>& places, const std::vector<std::string>& known) {
    for (std::size_t i = 0; i < asked.size(); ++i) {
      if (std::find(known.begin(), known.end(), asked[i]) == known.end()) {
        const std::string near = nearest_word(asked[i], known);
        say(places[i], key,
            "there is no '" + asked[i] + "'; " +
                (near.empty() ? "known: " + joined(known) : "did you mean " + near + "?"));
      }
    }
  }

  void check(const StudySettings& settings) {
    for (std::size_t i = 0; i < settings.set.size(); ++i) {
      const std::size_t equals = settings.set[i].find('=');
      if (equals == std::string::npos || equals == 0) {
        say(settings.places[i], "set", "must be key.path=value, got " + settings.set[i]);
      } else if (key_of(settings.set[i]) == "seed") {
        say(settings.places[i], "set", "must not say the seed; --seeds does");
      }
    }
  }

  void say(const std::string& place, const std::string& key, const std::string& what) {
    lines_.push_back(place + ": " + key + ": " + what);
  }

  const std::vector<std::string>& lines() const { return lines_; }

 private:
  std::vector<std::string> lines_;
};

std::vector<std::string> faults_of(const Study& study) {
  CrossCheck faults;
  const std::vector<std::string> missions = faults.names_of("missions", study.missions);
  const std::vector<std::string> rigs = faults.names_of("rigs", study.rigs);
  const std::vector<std::string> rungs = faults.names_of("rungs", study.rungs);
  faults.check(study.settings);
  for (const StudyMission& mission : study.missions) {
    faults.check(mission.settings);
  }
  for (const StudyRig& rig : study.rigs) {
    faults.check(rig.settings);
  }
  for (const StudyRung& rung : study.rungs) {
    if (study.halving && !rung.rigs.empty()) {
      faults.say(rung.rig_places.front(), "rungs.rigs",
                 "must not be given beside halving, which compares rigs over all rungs");
    }
    faults.check(rung.settings);
    faults.check("rungs.rigs", rung.rigs, rung.rig_places, rigs);
  }
  if (study.halving && study.rigs.size() < static_cast<std::size_t>(study.halving->keep) + 2) {
    faults.say(study.halving->place, "halving",
               fmt::format("has nothing to drop: {} beside the first, {} to be kept",
                           study.rigs.size() - 1, study.halving->keep));
  }
  const std::size_t before = faults.lines().size();
  for (const StudyLimit& limit : study.limits) {
    faults.check("limits.missions", limit.missions, limit.mission_places, missions);
    faults.check("limits.rigs", limit.rigs, limit.rig_places, rigs);
    faults.check("limits.rungs", limit.rungs, limit.rung_places, rungs);
  }
  if (faults.lines().size() == before) {
    const std::vector<StudyCell> cells = cells_of(study);
    for (const StudyLimit& limit : study.limits) {
      if (std::none_of(cells.begin(), cells.end(),
                       [&](const StudyCell& cell) { return concerns(limit, cell); })) {
        faults.say(limit.place, "limits",
                   "'" + limit.require +
                       "' concerns no run; no rung that it names is tried with a "
                       "rig that it names");
      }
    }
  }
  return faults.lines();
}

}  // namespace

void bind(Fields& f, StudySettings& o) { f.texts("set", o.set, o.places); }

bool calibrates(const std::string& command) { return command.starts_with("calibrate"); }

void bind(Fields& f, StudyMission& o) {
  bind_name(f, o.name, o.name_place);
  f.require(f.writing() || f.present("mission"), "mission", "missing; it must be given");
  f.path("mission", o.file);
  static const std::vector<std::string> kCommands{
      "explore", "calibrate", "calibrate --method thesis", "calibrate --method cycles"};
  f("command", o.command);
  f.require(std::find(kCommands.begin(), kCommands.end(), o.command) != kCommands.end(), "command",
            "must be one of " + joined(kCommands));
  bind(f, o.settings);
}

void bind(Fields& f, StudyRig& o) {
  bind_name(f, o.name, o.name_place);
  f.path("rig", o.file);
  o.file_place = f.where("rig");
  bind(f, o.settings);
}

void bind(Fields& f, StudyRung& o) {
  bind_name(f, o.name, o.name_place);
  bind(f, o.settings);
  f.texts("rigs", o.rigs, o.rig_places);
}

void bind(Fields& f, StudyLimit& o) {
  f.needed("require", o.require);
  o.place = f.where("require");
  if (!o.require.empty()) {
    try {
      o.limit = parse_limit(o.require);
    } catch (const ConfigError& error) {
      f.require(false, "require", error.what());
    }
  }
  f.texts("missions", o.missions, o.mission_places);
  f.texts("rigs", o.rigs, o.rig_places);
  f.texts("rungs", o.rungs, o.rung_places);
}

std::optional<double> StudyScore::of(const FigureRow& run) const {
  if (figure().find('*') == std::string::npos) {
    return run.find(figure());
  }
  std::optional<double> worst;
  for (const std::string& name : run.names()) {
    if (is_one_of(name, figure())) {
      const double value = *run.find(name);
      worst = !worst ? value : less_is_better() ? std::max(*worst, value) : std::min(*worst, value);
    }
  }
  return worst;
}

void bind(Fields& f, StudyScore& o) {
  f("least", o.least);
  f("most", o.most);
  f.require(o.least.empty() != o.most.empty(), o.least.empty() ? "least" : "most",
            o.least.empty() ? "missing; least or most must name the figure to compare rigs by"
                            : "must not be given beside least");
  const std::string near = nearest_word(o.figure(), figure_names());
  f.require(o.figure().empty() || is_figure(o.figure()) || is_calibration_figure(o.figure()),
            o.least.empty() ? "most" : "least",
            near.empty() ? "must be a figure of a run" : "must be a figure of a run, as " + near);
}

void bind(Fields& f, StudyHalving& o) {
  f("seeds", o.seeds, at_least(1));
  f("keep", o.keep, at_least(1));
  o.place = f.where("keep");
  bind(f, o.score);
}

void bind(Fields& f, Study& o) {
  const auto some = [&f](const char* key, auto& entries) {
    f.needed(key, entries);
    f.require(!f.present(key) || !entries.empty(), key, "must have one entry at least");
  };
  some("missions", o.missions);
  bind(f, o.settings);
  some("rigs", o.rigs);
  some("rungs", o.rungs);
  f("limits", o.limits);
  std::vector<std::string> lines;
  std::vector<std::string> places;
  for (const StudyComparison& one : o.against_first) {
    lines.push_back(one.line);
    places.push_back(one.place);
  }
  f.texts("against_first", lines, places);
  o.against_first.clear();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    StudyComparison one{lines[i], places[i], {}};
    try {
      one.limit = parse_comparison(lines[i]);
    } catch (const ConfigError& error) {
      f.require(false, "against_first", error.what());
      continue;
    }
    o.against_first.push_back(std::move(one));
  }
  f("scores", o.scores);
  std::set<std::string> named;
  for (const StudyScore& score : o.scores) {
    f.require(score.figure().empty() || named.insert(score.figure()).second, "scores",
              "must name each figure once, " + score.figure() + " comes twice");
  }
  f("halving", o.halving);
  f("figure", o.figure);
  const std::string near = nearest_word(o.figure, figure_names());
  f.require(o.figure.empty() || is_figure(o.figure) || is_calibration_figure(o.figure), "figure",
            near.empty() ? "must be a figure of a run, or of a calibration"
                         : "must be a figure of a run, or of a calibration, as " + near);
}

Study read_study(const std::string& file) {
  auto study = read_settings<Study>(file);
  study.file = file;
  if (const std::vector<std::string> faults = faults_of(study); !faults.empty()) {
    throw ConfigError(faults);
  }
  return study;
}

std::vector<StudyCell> cells_of(const Study& study) {
  std::vector<StudyCell> cells;
  for (const StudyMission& mission : study.missions) {
    for (const StudyRung& rung : study.rungs) {
      for (const StudyRig& rig : study.rigs) {
        if (!names(rung.rigs, rig.name)) {
          continue;
        }
        StudyCell cell{mission.name,    rig.name,       rung.name, mission.file,
                       mission.command, study.settings, {}};
        add(cell.settings, mission.settings);
        add(cell.settings, rig);
        add(cell.settings, rung.settings);
        for (const StudyLimit& limit : study.limits) {
          if (concerns(limit, cell)) {
            cell.limits.push_back(limit.limit);
          }
        }
        cells.push_back(std::move(cell));
      }
    }
  }
  return cells;
}

std::vector<std::string> with_places(const StudySettings& settings,
                                     std::vector<std::string> lines) {
  for (std::string& line : lines) {
    for (std::size_t i = settings.set.size(); i-- > 0;) {
      const std::string key = key_of(settings.set[i]);
      const std::string said = "--set " + key + ": ";
      if (!line.starts_with(said)) {
        continue;
      }
      std::string what = line.substr(said.size());
      const std::size_t star = key.find('*');
      if (star != std::string::npos && what.starts_with(key.substr(0, star))) {
        what.erase(0, what.find(": ") + 2);  // one of those that the star stands for
      }
      line = fmt::format("{}: {}: {}", settings.places[i], key, what);
      break;
    }
  }
  return lines;
}

}  // namespace panoptes
