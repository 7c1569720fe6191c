// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/boxes.h"

#include <cstddef>
#include <string>

namespace panoptes::sim {

void append_rectangle(const std::array<Vec3, 4>& corners, const Vec2& uv_low, const Vec2& uv_high,
                      int texture, std::vector<Triangle>& triangles) {
  const Corner a{corners[0], uv_low};
  const Corner b{corners[1], {uv_high.x(), uv_low.y()}};
  const Corner c{corners[2], uv_high};
  const Corner d{corners[3], {uv_low.x(), uv_high.y()}};
  triangles.push_back({{a, b, c}, texture});
  triangles.push_back({{a, c, d}, texture});
}

Object make_box(const BoxSettings& settings, Pictures& pictures) {
  const Vec3& size = settings.size_m;
  const Vec3 low(-size.x() / 2 - settings.hinge_m.x(), -size.y() / 2 - settings.hinge_m.y(), 0);
  const Vec3 high = low + size;
  // The lower four corners and then the upper four, each counter-clockwise from above.
  const std::array<Vec3, 8> p{low,
                              Vec3(high.x(), low.y(), low.z()),
                              Vec3(high.x(), high.y(), low.z()),
                              Vec3(low.x(), high.y(), low.z()),
                              Vec3(low.x(), low.y(), high.z()),
                              Vec3(high.x(), low.y(), high.z()),
                              high,
                              Vec3(low.x(), high.y(), high.z())};
  constexpr std::array<std::array<std::size_t, 4>, 6> kCorners{
      {{1, 2, 6, 5}, {3, 0, 4, 7}, {2, 3, 7, 6}, {0, 1, 5, 4}, {4, 5, 6, 7}, {1, 0, 3, 2}}};
  const bool on_floor_or_below = settings.z_m <= 0;

  Object box;
  box.name = settings.name;
  box.kind = settings.movable ? Object::Kind::kMovable : Object::Kind::kFixed;
  box.T_scene_object = on_floor(settings.at);
  box.T_scene_object.translation.z() = settings.z_m;
  for (std::size_t i = 0; i < kFaceNames.size(); ++i) {
    const std::string name(kFaceNames[i]);
    std::string picture = settings.picture;
    std::string mention = settings.picture_mention;
    if (const auto own = settings.faces.find(name); own != settings.faces.end()) {
      if (own->second.empty()) {
        continue;
      }
      picture = own->second;
      const auto place = settings.face_mentions.find(name);
      mention = place == settings.face_mentions.end() ? settings.mention : place->second;
    } else if (name == "bottom" && on_floor_or_below) {
      continue;
    }
    const int texture =
        picture.empty() ? pictures.plain(0.8, 0.8, 0.8) : pictures.from_file(picture, mention);
    const std::array<Vec3, 4> corners{p[kCorners[i][0]], p[kCorners[i][1]], p[kCorners[i][2]],
                                      p[kCorners[i][3]]};
    Vec2 repeats = Vec2::Ones();
    if (settings.picture_m.x() > 0) {
      repeats = Vec2((corners[1] - corners[0]).norm(), (corners[3] - corners[0]).norm())
                    .cwiseQuotient(settings.picture_m);
    }
    append_rectangle(corners, {0, repeats.y()}, {repeats.x(), 0}, texture, box.triangles);
  }
  box.pillars.push_back(
      {{p[0].head<2>(), p[1].head<2>(), p[2].head<2>(), p[3].head<2>()}, low.z(), high.z()});
  return box;
}

}  // namespace panoptes::sim
