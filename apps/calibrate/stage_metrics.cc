// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/stage_metrics.h"

#include <nlohmann/json.hpp>

#include "apps/process/stage_clock.h"
#include "core/base/utf8.h"
#include "core/io/dataset_rows.h"
#include "core/io/file.h"

namespace panoptes {

void write_metrics(const std::filesystem::path& folder, nlohmann::ordered_json figures,
                   Faults& faults) {
  if (!faults.none()) {
    figures["fault"] = as_utf8(faults.text());
  }
  const ProcessUse use = process_use();
  figures["wall_s"] = use.wall_s;
  figures["cpu_s"] = use.cpu_s;
  figures["peak_memory_mb"] = use.peak_memory_mb;
  faults.attempt([&] { write_file(folder / "metrics.json", figures.dump(2) + "\n"); });
}

std::optional<std::string> told_in_metrics(const std::filesystem::path& folder,
                                           const std::string& key) {
  const auto metrics =
      nlohmann::json::parse(read_part(folder / "metrics.json").value_or(""), nullptr, false);
  const auto found = metrics.is_object() ? metrics.find(key) : metrics.end();
  return metrics.is_object() && found != metrics.end() && found->is_string()
             ? std::optional(found->get<std::string>())
             : std::nullopt;
}

}  // namespace panoptes
