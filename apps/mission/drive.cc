// SPDX-License-Identifier: BSD-3-Clause
#include "apps/mission/drive.h"

namespace panoptes {

template <>
void bind(Fields& f, Drive<"route">& o) {
  f.require(f.writing() || f.present("file"), "file", "missing; it must name a file of waypoints");
  f.file_or_inline("file", o.route);
}

}  // namespace panoptes
