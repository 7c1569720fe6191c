// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/geometry/pose2.h"
#include "sim/world/load.h"

namespace panoptes::sim {

// What the generators of places are made of: walls with openings and what hangs on them, floors,
// lamps, windows, and furniture that keeps clear of other furniture. Meshes and pictures are named
// by folder and stem in the assets: `office/desk` is `data:office/desk.gltf`, `office/wall`
// `data:office/wall.png`. Meshes of furniture have their origin on the floor in the middle of their
// footprint and look along +x; meshes for walls have it in their middle, on the face they hang on.

inline constexpr double kRoomHeight_m = 2.7;
inline constexpr double kWallThickness_m = 0.12;
inline constexpr double kSkirting_m = 0.02;  ///< furniture stands so far off a wall
inline constexpr double kPaper_m = 1.3;      ///< one repeat of a wallpaper of `home/`

/// A picture of a floor and the size of one repeat.
struct FloorPicture {
  const char* picture;
  double tile_m;
};

/// One repeat of a wall's picture: a wallpaper of `home/` has its own, others are as wide as they
/// are high and reach from the floor to the ceiling.
double wall_repeat_m(const std::string& picture);

template <class Choice>
const typename Choice::value_type& one_of(const Choice& choice, Rng& rng) {
  return choice[static_cast<std::size_t>(rng.index(static_cast<int>(choice.size())))];
}

/// Adds an object, named after its mesh and numbered: `desk-007`. Textures are by material.
ObjectSettings& put(WorldSettings& into, const std::string& mesh, const Pose2& at, double z_m = 0,
                    const std::map<std::string, std::string>& textures = {});

/// Adds a box with the picture on every face, named and numbered likewise. See BoxSettings.
BoxSettings& put_box(WorldSettings& into, const std::string& kind, const Vec3& size_m,
                     const Pose2& at, double z_m, const std::string& picture,
                     const Vec2& picture_m = Vec2::Zero());

/// A floor with its top at z = 0, a ceiling with its underside at `height_m`; `tile_m` is the size
/// of one repeat of the picture.
void put_floor(WorldSettings& into, const Vec2& low, const Vec2& high, const std::string& picture,
               double tile_m);
void put_ceiling(WorldSettings& into, const Vec2& low, const Vec2& high,
                 const std::string& picture = "office/ceiling", double tile_m = 1.2,
                 double height_m = kRoomHeight_m);

/// A ceiling lamp of 1.2 m (along the pose's x) by 0.6 m, and its light, in the group `lamps`.
void put_lamp(WorldSettings& into, const Pose2& at, double power = 1,
              double ceiling_m = kRoomHeight_m);

/// Lamps in a grid about every `pitch_m`.
void put_lamps(WorldSettings& into, const Vec2& low, const Vec2& high, double pitch_m = 2.9,
               double power = 1, double ceiling_m = kRoomHeight_m);

/// Half a place, west of the middle of `size_m`, and the same again turned by half a turn about it.
void put_both_halves(WorldSettings& into, const WorldSettings& half, const Vec2& size_m);

/// A way through a wall.
struct Opening {
  double from_m = 0;  ///< along the wall from its first end
  double to_m = 1;
  double height_m = 2.1;
};

/// A wall with its middle line from `from` to `to`: boxes between the openings and above them. Its
/// two sides, left and right of the way from `from` to `to`, may have different pictures; one
/// repeat of a picture is as wide as it is high and reaches from the floor to the top.
struct WallSettings {
  Vec2 from = Vec2::Zero();
  Vec2 to = Vec2::Zero();
  std::string left = "office/wall";
  std::string right = "office/wall";
  double thickness_m = kWallThickness_m;
  double height_m = kRoomHeight_m;
  std::vector<Opening> openings = {};  ///< in order, apart from each other
};
void put_wall(WorldSettings& into, const WallSettings& wall);

/// A rectangle on a wall's face or on the floor.
struct Rectangle {
  Vec2 low = Vec2::Zero();
  Vec2 high = Vec2::Zero();

  bool overlaps(const Rectangle& other) const;
  bool contains(const Rectangle& other) const;
  Rectangle grown(double by_m) const;
};

/// One side of a wall as somebody in the room sees it, s to the right and z up, and what is taken
/// of it.
class WallFace {
 public:
  WallFace(const Vec2& left, const Vec2& right, double height_m = kRoomHeight_m);

  double length_m() const { return length_m_; }
  double height_m() const { return height_m_; }
  Pose2 at(double s_m) const;                  ///< on the face, looking into the room
  double along(const Vec2& p_scene) const;     ///< s of the point of it that is nearest
  bool is_clear(const Rectangle& what) const;  ///< inside the face, and nothing there
  void take(const Rectangle& what);

 private:
  Vec2 left_;
  Vec2 along_;
  double length_m_ = 0;
  double height_m_ = 0;
  std::vector<Rectangle> taken_;
};

/// What can hang on a wall; the sizes are those of the meshes.
struct Hanging {
  std::string mesh;
  Vec2 size_m;  ///< along the wall and upwards
};

/// Hangs it with its middle at (s, z) if there is room for it with 3 cm about it.
bool hang(WorldSettings& into, WallFace& face, const Hanging& what, double s_m, double z_m,
          const std::map<std::string, std::string>& textures = {});

/// A window with its light, in the group `daylight`, its middle at s; returns false without room.
bool put_window(WorldSettings& into, WallFace& face, double s_m, double power = 1.1,
                const std::string& view = "office/window_a");

/// A closed door in its frame; returns false without room.
bool put_door(WorldSettings& into, WallFace& face, double s_m,
              const std::string& leaf = "office/door");

/// Skirting boards where the wall is clear down to the floor.
void put_skirting(WorldSettings& into, const WallFace& face);

/// Fills what is clear of a wall from side to side, by chance: sockets, ducts and papers low,
/// posters, boards and signs at the height of the eyes, more signs and pictures above. `share` of
/// the places where something could hang are used: 1 leaves no wall without features, 0 leaves them
/// bare.
void dress(WorldSettings& into, WallFace& face, double share, Rng& rng);

/// Where furniture stands in a room: axis-parallel outlines.
class FloorSpace {
 public:
  FloorSpace(const Vec2& low, const Vec2& high);

  /// The outline of a piece of furniture, its size along its own x (ahead) and y.
  static Rectangle outline(const Pose2& at, const Vec2& size_m);

  bool is_clear(const Rectangle& what, double clearance_m = 0) const;
  void take(const Rectangle& what);
  const std::vector<Rectangle>& taken() const { return taken_; }

 private:
  Rectangle area_;
  std::vector<Rectangle> taken_;
};

}  // namespace panoptes::sim
