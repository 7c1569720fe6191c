// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/process.h"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <string_view>
#include <thread>

#include <opencv2/core/utility.hpp>

#include "sim/render/renderer.h"

namespace panoptes {

void set_up_process() {
  std::signal(SIGXFSZ, SIG_IGN);  // the write fails instead
  std::signal(SIGPIPE, SIG_IGN);  // likewise: a reader that left ends no run
  cv::setNumThreads(1);
  // More than two threads gain nothing on pictures as small as ours.
  constexpr unsigned kUseful = 2;
  sim::set_render_threads(
      static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, kUseful)));
  if (const char* wanted = std::getenv("PANOPTES_REPRODUCIBLE");
      wanted != nullptr && std::string_view(wanted) == "1") {
    sim::set_same_on_every_processor();
  }
}

}  // namespace panoptes
