// SPDX-License-Identifier: BSD-3-Clause
#include "apps/command/command.h"

#include <charconv>
#include <limits>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "sim/render/renderer.h"

namespace panoptes {

std::vector<std::string> CommonArguments::overrides() const {
  std::vector<std::string> all = set;
  if (seed) {
    all.push_back(fmt::format("seed={}", *seed));
  }
  if (duration_s) {
    all.push_back(fmt::format("until.duration_s={}", *duration_s));
  }
  return all;
}

namespace {

// What is no number at all is left to be told by the conversion.
std::string seed_fault(const std::string& seed) {
  if (seed.starts_with('-')) {
    return "must not be negative, got " + seed;
  }
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(seed.data(), seed.data() + seed.size(), value);
  return error == std::errc::result_out_of_range
             ? fmt::format("must be at most {}, got {}", std::numeric_limits<std::uint64_t>::max(),
                           seed)
             : "";
}

}  // namespace

void add_overrides(CLI::App& subcommand, CommonArguments& args) {
  subcommand.add_option("--seed", args.seed, "of every random choice")
      ->type_name("N")
      ->check(seed_fault);
  subcommand.add_option("--duration", args.duration_s, "at most so long, in seconds of the run")
      ->type_name("S");
  subcommand
      .add_option("--set", args.set,
                  "a setting of the mission, e.g. navigator.localiser.keyframe.distance_m=0.3")
      ->type_name("KEY.PATH=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_common(CLI::App& subcommand, CommonArguments& args) {
  subcommand.add_option("--out", args.out_dir, "where the results go (runs/<mission>-<seed>)")
      ->type_name("DIR")
      ->check([](const std::string& folder) {
        return folder.empty() ? "must name a folder" : std::string();
      });
  add_overrides(subcommand, args);
  subcommand.add_option("--threads", args.threads, "that draw (1 or 2, as there are cores)")
      ->type_name("N")
      ->check(CLI::Range(1, 64))
      ->each([](const std::string& count) { sim::set_render_threads(std::stoi(count)); });
  subcommand.add_flag("--quiet", args.quiet, "no progress");
}

}  // namespace panoptes
