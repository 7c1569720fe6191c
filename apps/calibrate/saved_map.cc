// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/saved_map.h"

#include <system_error>

#include <nlohmann/json.hpp>

#include "core/camera/lens_parameters.h"
#include "core/config/fields.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

using Json = nlohmann::json;

constexpr const char* kSchema = "panoptes.map/1";

Json to_json(const Pose3& T) {
  const Vec3& t = T.translation;
  const Eigen::Quaterniond& q = T.rotation;
  return {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()};
}

Pose3 to_pose(const Json& numbers) {
  const auto n = numbers.get<std::array<double, 7>>();
  return {Eigen::Quaterniond(n[3], n[4], n[5], n[6]), Vec3(n[0], n[1], n[2])};
}

Json to_json(const MonoMap::Point& point) {
  Json covariance;
  for (int i = 0; i < 9; ++i) {
    covariance.push_back(point.covariance(i / 3, i % 3));
  }
  Json seen;
  for (const MonoMap::Seen& each : point.seen) {
    seen.push_back({each.frame, each.px.x(), each.px.y()});
  }
  const SalientFeature& f = point.feature;
  return {{"number", point.number},
          {"p_map_m", {point.p_map.x(), point.p_map.y(), point.p_map.z()}},
          {"covariance_m2", covariance},
          {"feature", {f.px.x(), f.px.y(), f.size_px, f.angle_rad, f.saliency, f.octave}},
          {"seen", seen}};
}

MonoMap::Point to_point(const Json& from) {
  MonoMap::Point point;
  point.number = from.at("number").get<int>();
  const auto p = from.at("p_map_m").get<std::array<double, 3>>();
  point.p_map = Vec3(p[0], p[1], p[2]);
  const auto covariance = from.at("covariance_m2").get<std::array<double, 9>>();
  for (int i = 0; i < 9; ++i) {
    point.covariance(i / 3, i % 3) = covariance[static_cast<std::size_t>(i)];
  }
  const auto f = from.at("feature").get<std::array<double, 6>>();
  point.feature = {Vec2(f[0], f[1]), f[2], f[3], f[4], static_cast<int>(f[5])};
  for (const Json& each : from.at("seen")) {
    const auto seen = each.get<std::array<double, 3>>();
    point.seen.push_back({static_cast<int>(seen[0]), Vec2(seen[1], seen[2])});
  }
  return point;
}

}  // namespace

void write_map(const std::filesystem::path& path, const std::string& made_of, const MonoMap& map) {
  Json frames;
  for (const MonoMap::Frame& frame : map.frames) {
    frames.push_back({{"stamp_ns", frame.stamp.time_since_epoch().count()},
                      {"T_map_camera", to_json(frame.T_map_camera)},
                      {"lost", frame.lost}});
  }
  Json points;
  for (const MonoMap::Point& point : map.points) {
    points.push_back(to_json(point));
  }
  const Eigen::VectorXd lens = lens_parameters(map.lens);
  Json json{{"schema", kSchema},
            {"made_of", made_of},
            {"lens", std::vector<double>(lens.data(), lens.data() + lens.size())},
            {"normalised_innovation", map.normalised_innovation},
            {"begins_s", map.begins_s},
            {"lost_s", map.lost_s},
            {"start_is_known", map.start_is_known},
            {"closed", map.closed ? Json(*map.closed) : Json()},
            {"frames", frames},
            {"points", points}};
  write_file(path, json.dump() + "\n");
}

std::optional<MonoMap> read_map(const std::filesystem::path& path, const std::string& made_of,
                                const Intrinsics& lens) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return std::nullopt;
  }
  try {
    const Json json = Json::parse(read_file(path));
    if (json.at("schema") != kSchema || json.at("made_of") != made_of) {
      return std::nullopt;
    }
    MonoMap map;
    const auto numbers = json.at("lens").get<std::vector<double>>();
    const Eigen::VectorXd parameters = Eigen::Map<const Eigen::VectorXd>(
        numbers.data(), static_cast<Eigen::Index>(numbers.size()));
    if (parameters.size() != lens_parameters(lens).size()) {
      return std::nullopt;
    }
    map.lens = with_parameters(lens, parameters);
    map.normalised_innovation = json.at("normalised_innovation").get<double>();
    map.begins_s = json.at("begins_s").get<double>();
    map.lost_s = json.at("lost_s").get<double>();
    map.start_is_known = json.at("start_is_known").get<bool>();
    if (!json.at("closed").is_null()) {
      map.closed = json.at("closed").get<std::size_t>();
    }
    for (const Json& frame : json.at("frames")) {
      map.frames.push_back({Time(Duration(frame.at("stamp_ns").get<std::int64_t>())),
                            to_pose(frame.at("T_map_camera")), frame.at("lost").get<bool>()});
    }
    for (const Json& point : json.at("points")) {
      map.points.push_back(to_point(point));
    }
    return map;
  } catch (const Json::exception&) {
    return std::nullopt;  // torn, or of another version: it is made again
  }
}

}  // namespace panoptes
