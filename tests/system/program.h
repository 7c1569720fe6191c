// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/support/said.h"
#include "tests/support/scratch.h"

namespace panoptes {

/// What happens to the program while it runs.
struct Fate {
  std::map<std::string, std::string> environment;   ///< besides the usual
  std::optional<std::uint64_t> largest_file_bytes;  ///< as a full disk
  int signal = 0;                                   ///< sent as soon as
  std::filesystem::path signal_when;                ///< is there
  int terminal = -1;                                ///< its stdin and stderr; else stdin is empty
  std::string script{};  ///< of bash, that becomes the program: `...; exec "$0" "$@"`
  std::string program = PANOPTES_PROGRAM;  ///< or another one
  std::string out{};                       ///< where its stdout goes, else it is kept
};

/// A test of the program in a folder of its own, which is the program's working directory. The
/// baked light is kept between tests.
class SystemTest : public ScratchTest {
 protected:
  Said panoptes(const std::vector<std::string>& words, const Fate& fate = {}) const;

  /// `explore` of the mission, without progress; `out` is a folder in this test's.
  Said explore(const std::string& mission, const std::string& out,
               const std::vector<std::string>& more, const Fate& fate = {}) const;

  nlohmann::json metrics(const std::string& out) const;
  std::string write(const std::string& name, const std::string& text) const;
};

inline const std::string kScenes = PANOPTES_SOURCE_DIR "/scenes/";
inline const std::string kOffice = kScenes + "missions/explore-office.yaml";

/// Every file of a run's folder by name; metrics.json without what may differ between two runs of
/// one seed.
std::map<std::string, std::string> comparable(const std::filesystem::path& run);

}  // namespace panoptes
