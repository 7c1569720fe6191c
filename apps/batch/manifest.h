// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/batch/plan.h"

namespace panoptes {

/// What runs are to be made, for whoever makes some of them: a line of JSON that says what was
/// asked for and of which program, a line a point (its settings, its files with their SHA-256),
/// and a line a run (its point, its seed, the SHA-256 of its settings).
struct Manifest {
  std::string asked;         ///< missions, study, seeds, settings, as JSON
  std::string study_file;    ///< empty: none
  std::string study_sha256;  ///< of the file then
  std::vector<Vary> vary;
  std::vector<std::string> varied;  ///< see varied()
  Keep keep = Keep::kAll;
  std::string version;
  std::string program_sha256;
  std::filesystem::path working_folder;  ///< that relative files are meant from
  std::vector<Trial> trials;
};

std::filesystem::path manifest_file(const std::filesystem::path& out_dir);

/// Whole, or not at all; whoever plans the same at once writes the same.
void write_manifest(const TrialsOptions& options, const std::string& program_sha256,
                    const std::vector<Trial>& trials);

/// Its study is not read again. Throws ConfigError where the file is none, or of another form.
Manifest read_manifest(const std::filesystem::path& out_dir);

/// That a manifest is of what these options ask for. Throws ConfigError.
void check_asked_for(const Manifest& manifest, const TrialsOptions& options);

/// That the runs of a manifest that is there are among these. Throws ConfigError.
void check_holds_no_others(const TrialsOptions& options, const std::vector<Trial>& trials);

}  // namespace panoptes
