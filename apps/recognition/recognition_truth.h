// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/eval/recognition.h"

namespace panoptes {

/// Which pictures truly show one place, from a table of `picture,earlier` (names of the pictures'
/// files, or numbers from 0) or from a picture with a pixel for each pair: white for one place,
/// black for two, greys between are not counted. Throws ConfigError with the file, the line and
/// the cure.
PlaceTruth read_recognition_truth(const std::string& file,
                                  const std::vector<std::string>& pictures);

}  // namespace panoptes
