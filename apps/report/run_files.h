// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/process/fault.h"
#include "apps/report/finished_run.h"
#include "apps/report/run_figures.h"

namespace panoptes {

/// The rig as the run has come to know it, a rig file as any other.
inline constexpr std::string_view kRefinedRig = "rig_refined.yaml";

/// The files of a run directory but for mission.yaml, steps.csv, keyframes and metrics.json, small
/// ones first. One that cannot be written keeps no other from being tried.
void write_run_files(const std::filesystem::path& out_dir, const FinishedRun& run,
                     const RunFindings& findings, Faults& faults);

/// Those of them that hold the truth; without truth there are none.
void write_ground_truth(const std::filesystem::path& out_dir, const RunFindings& findings);
/// What was touched, where in `map` and when; without a truth that knows it none is left there.
void write_contacts(const std::filesystem::path& out_dir, const FinishedRun& run,
                    const RunFindings& findings);
void write_exploration(const std::filesystem::path& out_dir, const RunFindings& findings);

/// What loops.csv holds of the truth: the relative pose, and whether the claimed one is right.
inline constexpr std::array<std::string_view, 4> kTrueLoopColumns = {"true_x_m", "true_y_m",
                                                                     "true_theta_deg", "correct"};
std::array<std::string, kTrueLoopColumns.size()> true_loop_fields(const RunFindings& findings,
                                                                  const ClosureReport& closure);

/// Draws the map, the places of a study where there are any, the coverage over time and, with
/// truth, the errors over time; returns the pictures' files. From when `hurried` says so there are
/// no more of them.
std::vector<std::filesystem::path> draw_run(const std::filesystem::path& out_dir,
                                            const FinishedRun& run, const RunFindings& findings,
                                            const std::vector<RecognitionRow>& places,
                                            Faults& faults,
                                            const std::function<bool()>& hurried = {});

}  // namespace panoptes
