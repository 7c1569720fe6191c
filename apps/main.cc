// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>  // defines __GLIBC__ where it is the C library

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <glog/logging.h>

#include "apps/run_app.h"

int main(int argc, char** argv) {
  // A step that the solver refuses is followed by a smaller one: nobody need be warned of it.
  FLAGS_minloglevel = google::GLOG_FATAL;
#ifdef __GLIBC__
  // Maps of a whole building are made anew at every plan. Given back to the system each time, their
  // memory comes back page by page, cleared: most of the time that such a plan took.
  constexpr int kKept_bytes = 32 << 20;
  mallopt(M_MMAP_THRESHOLD, kKept_bytes);
  mallopt(M_TRIM_THRESHOLD, 8 * kKept_bytes);
#endif
  return panoptes::run_app(argc, argv);
}
