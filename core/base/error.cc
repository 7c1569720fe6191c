// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/error.h"

#include <utility>

namespace panoptes {
namespace {

std::string joined(const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) {
    all += (all.empty() ? "" : "\n") + line;
  }
  return all;
}

}  // namespace

ConfigError::ConfigError(std::string line) : ConfigError(std::vector{std::move(line)}) {}

ConfigError::ConfigError(std::vector<std::string> lines)
    : std::runtime_error(joined(lines)), lines_(std::move(lines)) {}

}  // namespace panoptes
