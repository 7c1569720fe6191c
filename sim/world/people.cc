// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/people.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include <fmt/format.h>

#include "sim/world/layers.h"

namespace panoptes::sim {
namespace {

double distance(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp(along.dot(p - a) / length2, 0.0, 1.0) : 0.0;
  return (p - (a + t * along)).norm();
}

double side(const Vec2& a, const Vec2& b, const Vec2& p) {
  return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
}

double distance(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  if (side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0) {
    return 0;
  }
  return std::min({distance(a, c, d), distance(b, c, d), distance(c, a, b), distance(d, a, b)});
}

/// From a stretch of path to a convex outline; 0 where they meet.
double distance(const Vec2& a, const Vec2& b, const std::vector<Vec2>& outline) {
  double nearest_m = std::numeric_limits<double>::infinity();
  bool inside = outline.size() > 2;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2& c = outline[i];
    const Vec2& d = outline[(i + 1) % outline.size()];
    nearest_m = std::min(nearest_m, distance(a, b, c, d));
    inside = inside && side(c, d, a) >= 0;
  }
  return inside ? 0 : nearest_m;
}

double height_m(const Object& figure) {
  double height_m = 2 * kFloorLayerTop_m;
  for (const Triangle& t : figure.triangles) {
    for (const Corner& corner : t.corners) {
      height_m = std::max(height_m, corner.p_object.z());
    }
  }
  return height_m;
}

std::string place(const Vec2& p) { return fmt::format("({:.2f}, {:.2f})", p.x(), p.y()); }

}  // namespace

void check_paths(const World& world, const std::vector<PersonSettings>& people,
                 const std::vector<std::string>& mentions, Faults& faults) {
  for (std::size_t i = 0; i < people.size(); ++i) {
    const Person& person = world.people[i];
    const std::vector<Vec2>& path = person.path_scene;
    const std::vector<Outline> around =
        outlines(world, kFloorLayerTop_m, height_m(world.objects[person.object]));
    const auto hit = [&](const Vec2& a, const Vec2& b) {
      return std::find_if(around.begin(), around.end(), [&](const Outline& outline) {
        return world.objects[outline.index].kind == Object::Kind::kFixed &&
               distance(a, b, outline.corners_scene) < person.radius_m;
      });
    };
    const auto name_of = [&](const Outline& outline) {
      const std::string& mention = mentions[outline.index];
      return fmt::format("'{}'{}", outline.object, mention.empty() ? "" : " (" + mention + ")");
    };
    std::size_t first = 0;
    if (const auto thing = hit(path[0], path[0]); thing != around.end()) {
      first = 1;
      faults.user(people[i].path_mention,
                  fmt::format("path: '{}' stands at {} in or within {} m of {}; start elsewhere",
                              people[i].name, place(path[0]), person.radius_m, name_of(*thing)));
    }
    for (std::size_t k = first; k + 1 < path.size(); ++k) {
      if (const auto thing = hit(path[k], path[k + 1]); thing != around.end()) {
        faults.user(people[i].path_mention,
                    fmt::format("path: '{}' would walk from {} to {} through or within {} m of {}; "
                                "lead the path around it",
                                people[i].name, place(path[k]), place(path[k + 1]), person.radius_m,
                                name_of(*thing)));
      }
    }
  }
}

}  // namespace panoptes::sim
