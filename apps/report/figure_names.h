// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/eval/requirement.h"

namespace panoptes {

/// Every figure that a run may write in metrics.json, by its dotted path; `*` stands for one name
/// that the run itself gives (a camera, a device, a setting of the study of recognition). A test
/// holds it against what runs write.
const std::vector<std::string>& figure_names();

bool is_figure(const std::string& path);

/// The same of what a rig's calibration writes there.
bool is_calibration_figure(const std::string& path);

/// Whether a figure is one of those that a pattern stands for, in which `*` is one name.
bool is_one_of(std::string_view path, std::string_view pattern);

/// What it cost: the figures that two runs of one seed may differ in.
bool is_cost(const std::string& path);

/// What is wrong with what a line requires: no run with these cameras can have such a figure, no
/// such word, or no number where one is. Empty when nothing is.
std::string requirement_fault(const Requirement& requirement,
                              const std::vector<std::string>& cameras);

}  // namespace panoptes
