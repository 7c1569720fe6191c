// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/config/geometry_fields.h"
#include "sim/world/boxes.h"
#include "sim/world/load.h"

namespace panoptes::sim {
namespace {

// Beyond what a run can last; far below what a Time can hold.
constexpr double kLongest_s = 1e9;

// A lamp of this power lights a surface white from 30 m.
constexpr double kBrightest = 1000;
// Times what the lamps of a group have. Light is kept in steps of 1/65000 of the brightest that an
// event makes it: beyond this what is lit as rooms are would be black.
constexpr double kMostRaised = 100;
// Thinner than the finest detail of a picture: corners of an object this close count as one.
constexpr double kThinnest_m = 1e-3;

const Rule in_reach = [](double value) {
  return std::abs(value) <= kFarthest_m
             ? std::string()
             : fmt::format(
                   "must be within {} m of the origin, for farther out pictures are drawn "
                   "too coarsely; move the world there",
                   kFarthest_m);
};
const Rule light = [](double value) {
  return value >= 0 && value <= kBrightest
             ? std::string()
             : fmt::format("must be from 0 to {}, where 1 lights a white surface white",
                           kBrightest);
};
const Rule length = [](double value) {
  return value >= kThinnest_m && value <= kFarthest_m
             ? std::string()
             : fmt::format("must be from {} to {} metres", kThinnest_m, kFarthest_m);
};

bool is_direction(const Vec3& v) {
  constexpr double kShortest = 1e-6;
  constexpr double kLongest = 1e6;
  return v.stableNorm() >= kShortest && v.stableNorm() <= kLongest;
}

/// What a fault about an object as a whole points at.
std::string mention_of(const Fields& f) { return f.present("name") ? f.where("name") : f.here(); }

}  // namespace

void bind(Fields& f, AreaLight& o) {
  f.needed("at_m", o.at_m, in_reach);
  f("size_m", o.size_m, length);
  f("normal", o.normal);
  f.require(is_direction(o.normal), "normal",
            "must be from 1e-6 to 1e6 long: it is where the light shines to");
  f("power", o.power, light);
  f("group", o.group);
}

void bind(Fields& f, Sun& o) {
  f.needed("from", o.from);
  f.require(is_direction(o.from), "from",
            "must be from 1e-6 to 1e6 long: it is the direction to the sun");
  f("power", o.power, light);
  f("group", o.group);
}

void bind(Fields& f, ObjectSettings& o) {
  f("name", o.name);
  o.mention = mention_of(f);
  f.require(f.present("mesh"), "mesh", "missing; it must be given");
  f.path("mesh", o.mesh);
  o.mesh_mention = f.where("mesh");
  f("scale", o.scale, positive);
  f.word("up", o.up, {{"usual", Up::kUsual}, {"y", Up::kY}, {"z", Up::kZ}});
  f("at", o.at);
  f("z_m", o.z_m, in_reach);
  f("movable", o.movable);
  f.paths("textures", o.textures, o.texture_mentions);
}

void bind(Fields& f, BoxSettings& o) {
  f("name", o.name);
  o.mention = mention_of(f);
  f.require(f.present("size_m"), "size_m", "missing; it must be given");
  f("size_m", o.size_m, length);
  f("at", o.at);
  f("hinge_m", o.hinge_m, in_reach);
  f("z_m", o.z_m, in_reach);
  f("movable", o.movable);
  f.path("picture", o.picture);
  o.picture_mention = f.where("picture");
  f.paths("faces", o.faces, o.face_mentions);
  for (const auto& [face, picture] : o.faces) {
    f.require(std::find(kFaceNames.begin(), kFaceNames.end(), face) != kFaceNames.end(), "faces",
              "must name front, back, left, right, top or bottom, got " + face);
  }
  f("picture_m", o.picture_m, not_negative);
  f.require(o.picture_m.maxCoeff() == 0 || o.picture_m.minCoeff() >= kThinnest_m, "picture_m",
            "must be at least 0.001 metres both ways, or [0, 0] for once over each face");
}

void bind(Fields& f, EventSettings& o) {
  o.mention = f.here();
  f.needed("at_s", o.at_s);
  f.require(o.at_s >= 0 && o.at_s <= kLongest_s, "at_s", "must be from 0 to 1e9");
  f("over_s", o.over_s, between(0, kLongest_s));
  const auto one_of = [&f](const char* key, std::string& value) {
    if (!f.writing() || !value.empty()) {
      f(key, value);
    }
    return value.empty() ? 0 : 1;
  };
  const int said = one_of("lights", o.lights) + one_of("move", o.move) + one_of("open", o.open);
  f.require(said == 1, "lights", "exactly one of lights, move and open must be given");
  if (!f.writing() || !o.lights.empty()) {
    f("power", o.power, between(0, kMostRaised));
  }
  if (!f.writing() || !o.move.empty()) {
    f("to", o.to);
  }
  if (!f.writing() || !o.open.empty()) {
    f.angle("angle", o.angle_rad);
  }
  f.require(!f.present("power") || !o.lights.empty(), "power", "goes with lights alone");
  f.require(!f.present("to") || !o.move.empty(), "to", "goes with move alone");
  f.require(o.move.empty() || f.present("to"), "to", "missing; it is where the thing goes");
  const std::string too_far = in_reach(o.to.position().cwiseAbs().maxCoeff());
  f.require(too_far.empty(), "to", too_far);
}

void bind(Fields& f, PersonSettings& o) {
  f("name", o.name);
  o.mention = mention_of(f);
  f.path("mesh", o.mesh);
  o.mesh_mention = f.present("mesh") ? f.where("mesh") : o.mention;
  f.needed("path", o.path, in_reach);
  o.path_mention = f.where("path");
  f.require(o.path.size() >= 2, "path", "must be a list of two points or more");
  f("speed_mps", o.speed_mps, between(0.01, 10));
  f("start_s", o.start_s, between(0, kLongest_s));
  f("returns", o.returns);
  f("waits_m", o.waits_m, not_negative);
  f("turns_back_s", o.turns_back_s, positive);
}

void bind(Fields& f, FloorPlanSettings& o) {
  f.require(f.present("map"), "map", "missing; it must name the yaml of a map");
  f.path("map", o.map);
  o.mention = f.where("map");
  f("height_m", o.height_m, between(0.1, 100));
  f.path("wall", o.wall);
  o.wall_mention = f.where("wall");
  f.path("floor", o.floor);
  o.floor_mention = f.where("floor");
  f.path("ceiling", o.ceiling);
  o.ceiling_mention = f.where("ceiling");
  f("has_ceiling", o.has_ceiling);
  f("unknown_is_wall", o.unknown_is_wall);
}

void bind(Fields& f, WorldSettings& o) {
  if (!f.writing()) {
    o.file = f.file();
    o.mention = f.here();
  }
  f("name", o.name);
  f("ambient", o.ambient, light);
  f("ambient_group", o.ambient_group);
  f("lights", o.lights);
  f("sun", o.sun);
  f("sky_bgr", o.sky_bgr, between(0, 1));
  f.paths("include", o.include, o.include_mentions);
  f.choice("generate", o.generate);
  o.generate_mention = f.where("generate");
  f("floor_plan", o.floor_plan);
  f("boxes", o.boxes);
  f("objects", o.objects);
  f("events", o.events);
  f("people", o.people);
}

}  // namespace panoptes::sim
