// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/error.h"

#include <utility>

#include "core/base/text.h"

namespace panoptes {

ConfigError::ConfigError(std::string line) : ConfigError(std::vector{std::move(line)}) {}

ConfigError::ConfigError(std::vector<std::string> lines)
    : std::runtime_error(joined(lines, "\n")), lines_(std::move(lines)) {}

}  // namespace panoptes
