// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/dataset_gaps.h"

#include "core/io/dataset_rows.h"

namespace panoptes {
namespace {

std::vector<const RecordedPicture*> pictures_of(const Dataset& dataset, const std::string& camera) {
  std::vector<const RecordedPicture*> pictures;
  for (const RecordedObservation& seen : dataset.observations) {
    const auto found = seen.pictures.find(camera);
    if (found != seen.pictures.end()) {
      pictures.push_back(&found->second);
    }
  }
  return pictures;
}

Regularity rate_of(const Dataset& dataset, const std::vector<const RecordedPicture*>& pictures) {
  std::vector<Time> stamps;
  for (const RecordedPicture* picture : pictures) {
    stamps.push_back(picture->stamp);
  }
  return regularity(stamps, dataset.observations.front().stamp, dataset.observations.back().stamp);
}

}  // namespace

std::map<std::string, Regularity> picture_rates(const Dataset& dataset, const Rig& rig) {
  std::map<std::string, Regularity> rates;
  for (const auto& [name, camera] : rig.cameras) {
    rates[name] = rate_of(dataset, pictures_of(dataset, name));
  }
  return rates;
}

std::vector<std::string> gap_lines(const Dataset& dataset, const Rig& rig) {
  std::vector<std::string> lines;
  for (const auto& [name, camera] : rig.cameras) {
    const std::vector<const RecordedPicture*> pictures = pictures_of(dataset, name);
    const std::string file = in_folder(dataset.folder, data_csv(name));
    if (pictures.size() < 2) {
      lines.push_back(file + ": names " + (pictures.empty() ? "no picture" : "one picture alone"));
      continue;
    }
    const Regularity rate = rate_of(dataset, pictures);
    for (const Gap& gap : rate.gaps) {
      lines.push_back((gap.next < pictures.size() ? pictures[gap.next]->mention : file) + ": " +
                      spelt(gap, rate, "picture"));
    }
  }
  if (!dataset.odometry_rows.empty()) {
    const Regularity rate = regularity(dataset.odometry_rows, dataset.odometry_rows.front(),
                                       dataset.odometry_rows.back());
    for (const Gap& gap : rate.gaps) {
      lines.push_back(in_folder(dataset.folder, kOdometryFile) + ": " + spelt(gap, rate, "row"));
    }
  }
  return lines;
}

}  // namespace panoptes
