// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/check.h"

#include <string_view>

namespace panoptes {

void check_failed(const char* condition, const std::string& must, const char* file, int line) {
  std::string_view path(file);
  for (const std::string_view room : {"core/", "hw/", "sim/", "apps/", "tests/"}) {
    if (const auto at = path.rfind(room); at != std::string_view::npos) {
      path.remove_prefix(at);
      break;
    }
  }
  throw CheckError(std::string(path) + ":" + std::to_string(line) + ": " + must + " (" + condition +
                   ")");
}

}  // namespace panoptes
