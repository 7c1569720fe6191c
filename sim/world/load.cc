// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/load.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/config/data_files.h"
#include "core/config/geometry_fields.h"
#include "sim/world/boxes.h"
#include "sim/world/faults.h"
#include "sim/world/floor_plan.h"
#include "sim/world/mesh.h"
#include "sim/world/people.h"
#include "sim/world/pictures.h"

namespace panoptes::sim {
namespace {

/// One file that includes another.
struct Inclusion {
  std::string file;
  std::string mention;  ///< of the file it includes
};

template <class T>
void append(std::vector<T>& to, std::vector<T>& from) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

std::string identity_of(const std::string& file) {
  std::error_code error;
  const std::filesystem::path real = std::filesystem::weakly_canonical(file, error);
  return error ? file : real.string();
}

void refuse_ring(const std::string& file, const std::vector<Inclusion>& chain) {
  const auto first = std::find_if(chain.begin(), chain.end(), [&file](const Inclusion& inclusion) {
    return identity_of(inclusion.file) == identity_of(file);
  });
  if (first == chain.end()) {
    return;
  }
  std::string ring;
  for (auto at = first; at != chain.end(); ++at) {
    ring += at->mention + " -> ";
  }
  throw ConfigError(fmt::format("{}: include: '{}' includes itself ({}{}); take one of these out",
                                chain.back().mention, file, ring, file));
}

void make_generated(WorldSettings& settings) {
  if (!settings.generate) {
    return;
  }
  WorldSettings made;
  try {
    std::visit([&made](const auto& plan) { generate(plan, made); }, *settings.generate);
  } catch (const ConfigError& error) {
    throw ConfigError((settings.generate_mention.empty() ? "" : settings.generate_mention + ": ") +
                      error.what());
  } catch (const IoError& error) {
    throw IoError((settings.generate_mention.empty() ? "" : settings.generate_mention + ": ") +
                  error.what());
  }
  settings.generate.reset();
  const std::string& mention = settings.generate_mention;
  for (BoxSettings& box : made.boxes) {
    box.mention = mention;
    box.picture_mention = mention;
  }
  for (ObjectSettings& object : made.objects) {
    object.mention = mention;
    object.mesh_mention = mention;
  }
  for (EventSettings& event : made.events) {
    event.mention = mention;
  }
  for (PersonSettings& person : made.people) {
    person.mention = mention;
    person.mesh_mention = mention;
    person.path_mention = mention;
  }
  // What the user wrote comes after the place it stands in.
  const auto put_before = [](auto& those, auto& first) {
    append(first, those);
    those = std::move(first);
  };
  put_before(settings.lights, made.lights);
  put_before(settings.boxes, made.boxes);
  put_before(settings.objects, made.objects);
  put_before(settings.events, made.events);
  put_before(settings.people, made.people);
  // Its sky and light where the user says nothing of them.
  const WorldSettings unsaid;
  const auto take = [](auto& value, const auto& other, const auto& untouched) {
    if (value == untouched) {
      value = other;
    }
  };
  take(settings.ambient, made.ambient, unsaid.ambient);
  take(settings.ambient_group, made.ambient_group, unsaid.ambient_group);
  take(settings.sky_bgr, made.sky_bgr, unsaid.sky_bgr);
  if (!settings.sun) {
    settings.sun = made.sun;
  }
}

/// What has been included on the way to a world.
struct Inclusions {
  std::vector<Inclusion> chain;                 ///< the files that include one another
  std::map<std::string, std::string> mentions;  ///< of every file included, by what it is
  std::vector<std::string> faults;
};

WorldSettings expanded(WorldSettings settings, Inclusions& inclusions) {
  std::vector<Inclusion>& chain = inclusions.chain;
  make_generated(settings);
  for (std::size_t i = 0; i < settings.include.size(); ++i) {
    chain.push_back(
        {settings.file, i < settings.include_mentions.size() ? settings.include_mentions[i] : ""});
    const std::string& written = settings.include[i];
    const std::string file = written.starts_with("data:") ? resolve_path(written, "") : written;
    refuse_ring(file, chain);
    // A world has one place, so twice the same would stand in itself.
    const auto [first, is_new] =
        inclusions.mentions.emplace(identity_of(file), chain.back().mention);
    if (!is_new) {
      inclusions.faults.push_back(
          fmt::format("{}: include: '{}' is here already, by {}; take one of the two out",
                      chain.back().mention, file, first->second));
      chain.pop_back();
      continue;
    }
    WorldSettings other = expanded(read_settings<WorldSettings>(file), inclusions);
    chain.pop_back();
    append(settings.lights, other.lights);
    append(settings.boxes, other.boxes);
    append(settings.objects, other.objects);
    append(settings.events, other.events);
    append(settings.people, other.people);
    if (other.floor_plan && settings.floor_plan) {
      throw ConfigError(fmt::format("{}: floor_plan: a world has one; the other is in {}",
                                    other.floor_plan->mention, settings.floor_plan->mention));
    }
    if (other.floor_plan) {
      settings.floor_plan = std::move(other.floor_plan);
    }
  }
  settings.include.clear();
  settings.include_mentions.clear();
  return settings;
}

/// A mesh as read, so that a chair that stands in twenty places is read once, and what is wrong
/// with it said once.
using MeshKey = std::tuple<std::string, double, Up, std::map<std::string, std::string>>;

/// The world while it is made, with the place that mentions each of its objects.
class Builder {
 public:
  World make(const WorldSettings& settings) {
    world_.name = settings.name;
    world_.ambient = settings.ambient;
    world_.ambient_group = settings.ambient_group;
    world_.lights = settings.lights;
    world_.sun = settings.sun;
    world_.sky_bgr = {settings.sky_bgr[0], settings.sky_bgr[1], settings.sky_bgr[2]};
    if (settings.floor_plan) {
      faults_.collect([&] {
        for (Object& part : make_floor_plan(*settings.floor_plan, pictures_)) {
          add(std::move(part), settings.floor_plan->mention);
        }
      });
    }
    for (const BoxSettings& box : settings.boxes) {
      add_box(box);
    }
    for (const ObjectSettings& object : settings.objects) {
      add_mesh(object, on_floor(object.at, object.z_m),
               object.movable ? Object::Kind::kMovable : Object::Kind::kFixed);
    }
    for (const PersonSettings& person : settings.people) {
      add_person(person);
    }
    if (world_.objects.empty() && !faults_.any()) {
      faults_.user(settings.mention,
                   "the world is empty; give it objects, boxes, a floor_plan, generate or include");
    }
    if (world_.textures.size() > kMostTextures) {
      faults_.user(settings.mention,
                   fmt::format("the world has {} pictures and colours; it may have {}: let more "
                               "things share them",
                               world_.textures.size(), kMostTextures));
    }
    for (const EventSettings& event : settings.events) {
      add_event(event);
    }
    const auto earlier = [](const auto& a, const auto& b) { return a.at < b.at; };
    std::stable_sort(world_.light_events.begin(), world_.light_events.end(), earlier);
    std::stable_sort(world_.move_events.begin(), world_.move_events.end(), earlier);
    require_room(settings.mention);
    if (!faults_.any()) {
      check_paths(world_, settings.people, mentions_, faults_);
    }
    faults_.raise();
    return std::move(world_);
  }

 private:
  static Pose3 on_floor(const Pose2& at, double z_m) {
    Pose3 T_scene_object = panoptes::on_floor(at);
    T_scene_object.translation.z() = z_m;
    return T_scene_object;
  }

  void add(Object object, const std::string& mention) {
    if (!object.name.empty()) {
      const auto [entry, is_new] = by_name_.try_emplace(object.name, world_.objects.size());
      if (!is_new) {
        const std::string& first = mentions_[entry->second];
        faults_.user(mention, fmt::format("name: '{}' is given twice{}; things need names of "
                                          "their own",
                                          object.name, first.empty() ? "" : ", first at " + first));
      }
    }
    triangles_ += object.triangles.size();
    if (triangles_ > kMostTriangles && triangles_ - object.triangles.size() <= kMostTriangles) {
      faults_.user(mention, fmt::format("'{}' brings the world to {} triangles; it takes {}: "
                                        "make meshes coarser or use fewer",
                                        object.name, triangles_, kMostTriangles));
    }
    if (triangles_ > kMostTriangles) {
      object.triangles.clear();  // said; no need to hold more of them
    }
    world_.objects.push_back(std::move(object));
    mentions_.push_back(mention);
  }

  void add_box(const BoxSettings& settings) {
    if (!(settings.size_m.minCoeff() > 0)) {
      faults_.user(settings.mention,
                   fmt::format("size_m: the box '{}' must be > 0 along each axis", settings.name));
      return;
    }
    Object box = make_box(settings, pictures_);
    if (box.triangles.empty()) {
      faults_.user(settings.mention,
                   fmt::format("faces: the box '{}' has no face left; leave one", settings.name));
    }
    add(std::move(box), settings.mention);
  }

  bool add_mesh(const ObjectSettings& settings, const Pose3& T_scene_object, Object::Kind kind) {
    const auto [entry, is_new] = seen_.try_emplace(
        MeshKey{settings.mesh, settings.scale, settings.up, settings.textures}, kUnreadable);
    std::size_t& first = entry->second;
    if (is_new) {
      faults_.collect([&] {
        std::vector<Triangle> triangles = read_mesh(settings, pictures_);
        first = world_.objects.size();
        add({settings.name, T_scene_object, std::move(triangles), kind, {}}, settings.mention);
      });
    } else if (first != kUnreadable) {
      add({settings.name, T_scene_object, world_.objects[first].triangles, kind, {}},
          settings.mention);
    }
    if (first == kUnreadable && !settings.name.empty()) {  // events on it are no faults
      add({settings.name, T_scene_object, {}, kind, {}}, settings.mention);
    }
    return first != kUnreadable;
  }

  void add_person(const PersonSettings& settings) {
    PANOPTES_CHECK(settings.path.size() >= 2, "a way has two points or more");
    const Vec2 ahead = settings.path[1] - settings.path[0];
    const Pose2 T_scene_person{settings.path[0].x(), settings.path[0].y(),
                               std::atan2(ahead.y(), ahead.x())};
    ObjectSettings figure;
    figure.name = settings.name;
    figure.mesh = settings.mesh;
    figure.mention = settings.mention;
    figure.mesh_mention = settings.mesh_mention;
    if (add_mesh(figure, on_floor(T_scene_person, 0), Object::Kind::kPerson)) {
      Person person;
      person.object = world_.objects.size() - 1;
      person.path_scene = settings.path;
      person.speed_mps = settings.speed_mps;
      person.start = time_at(settings.start_s);
      person.returns = settings.returns;
      person.waits_m = settings.waits_m;
      person.turns_back_s = settings.turns_back_s;
      world_.people.push_back(std::move(person));
    }
  }

  void add_event(const EventSettings& settings) {
    const Time at = time_at(settings.at_s);
    const Duration over = from_seconds(settings.over_s);
    if (settings.at_s < 0 || settings.over_s < 0) {
      faults_.user(settings.mention, "at_s: an event is at 0 s or later, and takes 0 s or more");
    }
    if (!settings.lights.empty()) {
      std::vector<std::string> groups;
      for (const AreaLight& light : world_.lights) {
        groups.push_back(light.group);
      }
      groups.push_back(world_.ambient_group);
      groups.push_back(world_.sun ? world_.sun->group : "");
      std::sort(groups.begin(), groups.end());
      groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
      std::erase(groups, "");
      if (std::find(groups.begin(), groups.end(), settings.lights) == groups.end()) {
        faults_.user(settings.mention,
                     fmt::format("lights: no lamp hangs on '{}'; {}", settings.lights,
                                 hint(settings.lights, groups, "group")));
        return;
      }
      world_.light_events.push_back({at, over, settings.lights, settings.power});
      return;
    }
    const bool turns = settings.move.empty();
    const std::string& name = turns ? settings.open : settings.move;
    const char* const key = turns ? "open" : "move";
    const auto found = by_name_.find(name);
    if (name.empty() || found == by_name_.end()) {
      std::vector<std::string> movable;
      for (const Object& object : world_.objects) {
        if (object.kind == Object::Kind::kMovable && !object.name.empty()) {
          movable.push_back(object.name);
        }
      }
      faults_.user(settings.mention, fmt::format("{}: there is no '{}'; {}", key, name,
                                                 hint(name, movable, "movable")));
      return;
    }
    const Object& object = world_.objects[found->second];
    if (object.kind != Object::Kind::kMovable) {
      faults_.user(settings.mention,
                   fmt::format("{}: '{}' stands for ever; write `movable: true` where it is placed",
                               key, name));
      return;
    }
    Pose2 T_scene_object = settings.to;
    if (turns) {
      const Vec3 ahead = object.T_scene_object.rotation * Vec3::UnitX();
      T_scene_object = {object.T_scene_object.translation.x(),
                        object.T_scene_object.translation.y(),
                        std::atan2(ahead.y(), ahead.x()) + settings.angle_rad};
    }
    world_.move_events.push_back({at, over, found->second, T_scene_object});
  }

  static std::string hint(const std::string& word, const std::vector<std::string>& known,
                          const char* key) {
    const std::string near = nearest_word(word, known);
    if (!near.empty()) {
      return fmt::format("did you mean '{}'?", near);
    }
    return known.empty() ? fmt::format("nothing here has `{}:`", key)
                         : fmt::format("there are {}", fmt::join(known, ", "));
  }

  /// So that the map of what is true stays of a size that a computer can hold, and pictures are
  /// drawn finely enough.
  void require_room(const std::string& mention) {
    constexpr double kWidest_m = 1000;
    const auto mention_of = [&](std::size_t object) {
      return mentions_[object].empty() ? mention : mentions_[object];
    };
    Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
    Vec2 high = -low;
    std::size_t farthest = 0;
    double farthest_m = 0;
    std::size_t too_far = 0;
    std::optional<std::size_t> widening;
    for (std::size_t i = 0; i < world_.objects.size(); ++i) {
      const Object& object = world_.objects[i];
      double far_m = 0;
      for (const Triangle& t : object.triangles) {
        for (const Corner& corner : t.corners) {
          const Vec3 p = object.T_scene_object * corner.p_object;
          far_m = std::max(far_m, p.cwiseAbs().maxCoeff());
          low = low.cwiseMin(p.head<2>());
          high = high.cwiseMax(p.head<2>());
        }
      }
      too_far += far_m > kFarthest_m ? 1 : 0;
      if (far_m > farthest_m) {
        farthest = i;
        farthest_m = far_m;
      }
      if (!widening && (high - low).maxCoeff() > kWidest_m) {
        widening = i;
        faults_.user(
            mention_of(i),
            fmt::format("with '{}' the world is {:.6g} m wide; it may be {}: move it nearer "
                        "to the rest",
                        object.name, (high - low).maxCoeff(), kWidest_m));
      }
    }
    if (too_far > 0 && !widening) {
      faults_.user(mention_of(farthest),
                   fmt::format("'{}' stands {:.6g} m from the origin{}; a world reaches {} m along "
                               "each axis, for farther out pictures are drawn too coarsely: move "
                               "the world to the origin",
                               world_.objects[farthest].name, farthest_m,
                               too_far > 1 ? fmt::format(", and {} more too far", too_far - 1) : "",
                               kFarthest_m));
    }
  }

  static constexpr std::size_t kUnreadable = static_cast<std::size_t>(-1);

  World world_;
  Faults faults_;
  Pictures pictures_{world_.textures, faults_};
  std::vector<std::string> mentions_;
  std::map<std::string, std::size_t> by_name_;
  std::map<MeshKey, std::size_t> seen_;
  std::size_t triangles_ = 0;
};

}  // namespace

void draw_place(WorldSettings& settings, std::uint64_t seed) {
  auto* room = settings.generate ? std::get_if<RoomPlan>(&*settings.generate) : nullptr;
  if (room != nullptr && !room->seed) {
    room->seed = seed;
  }
}

WorldSettings expanded(const WorldSettings& settings) {
  Inclusions inclusions;
  WorldSettings whole = expanded(settings, inclusions);
  if (!inclusions.faults.empty()) {
    throw ConfigError(inclusions.faults);
  }
  return whole;
}

World make_world(const WorldSettings& settings) { return Builder().make(expanded(settings)); }

World load_world(const std::string& file) { return make_world(read_settings<WorldSettings>(file)); }

}  // namespace panoptes::sim
