// SPDX-License-Identifier: BSD-3-Clause
#include "apps/command/out_file.h"

#include <system_error>

#include "core/base/error.h"
#include "core/io/file.h"

namespace panoptes {

void check_out_file(const std::string& flag, const std::filesystem::path& file) {
  std::string fault;
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) {
    fault = file.string() + ": is a folder";
  } else {
    try {
      const AtomicFile probe(file);
    } catch (const IoError& error) {
      fault = error.what();
    }
  }
  if (!fault.empty()) {
    throw ConfigError(flag + " " + fault + "; name another file");
  }
}

}  // namespace panoptes
