// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "sim/render/lightmap.h"

namespace panoptes::sim {
namespace {

namespace fs = std::filesystem;

constexpr int kBakeVersion = 3;  // a new one for every change of the bake that changes its texels
constexpr std::uintmax_t kMostKept_bytes = 512U << 20U;

/// Fowler, Noll and Vo's hash, 64 bits, over 8 bytes at a time.
class Hash {
 public:
  explicit Hash(std::uint64_t start) : state_(14695981039346656037ULL ^ start) {}
  void add(std::uint64_t bits) {
    state_ = (state_ ^ bits) * 1099511628211ULL;
    state_ ^= state_ >> 29U;
  }
  void add(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    add(bits);
  }
  void add(const std::string& text) {
    add(static_cast<std::uint64_t>(text.size()));
    add_bytes(text.data(), text.size());
  }
  void add_bytes(const char* bytes, std::size_t count) {
    for (std::size_t i = 0; i < count; i += 8) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, bytes + i, std::min<std::size_t>(8, count - i));
      add(bits);
    }
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
  hash.add(world.ambient_group);
  for (const AreaLight& light : world.lights) {
    hash.add_all(light.at_m);
    hash.add_all(light.size_m);
    hash.add_all(light.normal);
    hash.add(light.power);
    hash.add(light.group);
  }
  if (world.sun) {
    hash.add_all(world.sun->from);
    hash.add(world.sun->power);
    hash.add(world.sun->group);
  }
  hash.add(static_cast<std::uint64_t>(charts.columns));
  hash.add(static_cast<std::uint64_t>(charts.rows));
  for (const Chart& chart : charts.charts) {
    hash.add(static_cast<std::uint64_t>(chart.object));
    hash.add(static_cast<std::uint64_t>(chart.moves));
    hash.add(static_cast<std::uint64_t>(chart.columns));
    hash.add(static_cast<std::uint64_t>(chart.rows));
    if (chart.moves) {
      const Pose3& T_scene_object = world.objects[chart.object].T_scene_object;
      hash.add_all(T_scene_object.rotation.coeffs());
      hash.add_all(T_scene_object.translation);
    }
    for (const LitTriangle& t : chart.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        hash.add_all(t.p[i]);
        hash.add_all(t.texel[i]);
      }
    }
  }
  return hash.value();
}

fs::path cache_folder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache == '/') {
    return fs::path(cache) / "panoptes";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home == '/') {
    return fs::path(home) / ".cache" / "panoptes";
  }
  return {};
}

/// The texels and probes of a bake, one after another; the rest follows from world and charts.
std::string packed(const BakedLight& light) {
  std::string bytes;
  for (const cv::Mat& layer : light.layers) {
    for (int row = 0; row < layer.rows; ++row) {
      bytes.append(layer.ptr<char>(row), static_cast<std::size_t>(layer.cols));
    }
  }
  const auto put = [&bytes](const void* values, std::size_t count) {
    bytes.append(static_cast<const char*>(values), count);
  };
  put(light.probes.low_scene.data(), 3 * sizeof(double));
  put(light.probes.spacing_m.data(), 3 * sizeof(double));
  put(light.probes.counts.data(), sizeof light.probes.counts);
  for (const std::vector<Probes::Cube>& cubes : light.probes.groups) {
    put(cubes.data(), cubes.size() * sizeof(Probes::Cube));
  }
  return bytes;
}

std::uint64_t checksum(const std::string& bytes) {
  Hash hash(2);
  hash.add_bytes(bytes.data(), bytes.size());
  return hash.value();
}

/// What was packed; nothing when it is not whole.
std::optional<BakedLight> unpacked(const std::string& bytes, const Charts& charts,
                                   std::vector<std::string> groups) {
  std::size_t at = 0;
  const auto take = [&](void* values, std::size_t count) {
    if (bytes.size() - at < count) {
      return false;
    }
    std::memcpy(values, bytes.data() + at, count);
    at += count;
    return true;
  };
  BakedLight light{std::move(groups), {}, {}};
  const int rows = std::max(charts.rows, 1);
  for (std::size_t g = 0; g < light.groups.size(); ++g) {
    cv::Mat layer(rows, charts.columns, CV_8U);
    if (!take(layer.data, layer.total())) {
      return std::nullopt;
    }
    light.layers.push_back(layer);
  }
  Probes& probes = light.probes;
  if (!take(probes.low_scene.data(), 3 * sizeof(double)) ||
      !take(probes.spacing_m.data(), 3 * sizeof(double)) ||
      !take(probes.counts.data(), sizeof probes.counts) ||
      bytes.size() - at != light.groups.size() * probes.size() * sizeof(Probes::Cube)) {
    return std::nullopt;
  }
  for (std::size_t g = 0; g < light.groups.size(); ++g) {
    probes.groups.emplace_back(probes.size());
    take(probes.groups.back().data(), probes.size() * sizeof(Probes::Cube));
  }
  return light;
}

std::optional<std::string> read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::uint64_t sum = 0;
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (!in || error || size < sizeof sum) {
    return std::nullopt;
  }
  std::string bytes(size - sizeof sum, '\0');
  in.read(reinterpret_cast<char*>(&sum), sizeof sum);
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return in && sum == checksum(bytes) ? std::optional(std::move(bytes)) : std::nullopt;
}

/// The oldest bakes give way when there are too many.
void tidy(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::uintmax_t bytes = 0;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::uintmax_t size = entry.file_size(error);
    if (!error && entry.path().filename().string().rfind("light-", 0) == 0) {
      files.emplace_back(entry.last_write_time(error), entry.path());
      bytes += size;
    }
  }
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i + 1 < files.size() && bytes > kMostKept_bytes; ++i) {
    bytes -= fs::file_size(files[i].second, error);
    fs::remove(files[i].second, error);
  }
}

/// Written under another name first, so that nobody ever reads half of it. A cache that cannot be
/// written costs time, nothing else.
void keep(const fs::path& file, const BakedLight& light) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) {
    return;
  }
  const std::string bytes = packed(light);
  const std::uint64_t sum = checksum(bytes);
  const fs::path unfinished = fmt::format("{}.{}.tmp", file.string(), ::getpid());
  {
    std::ofstream out(unfinished, std::ios::binary);
    out.write(reinterpret_cast<const char*>(&sum), sizeof sum);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (out) {
      fs::rename(unfinished, file, error);
      if (!error) {
        tidy(file.parent_path());
        return;
      }
    }
  }
  fs::remove(unfinished, error);
}

}  // namespace

BakedLight cached_light(const World& world, const Charts& charts, int num_threads,
                        const BakeProgress& progress) {
  const fs::path folder = cache_folder();
  if (folder.empty()) {
    return bake_light(world, charts, num_threads, progress);
  }
  const fs::path file =
      folder / fmt::format("light-{:016x}{:016x}.bake", content_hash(world, charts, 0),
                           content_hash(world, charts, 1));
  if (const std::optional<std::string> bytes = read(file)) {
    if (std::optional<BakedLight> light = unpacked(*bytes, charts, light_groups(world))) {
      return std::move(*light);
    }
  }
  BakedLight light = bake_light(world, charts, num_threads, progress);
  keep(file, light);
  return light;
}

}  // namespace panoptes::sim
