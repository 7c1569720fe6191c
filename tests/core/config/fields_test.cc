// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/fields.h"

#include <filesystem>
#include <fstream>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

struct Dwa {
  double max_speed_mps = 0.6;
  double horizon_s = 1.5;
  int turn_samples = 21;
};
void bind(Fields& f, Dwa& o) {
  f("max_speed_mps", o.max_speed_mps, positive);
  f("horizon_s", o.horizon_s, between(0.1, 10.0));
  f("turn_samples", o.turn_samples, at_least(3));
  f.require(o.turn_samples % 2 == 1, "turn_samples", "must be odd so that straight ahead is tried");
}

struct Histogram {
  static constexpr std::string_view kName = "histogram";
  double alpha = 2.5;
};
void bind(Fields& f, Histogram& o) { f("alpha", o.alpha); }

struct Route {
  static constexpr std::string_view kName = "route";
  static constexpr std::string_view kShort = "file";
  std::string file;
};
void bind(Fields& f, Route& o) { f.needed("file", o.file); }

struct Dish {
  static constexpr std::string_view kName = "dish";
  int spoons = 1;
};
void bind(Fields& f, Dish& o) { f("spoons", o.spoons, positive); }

enum class Rows { kAll, kLowerHalf };

struct Settings {
  Dwa dwa;
  bool on = false;
  std::string name = "x";
  std::uint64_t seed = 7;
  std::int64_t stamp_ns = 0;
  double fov_rad = 1;
  Vec2 goal = Vec2::Zero();
  Rows rows = Rows::kAll;
  std::vector<std::string> words;
  std::vector<Dwa> several;
  std::map<std::string, Dwa> named;
  std::optional<Vec3> start;
  std::variant<Histogram, Route> method;
};
void bind(Fields& f, Settings& o) {
  f("dwa", o.dwa);
  f("on", o.on);
  f("name", o.name);
  f("seed", o.seed);
  f("stamp_ns", o.stamp_ns);
  f.angle("fov", o.fov_rad, between(0.01, 3));
  f("goal_m", o.goal);
  f.word("rows", o.rows, {{"all", Rows::kAll}, {"lower_half", Rows::kLowerHalf}});
  f("words", o.words);
  f("several", o.several);
  f("named", o.named);
  f("start_m", o.start);
  f.choice("method", o.method);
}

struct Place {
  std::optional<std::variant<Histogram, Dish>> made;
  std::vector<std::string> files;
  std::vector<std::string> file_mentions;
  std::map<std::string, std::string> pictures;
  std::map<std::string, std::string> picture_mentions;
};
void bind(Fields& f, Place& o) {
  f.choice("made", o.made);
  f.paths("files", o.files, o.file_mentions);
  f.paths("pictures", o.pictures, o.picture_mentions);
}

struct Mission {
  Dwa robot;
  Dwa world;
  std::string world_file;
  std::string mesh;
};
void bind(Fields& f, Mission& o) {
  f.file_or_inline("robot", o.robot);
  f.file_or_inline("world", o.world, o.world_file);
  f.path("mesh", o.mesh);
}

template <class T = Settings>
std::vector<std::string> faults(const std::string& text,
                                const std::vector<std::string>& overrides = {}) {
  try {
    read_settings_text<T>(text, "m.yaml", overrides);
  } catch (const ConfigError& error) {
    return error.lines();
  }
  return {};
}

Settings read(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return read_settings_text<Settings>(text, "m.yaml", overrides);
}

class InAFolder : public ScratchTest {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
};

TEST(Fields, ReadsEveryKindOfField) {
  const Settings s = read(R"(
dwa: {max_speed_mps: 0.3, turn_samples: +5}
on: true
name: "a b"
seed: 18446744073709551615
stamp_ns: -9223372036854775808
fov_deg: 90
goal_m: [1, -2e-3]
rows: lower_half
words: [one, "two, three"]
several: [{horizon_s: 2}, {}]
named: {left: {turn_samples: 7}}
start_m: [1, 2, 3]
method: {kind: histogram, alpha: 1}
)");
  EXPECT_EQ(s.dwa.max_speed_mps, 0.3);
  EXPECT_EQ(s.dwa.turn_samples, 5);
  EXPECT_EQ(s.dwa.horizon_s, 1.5);
  EXPECT_TRUE(s.on);
  EXPECT_EQ(s.name, "a b");
  EXPECT_EQ(s.seed, 18446744073709551615U);
  EXPECT_EQ(s.stamp_ns, std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(s.fov_rad, deg_to_rad(90));
  EXPECT_EQ(s.goal, Vec2(1, -0.002));
  EXPECT_EQ(s.rows, Rows::kLowerHalf);
  EXPECT_THAT(s.words, ElementsAre("one", "two, three"));
  ASSERT_EQ(s.several.size(), 2U);
  EXPECT_EQ(s.several[0].horizon_s, 2);
  EXPECT_EQ(s.named.at("left").turn_samples, 7);
  EXPECT_EQ(s.start.value(), Vec3(1, 2, 3));
  EXPECT_EQ(std::get<Histogram>(s.method).alpha, 1);
}

TEST(Fields, AnEmptyFileIsAllDefaults) {
  EXPECT_EQ(write_settings(read("")), write_settings(Settings()));
  EXPECT_EQ(write_settings(read("# nothing\n")), write_settings(Settings()));
  EXPECT_EQ(write_settings(read("dwa:\n  # horizon_s: 3\n")), write_settings(Settings()));
}

TEST(Fields, AMethodIsNamedInThreeWays) {
  EXPECT_EQ(std::get<Histogram>(read("method: histogram").method).alpha, 2.5);
  EXPECT_EQ(std::get<Route>(read("method: {route: a.yaml}").method).file, "a.yaml");
  EXPECT_EQ(std::get<Route>(read("method: {kind: route, file: a.yaml}").method).file, "a.yaml");
  EXPECT_EQ(std::get<Histogram>(read("", {"method.alpha=3"}).method).alpha, 3);
  EXPECT_EQ(std::get<Histogram>(read("method: histogram", {"method.alpha=3"}).method).alpha, 3);
}

TEST(Fields, WhatMayBeAbsentIsNamedByItsKey) {
  const auto made = [](const std::string& text, const std::vector<std::string>& overrides = {}) {
    return read_settings_text<Place>(text, "m.yaml", overrides).made;
  };
  EXPECT_FALSE(made("").has_value());
  EXPECT_FALSE(made("made: null").has_value());
  EXPECT_EQ(std::get<Dish>(made("made: dish").value()).spoons, 1);
  EXPECT_EQ(std::get<Dish>(made("made: {dish: {spoons: 3}}").value()).spoons, 3);
  EXPECT_EQ(std::get<Dish>(made("made: {dish: }").value()).spoons, 1);
  EXPECT_EQ(std::get<Dish>(made("", {"made.dish.spoons=4"}).value()).spoons, 4);
  EXPECT_EQ(std::get<Histogram>(made("made: dish", {"made=histogram"}).value()).alpha, 2.5);
  for (const char* text : {"made: {dish: {spoons: 3}}", "", "made: histogram"}) {
    const std::string written = write_settings(read_settings_text<Place>(text, "m.yaml"));
    EXPECT_EQ(write_settings(read_settings_text<Place>(written, "m.yaml")), written);
  }
  EXPECT_EQ(write_settings(read_settings_text<Place>("made: {dish: {spoons: 3}}", "m.yaml")),
            "made:\n  dish:\n    spoons: 3\nfiles: []\npictures: {}\n");
}

TEST(Fields, RefusesWhatCannotBeMade) {
  EXPECT_THAT(faults<Place>("made: {disc: {}}"),
              ElementsAre("m.yaml:1:8: made: must be one of histogram, dish, got disc; did you "
                          "mean dish?"));
  EXPECT_THAT(faults<Place>("made: {dish: {}, histogram: {}}"),
              ElementsAre("m.yaml:1:7: made: must name one of histogram, dish, got 2 keys"));
  EXPECT_THAT(faults<Place>("made: [dish]"),
              ElementsAre("m.yaml:1:7: made: must be one of histogram, dish, got a list"));
  EXPECT_THAT(faults<Place>("made: {dish: {spoons: 0}}"),
              ElementsAre("m.yaml:1:23: made.dish.spoons: must be > 0, got 0"));
}

TEST(Fields, WhatIsWrittenReadsBackToTheSameBits) {
  Rng rng(11);
  for (int i = 0; i < 200; ++i) {
    Settings s;
    s.dwa.max_speed_mps = std::abs(rng.normal()) + 1e-300;
    s.on = rng.uniform() < 0.5;
    for (int k = rng.index(12); k > 0; --k) {
      s.name += static_cast<char>(1 + rng.index(126));
    }
    s.seed = rng.next();
    s.stamp_ns = static_cast<std::int64_t>(rng.next());
    s.fov_rad = rng.uniform(0.01, 3);
    s.goal = {rng.normal() * 1e30, rng.normal() * 1e-30};
    s.rows = rng.uniform() < 0.5 ? Rows::kAll : Rows::kLowerHalf;
    s.words = {"", "~", "true", "3", "null", "a: b", "- x", "#", "\"", "\\", "\n", s.name};
    s.several.resize(static_cast<std::size_t>(rng.index(3)));
    s.named["a.b"] = Dwa{1, 2, 3};
    s.named["true"] = Dwa{};
    if (rng.uniform() < 0.5) {
      s.start = Vec3(rng.normal(), 0, -0.0);
    }
    if (rng.uniform() < 0.5) {
      s.method = Route{s.name};
    }
    const std::string text = write_settings(s);
    const Settings back = read(text);
    EXPECT_EQ(write_settings(back), text);
    EXPECT_EQ(back.name, s.name);
    EXPECT_EQ(back.words, s.words);
    EXPECT_EQ(back.fov_rad, s.fov_rad);
    EXPECT_EQ(back.goal, s.goal);
    EXPECT_EQ(back.dwa.max_speed_mps, s.dwa.max_speed_mps);
    EXPECT_EQ(back.seed, s.seed);
    EXPECT_EQ(back.stamp_ns, s.stamp_ns);
    EXPECT_EQ(back.start.has_value(), s.start.has_value());
  }
}

TEST(Fields, WritesInTheOrderOfTheBind) {
  Settings s;
  s.words = {"collisions == 0"};
  EXPECT_EQ(write_settings(s), R"(dwa:
  max_speed_mps: 0.6
  horizon_s: 1.5
  turn_samples: 21
"on": false
name: x
seed: 7
stamp_ns: 0
fov_rad: 1
goal_m: [0, 0]
rows: all
words: ["collisions == 0"]
several: []
named: {}
start_m: null
method:
  kind: histogram
  alpha: 2.5
)");
}

TEST(Fields, ReportsAllFaultsAtOnceWhereTheReaderCanClick) {
  EXPECT_THAT(faults("dwa:\n  max_speed_mps: -0.3\n  horizon: 2\n  turn_samples: 4\n"
                     "on: yes\nseed: 3.5\n"),
              ElementsAre("m.yaml:2:18: dwa.max_speed_mps: must be > 0, got -0.3",
                          "m.yaml:3:3: dwa.horizon: unknown key; did you mean horizon_s?",
                          "m.yaml:4:17: dwa.turn_samples: must be odd so that straight ahead is "
                          "tried, got 4",
                          "m.yaml:5:5: on: must be true or false, got yes",
                          "m.yaml:6:7: seed: must be a whole number, got 3.5"));
}

TEST(Fields, RefusesWrongTypes) {
  EXPECT_THAT(faults("dwa: 3"),
              ElementsAre("m.yaml:1:6: dwa: must be a mapping (key: value), got 3"));
  EXPECT_THAT(faults("dwa: [1]"),
              ElementsAre("m.yaml:1:6: dwa: must be a mapping (key: value), got a list"));
  EXPECT_THAT(faults("dwa: {horizon_s: fast}"),
              ElementsAre("m.yaml:1:18: dwa.horizon_s: must be a number, got fast"));
  EXPECT_THAT(faults("dwa: {horizon_s: \"2\"}"),
              ElementsAre("m.yaml:1:18: dwa.horizon_s: must be a number, got \"2\""));
  EXPECT_THAT(faults("dwa: {horizon_s: [2]}"),
              ElementsAre("m.yaml:1:18: dwa.horizon_s: must be a number, got a list"));
  EXPECT_THAT(faults("goal_m: [1]"),
              ElementsAre("m.yaml:1:9: goal_m: must be a list of 2 numbers, got 1"));
  EXPECT_THAT(faults("goal_m: [1, x]"),
              ElementsAre("m.yaml:1:13: goal_m[1]: must be a number, got x"));
  EXPECT_THAT(faults("words: one"), ElementsAre("m.yaml:1:8: words: must be a list, got one"));
  EXPECT_THAT(faults("name: {a: b}"), ElementsAre("m.yaml:1:7: name: must be text, got a mapping"));
  EXPECT_THAT(faults("seed: -1"), ElementsAre("m.yaml:1:7: seed: must be a whole number from 0 to "
                                              "18446744073709551615, got -1"));
  EXPECT_THAT(faults("dwa: {turn_samples: 3000000000}"),
              ElementsAre("m.yaml:1:21: dwa.turn_samples: must be a whole number from -2147483648 "
                          "to 2147483647, got 3000000000"));
  EXPECT_THAT(faults("several: [{horizon_s: 99}]"),
              ElementsAre("m.yaml:1:23: several[0].horizon_s: must be from 0.1 to 10, got 99"));
  EXPECT_THAT(
      faults("named: {left: {horizn_s: 2}}"),
      ElementsAre("m.yaml:1:16: named.left.horizn_s: unknown key; did you mean horizon_s?"));
  EXPECT_THAT(faults("[1, 2]"),
              ElementsAre("m.yaml:1:1: the file must hold a mapping (key: value)"));
}

TEST(Fields, RefusesNumbersThatAreNotFinite) {
  for (const char* text : {".nan", ".inf", "-.inf", ".NaN", "nan", "inf", "-Infinity"}) {
    EXPECT_THAT(
        faults(std::string("dwa: {horizon_s: ") + text + "}"),
        ElementsAre(std::string("m.yaml:1:18: dwa.horizon_s: must be finite, got ") + text));
  }
  EXPECT_THAT(faults("dwa: {horizon_s: 1e999}"),
              ElementsAre("m.yaml:1:18: dwa.horizon_s: must be a number that a double can hold, "
                          "got 1e999"));
}

TEST(Fields, RefusesWordsItDoesNotKnow) {
  EXPECT_THAT(
      faults("rows: lowerhalf"),
      ElementsAre("m.yaml:1:7: rows: must be one of all, lower_half, got lowerhalf; did you "
                  "mean lower_half?"));
  EXPECT_THAT(
      faults("method: histogramm"),
      ElementsAre("m.yaml:1:9: method: must be one of histogram, route, got histogramm; did "
                  "you mean histogram?"));
  EXPECT_THAT(faults("method: {kind: none, alpha: 3}"),
              ElementsAre("m.yaml:1:16: method: must be one of histogram, route, got none"));
  EXPECT_THAT(
      faults("method: {spoons: 3}"),
      ElementsAre("m.yaml:1:10: method.spoons: unknown key; known: kind, alpha; kind is one "
                  "of histogram, route"));
  EXPECT_THAT(faults("method: {alph: 3}"),
              ElementsAre("m.yaml:1:10: method.alph: unknown key; did you mean alpha?"));
  EXPECT_THAT(faults("method: {kind: route}"),
              ElementsAre("m.yaml:1:9: method.file: missing; it must be given"));
  EXPECT_THAT(faults("method: {kind: histogram, file: x}"),
              ElementsAre("m.yaml:1:27: method.file: unknown key; known: kind, alpha"));
}

TEST(Fields, RefusesKeysGivenTwice) {
  EXPECT_THAT(faults("seed: 1\non: true\nseed: 1\n"),
              ElementsAre("m.yaml:3:1: seed: given twice; the first is in line 1"));
  EXPECT_THAT(faults("dwa: {horizon_s: 1, horizon_s: 2}"),
              ElementsAre("m.yaml:1:21: dwa.horizon_s: given twice; the first is in line 1"));
  EXPECT_THAT(faults("fov_deg: 90\nfov_rad: 1\n"),
              ElementsAre("m.yaml:2:10: fov_rad: given twice; fov_deg says it already"));
}

TEST(Fields, AnglesKeepTheirRuleInEitherUnit) {
  EXPECT_THAT(faults("fov_deg: 300"),
              ElementsAre("m.yaml:1:10: fov_deg: must be from 0.572958 to 171.887339, got 300"));
  EXPECT_THAT(faults("fov_rad: 4"),
              ElementsAre("m.yaml:1:10: fov_rad: must be from 0.01 to 3, got 4"));
  EXPECT_THAT(faults("fov: 90"),
              ElementsAre("m.yaml:1:1: fov: unknown key; did you mean fov_deg?"));
}

TEST(Fields, BrokenYamlIsAFaultWithItsPlace) {
  EXPECT_THAT(faults("dwa: {horizon_s: 1\n"),
              ElementsAre("m.yaml:2:1: not valid yaml: end of map flow not found"));
  EXPECT_THAT(
      faults("a: b\n---\nc: d\n"),
      ElementsAre("m.yaml:1:1: a: unknown key; known: dwa, on, name, seed, stamp_ns, fov_deg, "
                  "fov_rad, goal_m, rows, words, several, named, start_m, method",
                  "m.yaml:3:1: a second document; there must be one"));
}

TEST(Fields, GarbageIsRefusedWithoutACrash) {
  const std::string seed_text =
      "dwa: {max_speed_mps: 0.3}\nwords: [a, \"b\"]\nnamed:\n  x: &a {turn_samples: 7}\n  y: *a\n"
      "method: {kind: route, file: f}\n";
  const std::string bytes = "{}[]:,&*!|>'\"%@`#-? \n\t\\~0a\x01\xff<.";
  Rng rng(5);
  int refused = 0;
  for (int i = 0; i < 5000; ++i) {
    std::string text = i % 4 == 0 ? std::string() : seed_text;
    for (int k = rng.index(i % 4 == 0 ? 60 : 4); k >= 0; --k) {
      const auto at = static_cast<std::size_t>(rng.index(static_cast<int>(text.size()) + 1));
      const char c = bytes[static_cast<std::size_t>(rng.index(static_cast<int>(bytes.size())))];
      if (rng.uniform() < 0.5 || at == text.size()) {
        text.insert(at, 1, c);
      } else {
        text[at] = c;
      }
    }
    for (const std::string& line : faults(text)) {
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_FALSE(faults(std::string(100000, '[')).empty());
  EXPECT_FALSE(faults(std::string(100000, '{')).empty());
}

TEST(Fields, AliasesOfAliasesCannotFillTheMemory) {
  std::string text = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string above = "*a" + std::to_string(i - 1);
    text += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + above;
    for (int k = 1; k < 10; ++k) {
      text += ", " + above;
    }
    text += "]\n";
  }
  ASSERT_FALSE(faults(text).empty());
  EXPECT_THAT(faults(text)[0], testing::HasSubstr("too many values for a settings file"));
}

TEST(Fields, OverridesReachEveryValue) {
  const Settings s =
      read("dwa: {horizon_s: 2}\nseveral: [{}, {}]\ngoal_m: [1, 2]\n",
           {"dwa.horizon_s=3", "dwa.turn_samples=9", "several[1].horizon_s=4", "goal_m[0]=5",
            "named.left.horizon_s=6", "words=[a, b]", "seed=1", "seed=2", "start_m=[1, 2, 3]"});
  EXPECT_EQ(s.dwa.horizon_s, 3);
  EXPECT_EQ(s.dwa.turn_samples, 9);
  EXPECT_EQ(s.several.at(1).horizon_s, 4);
  EXPECT_EQ(s.goal, Vec2(5, 2));
  EXPECT_EQ(s.named.at("left").horizon_s, 6);
  EXPECT_THAT(s.words, ElementsAre("a", "b"));
  EXPECT_EQ(s.seed, 2U);
  EXPECT_TRUE(s.start.has_value());
}

struct Kitchen {
  int spoons = 1;
  double span_rad = 1;
};
void bind(Fields& f, Kitchen& o) {
  f("spoons", o.spoons, positive);
  f.angle("span", o.span_rad, positive);
  f.renamed("ladles", "spoons");
  f.renamed("reach_deg", "span_deg");
  f.removed("whisks", "is not set any more: nobody whisks");
}

TEST(Fields, AKeyOfBeforeIsRefusedWithItsNameOfToday) {
  EXPECT_THAT(faults<Kitchen>("ladles: 2\nreach_deg: 3\nladdles: 2\n"),
              ElementsAre("m.yaml:1:1: ladles: ladles is now spoons",
                          "m.yaml:2:1: reach_deg: reach_deg is now span_deg",
                          "m.yaml:3:1: laddles: unknown key; known: spoons, span_deg, span_rad"));
  EXPECT_THAT(faults<Kitchen>("spoons: 3", {"ladles=2"}),
              ElementsAre("--set ladles: ladles is now spoons"));
  EXPECT_EQ(write_settings(Kitchen()), "spoons: 1\nspan_rad: 1\n");
}

TEST(Fields, AKeyThatIsGoneIsRefusedOnceWithTheReason) {
  EXPECT_THAT(faults<Kitchen>("whisks: 2\n"),
              ElementsAre("m.yaml:1:1: whisks: is not set any more: nobody whisks"));
  EXPECT_THAT(faults<Kitchen>("spoons: 3", {"whisks=2"}),
              ElementsAre("--set whisks: is not set any more: nobody whisks"));
}

TEST(Fields, OverridesOnNothingAreRefused) {
  EXPECT_THAT(faults("", {"dwa.horizon=3"}),
              ElementsAre("--set dwa.horizon: unknown key; did you mean horizon_s?"));
  EXPECT_THAT(faults("", {"dwaa.horizon_s=3"}),
              ElementsAre("--set dwaa.horizon_s: dwaa: unknown key; did you mean dwa?"));
  EXPECT_THAT(faults("seed: 3", {"seed.low=3"}),
              ElementsAre("--set seed.low: seed: is a single value; it has no keys inside"));
  EXPECT_THAT(faults("", {"seed.low=3"}),
              ElementsAre("--set seed.low: seed: is a single value; it has no keys inside"));
  EXPECT_THAT(faults("several: [{}]", {"several[3].horizon_s=3"}),
              ElementsAre("--set several[3].horizon_s: several: is a list of 1; an item is named "
                          "[0], [1], ..."));
  EXPECT_THAT(faults("", {"dwa.horizon_s=-3"}),
              ElementsAre("--set dwa.horizon_s: must be from 0.1 to 10, got -3"));
  EXPECT_THAT(faults("", {"dwa.horizon_s"}),
              ElementsAre("--set dwa.horizon_s: must be key.path=value, got dwa.horizon_s"));
  EXPECT_THAT(faults("", {"=3"}),
              ElementsAre("--set =3: names no setting before the =; it must be key.path=value"));
  EXPECT_THAT(faults("", {"dwa.horizon_s={"}),
              ElementsAre("--set dwa.horizon_s: not valid yaml: end of map flow not found"));
}

TEST_F(InAFolder, FilesAreResolvedFirstAndNameTheirOwnFaults) {
  const std::string mission = write("missions/m.yaml", "robot: ../robots/r.yaml\nworld: {}\n");
  const std::string robot = write("robots/r.yaml", "horizon_s: 2\nturn_samples: 5\n");
  EXPECT_EQ(read_settings<Mission>(mission).robot.horizon_s, 2);
  const auto changed = read_settings<Mission>(mission, {"robot.horizon_s=3"});
  EXPECT_EQ(changed.robot.horizon_s, 3);
  EXPECT_EQ(changed.robot.turn_samples, 5);
  write("robots/r.yaml", "horizon_s: 2\nturn_sample: 5\nmax_speed_mps: x\n");
  try {
    read_settings<Mission>(mission);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(
        error.lines(),
        ElementsAre(robot + ":2:1: robot.turn_sample: unknown key; did you mean turn_samples?",
                    robot + ":3:16: robot.max_speed_mps: must be a number, got x"));
  }
}

TEST_F(InAFolder, MissingFilesAreFaultsOfTheOneWhoNamedThem) {
  const std::string mission = write("m.yaml", "robot: nowhere.yaml\nworld: .\nseed: 1\n");
  try {
    read_settings<Mission>(mission);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(
        error.lines(),
        ElementsAre(mission + ":1:8: robot: no such file: " + (folder_ / "nowhere.yaml").string(),
                    mission + ":2:8: world: not a file: " + (folder_ / "").string(),
                    mission + ":3:1: seed: unknown key; known: robot, world, mesh"));
  }
  try {
    read_settings<Mission>((folder_ / "none.yaml").string());
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.what(), (folder_ / "none.yaml").string() + ": no such file");
  }
}

TEST_F(InAFolder, AMissingMeshIsTheUsersFaultAndOneOfOursTheMachines) {
  const std::string mission = write("m.yaml", "mesh: desk.glb\n");
  try {
    read_settings<Mission>(mission);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.what(),
              mission + ":1:7: mesh: no such file: " + (folder_ / "desk.glb").string());
  }
  EXPECT_THROW(read_settings<Mission>(write("n.yaml", "mesh: data:office/dusk.gltf\n")), IoError);
}

TEST_F(InAFolder, TextThatIsNotUtf8IsSaidWithItsPlace) {
  const std::string mission = write("m.yaml", "horizon_s: 2\nmesh: caf\xe9.glb\n");
  for (const auto& read : {std::function<void()>([&] { read_settings<Mission>(mission); }),
                           std::function<void()>([&] { settings_keys(mission); })}) {
    try {
      read();
      FAIL() << "accepted";
    } catch (const ConfigError& error) {
      EXPECT_EQ(error.what(), mission + ":2:10: not UTF-8 text; save it again as UTF-8");
    }
  }
  const std::string good = write("n.yaml", "robot: {horizon_s: 2}\n");
  try {
    read_settings<Mission>(good, {"mesh=caf\xe9.glb"});
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(std::string(error.what()), "--set mesh: not UTF-8 text; save it again as UTF-8");
  }
}

TEST_F(InAFolder, ListsAndMapsOfFilesKnowTheirPlaces) {
  const std::string mesh = write("a/desk.glb", "");
  const std::string file = write(
      "a/m.yaml", "files: [desk.glb, ../a/desk.glb]\npictures:\n  top: desk.glb\n  side: \"\"\n");
  const auto read = read_settings<Place>(file);
  EXPECT_THAT(read.files, ElementsAre(mesh, mesh));
  EXPECT_THAT(read.file_mentions, ElementsAre(file + ":1:9", file + ":1:19"));
  EXPECT_EQ(read.pictures.at("top"), mesh);
  EXPECT_EQ(read.pictures.at("side"), "");
  EXPECT_EQ(read.picture_mentions.at("top"), file + ":3:8");
  const std::string missing = write("a/n.yaml", "files: [desk.glb, disk.glb]\n");
  try {
    read_settings<Place>(missing);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.what(),
              missing + ":1:19: files[1]: no such file: " + (folder_ / "a" / "disk.glb").string());
  }
}

TEST_F(InAFolder, AFileFromElsewhereIsNamedByItsSha256AndMustBeGivenAgain) {
  const std::string mission = write("m.yaml", "world: w.yaml\n");
  const std::string world = write("w.yaml", "horizon_s: 2\n");
  const std::string text = write_settings(read_settings<Mission>(mission));
  EXPECT_THAT(text, testing::HasSubstr("world: \"sha256:"));
  const std::string again = write("again.yaml", text);
  try {
    read_settings<Mission>(again);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.what(),
              again + ":5:8: world: a file from elsewhere; name it with --set world=FILE");
  }
  EXPECT_EQ(read_settings<Mission>(again, {"world=" + world}).world.horizon_s, 2);
  const std::string other = write("other.yaml", "horizon_s: 3\n");
  try {
    read_settings<Mission>(again, {"world=" + other});
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("--set world: not the file of that run"));
  }
}

TEST_F(InAFolder, AFileChangedByHandIsWrittenInline) {
  const std::string mission = write("m.yaml", "world: w.yaml\n");
  write("w.yaml", "horizon_s: 2\n");
  const std::string text = write_settings(read_settings<Mission>(mission, {"world.horizon_s=4"}));
  EXPECT_EQ(read_settings_text<Mission>(text, "again.yaml").world.horizon_s, 4);
}

TEST(Fields, AStarStandsForEveryKeyOfAMapping) {
  const std::string text = "named: {left: {turn_samples: 7}, right: {}}";
  const Settings s = read(text, {"named.*.horizon_s=3", "named.right.horizon_s=4"});
  EXPECT_EQ(s.named.at("left").horizon_s, 3);
  EXPECT_EQ(s.named.at("left").turn_samples, 7);
  EXPECT_EQ(s.named.at("right").horizon_s, 4);  // the later one wins
  EXPECT_EQ(
      read(text, {"named.right.horizon_s=4", "named.*.horizon_s=3"}).named.at("right").horizon_s,
      3);
  EXPECT_EQ(read(text, {"named.*={turn_samples: 9}"}).named.at("left").turn_samples, 9);
  EXPECT_EQ(read("", {"named={left: {}}", "named.*.horizon_s=3"}).named.at("left").horizon_s, 3);

  EXPECT_THAT(faults(text, {"named.*.horizon=3"}),
              ElementsAre("--set named.*.horizon: named.left.horizon: unknown key; did you mean "
                          "horizon_s?",
                          "--set named.*.horizon: named.right.horizon: unknown key; did you mean "
                          "horizon_s?"));
  EXPECT_THAT(faults("", {"named.*.horizon_s=3"}),
              ElementsAre("--set named.*.horizon_s: named: has no keys that * could stand for"));
  EXPECT_THAT(faults("several: [{}]", {"several.*.horizon_s=3"}),
              ElementsAre("--set several.*.horizon_s: several: is a list of 1; an item is named "
                          "[0], [1], ..."));
  EXPECT_THAT(
      faults(text, {"seed.*.horizon_s=3"}),
      ElementsAre("--set seed.*.horizon_s: seed: is a single value; it has no keys inside"));
}

struct Told {
  std::vector<std::string> lines;
  std::vector<std::string> places;
};
void bind(Fields& f, Told& o) { f.texts("lines", o.lines, o.places); }

TEST(Fields, EveryWordOfAListHasItsPlace) {
  const auto told = read_settings_text<Told>("lines:\n  - a=1\n  - b\n", "m.yaml");
  EXPECT_THAT(told.lines, ElementsAre("a=1", "b"));
  EXPECT_THAT(told.places, ElementsAre("m.yaml:2:5", "m.yaml:3:5"));
  EXPECT_EQ(write_settings(told), "lines: [\"a=1\", b]\n");
}

/// A field that keeps beside itself what it was before a `--set`.
struct Kept {
  Dwa robot;
  std::optional<Dwa> robot_before;
};
void bind(Fields& f, Kept& o) {
  f.file_or_inline("robot", o.robot);
  if (Dwa before; f.file_or_inline_before_set("robot", before)) {
    o.robot_before = before;
  }
}

TEST_F(InAFolder, WhatStoodInTheFileBeforeASetCanBeRead) {
  const std::string mission = write("m.yaml", "robot: r.yaml\n");
  write("r.yaml", "horizon_s: 2\n");
  const std::string other = write("other.yaml", "horizon_s: 3\n");
  EXPECT_FALSE(read_settings<Kept>(mission).robot_before.has_value());
  for (const std::string& set :
       std::vector<std::string>{"robot.horizon_s=4", "robot=" + other, "robot={horizon_s: 5}"}) {
    const auto kept = read_settings<Kept>(mission, {set});
    EXPECT_NE(kept.robot.horizon_s, 2) << set;
    ASSERT_TRUE(kept.robot_before.has_value()) << set;
    EXPECT_EQ(kept.robot_before->horizon_s, 2) << set;
  }
  const auto both = read_settings<Kept>(mission, {"robot=" + other, "robot.turn_samples=9"});
  EXPECT_EQ(both.robot.turn_samples, 9);
  EXPECT_EQ(both.robot_before->horizon_s, 2);
  EXPECT_EQ(both.robot_before->turn_samples, 21);
  const auto inlined =
      read_settings_text<Kept>("robot: {horizon_s: 6}", "m.yaml", {"robot.horizon_s=7"});
  EXPECT_EQ(inlined.robot_before->horizon_s, 6);
  EXPECT_FALSE(
      read_settings_text<Kept>("{}", "m.yaml", {"robot.horizon_s=7"}).robot_before.has_value());
}

TEST_F(InAFolder, WhatIsWrongBeforeASetIsSaidOnce) {
  const std::string mission = write("m.yaml", "robot: r.yaml\n");
  const std::string robot = write("r.yaml", "horizon_s: 200\nturn_samples: 4\n");
  try {
    read_settings<Kept>(mission, {"robot.horizon_s=2"});
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.lines(),
                ElementsAre(robot + ":1:12: robot.horizon_s: must be from 0.1 to 10, got 200",
                            robot + ":2:15: robot.turn_samples: must be odd so that straight ahead "
                                    "is tried, got 4"));
  }
}

struct Spread {
  Vec3 size_m = Vec3::Ones();
  Vec3 turn_rad = Vec3::Ones();
};
void bind(Fields& f, Spread& o) {
  f.one_or_each("size_m", o.size_m, positive);
  f.one_angle_or_each("turn", o.turn_rad, between(0, deg_to_rad(90)));
}

TEST(Fields, ThreeNumbersMayBeOneForAll) {
  const auto one = read_settings_text<Spread>("{size_m: 2, turn_deg: 3}", "m.yaml");
  EXPECT_EQ(one.size_m, Vec3(2, 2, 2));
  EXPECT_EQ(one.turn_rad, Vec3::Constant(deg_to_rad(3)));
  const auto each = read_settings_text<Spread>("{size_m: [1, 2, 3], turn_rad: [0, 0.1, 1]}",
                                               "m.yaml", {"size_m[1]=5"});
  EXPECT_EQ(each.size_m, Vec3(1, 5, 3));
  EXPECT_EQ(each.turn_rad, Vec3(0, 0.1, 1));
  EXPECT_EQ(write_settings(each), "size_m: [1, 5, 3]\nturn_rad: [0, 0.1, 1]\n");
  EXPECT_EQ(read_settings_text<Spread>(write_settings(one), "m.yaml").turn_rad, one.turn_rad);
  EXPECT_THAT(faults<Spread>("size_m: [1, 2]\nturn_deg: [1, 91, 2]"),
              ElementsAre("m.yaml:1:9: size_m: must be a list of 3 numbers, got 2",
                          "m.yaml:2:15: turn_deg[1]: must be from 0 to 90, got 91"));
  EXPECT_THAT(faults<Spread>("size_m: -1\nturn_deg: 1\nturn_rad: 1"),
              ElementsAre("m.yaml:1:9: size_m: must be > 0, got -1",
                          "m.yaml:3:11: turn_rad: given twice; turn_deg says it already"));
}

}  // namespace
}  // namespace panoptes
