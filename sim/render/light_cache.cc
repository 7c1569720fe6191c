// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <unistd.h>

#include "sim/render/lightmap.h"

namespace panoptes::sim {
namespace {

constexpr int kBakeVersion = 2;  // a new one for every change of the bake that changes its texels

/// Fowler, Noll and Vo's hash, 64 bits, over 8 bytes at a time.
class Hash {
 public:
  explicit Hash(std::uint64_t start) : state_(14695981039346656037ULL ^ start) {}
  void add(std::uint64_t bits) {
    state_ = (state_ ^ bits) * 1099511628211ULL;
    state_ ^= state_ >> 29;
  }
  void add(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    add(bits);
  }
  template <class Vector>
  void add_all(const Vector& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      add(static_cast<double>(values[i]));
    }
  }
  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_;
};

std::uint64_t content_hash(const World& world, const Charts& charts, std::uint64_t start) {
  Hash hash(start);
  hash.add(static_cast<std::uint64_t>(kBakeVersion));
  hash.add(world.ambient);
  for (const AreaLight& light : world.lights) {
    hash.add_all(light.at_m);
    hash.add_all(light.size_m);
    hash.add_all(light.normal);
    hash.add(light.power);
  }
  hash.add(static_cast<std::uint64_t>(charts.rows));
  for (const Chart& chart : charts.charts) {
    hash.add(static_cast<std::uint64_t>(chart.columns));
    hash.add(static_cast<std::uint64_t>(chart.rows));
    for (const LitTriangle& t : chart.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        hash.add_all(t.p_scene[i]);
        hash.add_all(t.texel[i]);
      }
    }
  }
  return hash.value();
}

std::filesystem::path cache_folder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache == '/') {
    return std::filesystem::path(cache) / "panoptes";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home == '/') {
    return std::filesystem::path(home) / ".cache" / "panoptes";
  }
  return {};
}

/// Written under another name first, so that nobody ever reads half of it. A cache that cannot be
/// written costs time, nothing else.
void keep(const std::filesystem::path& file, const cv::Mat& texels) {
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  std::vector<std::uint8_t> png;
  if (error || !cv::imencode(".png", texels, png)) {
    return;
  }
  const std::filesystem::path unfinished = fmt::format("{}.{}.tmp", file.string(), ::getpid());
  {
    std::ofstream out(unfinished, std::ios::binary);
    out.write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    out.close();
    if (out) {
      std::filesystem::rename(unfinished, file, error);
      if (!error) {
        return;
      }
    }
  }
  std::filesystem::remove(unfinished, error);
}

}  // namespace

cv::Mat cached_light(const World& world, const Charts& charts, int num_threads) {
  const std::filesystem::path folder = cache_folder();
  if (folder.empty()) {
    return bake_light(world, charts, num_threads);
  }
  const std::filesystem::path file =
      folder / fmt::format("light-{:016x}{:016x}.png", content_hash(world, charts, 0),
                           content_hash(world, charts, 1));
  std::error_code error;
  if (std::filesystem::is_regular_file(file, error)) {
    cv::Mat texels = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
    if (texels.type() == CV_8U && texels.cols == charts.columns && texels.rows == charts.rows) {
      return texels;
    }
  }
  cv::Mat texels = bake_light(world, charts, num_threads);
  keep(file, texels);
  return texels;
}

}  // namespace panoptes::sim
