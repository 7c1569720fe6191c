// SPDX-License-Identifier: BSD-3-Clause
// The geometric scores of random rigs against what `panoptes render --labels --depth` draws of
// them over a bare floor:
//   place_study [--rigs N] [--seed K] [--out FOLDER]
// Every number of every rig that is off by more than 5 % and by more than a pixel is told, and of
// all of them how far they are off. Exit status 1 where one is. Rigs and pictures stay in FOLDER.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "apps/run_app.h"
#include "core/eval/statistics.h"
#include "tests/support/rendered_sight.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

bool render(const fs::path& folder) {
  const std::string mission = (folder / "mission.yaml").string();
  const std::string out = (folder / "render").string();
  const char* words[] = {"panoptes", "render",  mission.c_str(), "--pose", "0,0,0",
                         "--labels", "--depth", "--quiet",       "--out",  out.c_str()};
  return run_app(static_cast<int>(std::size(words)), words) == 0;
}

int study(int rigs, std::uint64_t seed, const fs::path& out) {
  constexpr double kWithin = 0.05;
  const Body body;
  std::map<std::string, std::vector<double>> errors;  // of each kind of number
  int off = 0;
  int by_a_pixel = 0;  // of a blind distance of next to nothing
  for (int i = 0; i < rigs; ++i) {
    Rng rng = Rng(seed).fork(fmt::format("rig {}", i));
    const Rig rig = test::random_rig(rng, body);
    const fs::path folder = out / fmt::format("rig-{}", i);
    test::write_bare_floor(folder, rig, body);
    if (!render(folder)) {
      return 3;
    }
    for (const test::SightComparison& one : test::compare_sight(folder / "render", rig, body)) {
      const bool beyond = std::abs(one.error()) > kWithin;
      const bool wrong = beyond && std::abs(one.scored - one.rendered) > one.pixel;
      by_a_pixel += beyond && !wrong ? 1 : 0;
      errors[one.what.substr(one.what.find(' ') + 1)].push_back(std::abs(one.error()));
      off += wrong ? 1 : 0;
      if (wrong) {
        fmt::print("rig {}: {}: scored {:.4f}, rendered {:.4f} ({:+.1f} %)\n", i, one.what,
                   one.scored, one.rendered, 100 * one.error());
      }
    }
  }
  for (const auto& [what, all] : errors) {
    fmt::print("{:<24} {:4} numbers, off by {:.2f} % (median), {:.2f} % (p90), {:.2f} % (most)\n",
               what, all.size(), 100 * quantile(all, 0.5), 100 * quantile(all, 0.9),
               100 * *std::max_element(all.begin(), all.end()));
  }
  fmt::print(
      "{} numbers of {} rigs off by more than {:.0f} % and a pixel, {} by more than {:.0f} % "
      "and no more than a pixel\n",
      off, rigs, 100 * kWithin, by_a_pixel, 100 * kWithin);
  return off == 0 ? 0 : 1;
}

}  // namespace
}  // namespace panoptes

int main(int argc, char** argv) {
  int rigs = 50;
  std::uint64_t seed = 1;
  std::filesystem::path out = "place-study";
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string word = argv[i];
    if (word == "--rigs") {
      rigs = std::atoi(argv[i + 1]);
    } else if (word == "--seed") {
      seed = std::strtoull(argv[i + 1], nullptr, 10);
    } else if (word == "--out") {
      out = argv[i + 1];
    }
  }
  return panoptes::study(rigs, seed, out);
}
