// SPDX-License-Identifier: BSD-3-Clause
// The folder of keyframes of a run.
#include <string>
#include <vector>

#include "core/io/keyframe_files.h"
#include "tests/fuzz/fuzz.h"

namespace panoptes::fuzz {

std::vector<std::string> words() {
  return {"=== keyframes.csv\n",
          "=== signatures.bin\n",
          "=== features.bin\n",
          "=== maps.bin\n",
          ",",
          "\n",
          ",grid,",
          ",mosaic,",
          ",240,",
          ",-1,",
          ",0,",
          "1e9",
          "1e-9",
          "nan",
          "2147483648",
          std::string("\x80\x3f", 2),
          std::string("\xc0\x7f", 2),
          "\x89PNG\r\n\x1a\n",
          "IHDR",
          "IDAT",
          "IEND"};
}

void read_input(std::string_view bytes) {
  std::map<std::string, std::string> files = files_in(bytes);
  for (auto& [name, content] : files) {
    if (name != "keyframes.csv" && !content.empty()) {
      content.pop_back();  // the end of line before the next name
    }
  }
  parse_keyframes("keyframes", {files["keyframes.csv"], files["signatures.bin"],
                                files["features.bin"], files["maps.bin"]});
}

}  // namespace panoptes::fuzz
