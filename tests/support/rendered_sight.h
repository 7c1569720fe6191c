// SPDX-License-Identifier: BSD-3-Clause
// What a rig sees of a bare floor past its own robot, by the pictures that `panoptes render
// --labels --depth` draws of it, to hold the geometric scores against. Where the floor lies is
// taken from the pictures' labels and depths, pixel by pixel; nothing is projected.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/camera/rig.h"
#include "core/geometry/body.h"

namespace panoptes::test {

/// One to four cameras, the first of them for the floor, pinholes and lenses that bend, mounted
/// anywhere on the body and looking anywhere that is not the sky; drawn again until it has no
/// placement_faults.
Rig random_rig(Rng& rng, const Body& body);

/// Writes what `panoptes render FOLDER/mission.yaml --pose 0,0,0 --labels --depth` needs: a large
/// floor, the robot's hull standing on it, the rig.
void write_bare_floor(const std::filesystem::path& folder, const Rig& rig, const Body& body);

/// One number, by the scores and by the pictures.
struct SightComparison {
  std::string what;
  double scored = 0;
  double rendered = 0;
  double pixel = 0;  ///< what one pixel more or less would make, where that counts; else 0
  double error() const { return scored / rendered - 1; }
};

/// Of every camera floor seen (m2, within 4.5 m), of pinholes for the floor that mapped, and where
/// they are seen the first floor straight ahead and the ground sampling distances at half a metre
/// to 3 m from the body.
/// `pictures` is the folder that they were rendered to.
std::vector<SightComparison> compare_sight(const std::filesystem::path& pictures, const Rig& rig,
                                           const Body& body);

}  // namespace panoptes::test
