// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/drive_world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include <box2d/box2d.h>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

// Box2D keeps shapes apart by lengths of its own (b2_linearSlop, 5 mm in metres) that are large
// beside our gaps. With 20 of its units in a metre they are 0.25 mm, and all is still of the size
// it likes.
constexpr double kUnitsPerMetre = 20;
constexpr double kStep_s = 1.0 / DriveWorld::kStepsPerSecond;
constexpr int kVelocityIterations = 8;  // as its manual says
constexpr int kPositionIterations = 3;
constexpr float kFriction = 0.4F;  // plastic bumper on painted wood
// A fifth of its weight: rubber on a floor holds twice that, and the mast stays up.
constexpr double kHardBrake_mps2 = 2;
constexpr Duration kApart = std::chrono::seconds(1);

b2Vec2 units(const Vec2& p) {
  return {static_cast<float>(p.x() * kUnitsPerMetre), static_cast<float>(p.y() * kUnitsPerMetre)};
}

Vec2 metres(const b2Vec2& p) {
  return Vec2(static_cast<double>(p.x), static_cast<double>(p.y)) / kUnitsPerMetre;
}

double towards(double value, double target, double largest_change) {
  return value + std::clamp(target - value, -largest_change, largest_change);
}

// The first touches of one step: contacts may begin and end within it.
class FirstTouches : public b2ContactListener {
 public:
  void BeginContact(b2Contact* contact) override { contacts.push_back(contact); }
  std::vector<b2Contact*> contacts;
};

}  // namespace

Time time_of_step(std::int64_t step) {
  const std::int64_t whole_s = step / DriveWorld::kStepsPerSecond;
  const std::int64_t rest = step % DriveWorld::kStepsPerSecond;
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  return Time(
      Duration(whole_s * kSecond_ns + (rest * kSecond_ns + DriveWorld::kStepsPerSecond / 2) /
                                          DriveWorld::kStepsPerSecond));
}

double clearance_m(const Obstacles& obstacles, const DynamicObjects& dynamic_objects,
                   const std::vector<Pose2>& places, const Body& body, const Vec2& at_scene) {
  double nearest_m = std::numeric_limits<double>::infinity();
  if (const std::optional<Nearest> nearest = obstacles.nearest(at_scene)) {
    nearest_m = nearest->distance_m;
  }
  for (std::size_t i = 0; i < dynamic_objects.count(); ++i) {
    nearest_m = std::min(nearest_m, dynamic_objects.nearest_on(i, places[i], at_scene).distance_m);
  }
  return std::max(0.0, nearest_m - body.radius_m);
}

class DriveWorld::Impl {
 public:
  Impl(const Body& body, const Obstacles& obstacles, const Pose2& T_scene_body,
       DynamicObjects dynamic_objects)
      : body_(body),
        obstacles_(obstacles),
        objects_(std::move(dynamic_objects)),
        pose_(T_scene_body),
        world_(b2Vec2_zero) {
    const b2BodyDef at_rest;
    b2Body* still = world_.CreateBody(&at_rest);
    for (std::size_t i = 0; i < obstacles_.outlines().size(); ++i) {
      add_edges(*still, obstacles_.outlines()[i], i);
    }
    for (std::size_t i = 0; i < objects_.count(); ++i) {
      object_bodies_.push_back(object_body(i));
    }
    b2BodyDef moving;
    moving.type = b2_dynamicBody;
    moving.position = units(pose_.position());
    moving.fixedRotation = true;  // the motors hold the heading
    moving.allowSleep = false;
    moving.bullet = true;
    disc_ = world_.CreateBody(&moving);
    b2CircleShape circle;
    // Edges have a skin of b2_polygonRadius, and what touches comes to rest b2_linearSlop inside.
    circle.m_radius =
        static_cast<float>(body.radius_m * kUnitsPerMetre) - b2_polygonRadius + b2_linearSlop;
    b2FixtureDef fixture;
    fixture.shape = &circle;
    fixture.density = 1;
    fixture.friction = kFriction;
    disc_->CreateFixture(&fixture);
    world_.SetContactListener(&first_touches_);
  }

  void drive(const Twist2& command, Time expires) {
    PANOPTES_CHECK(std::isfinite(command.v_mps) && std::isfinite(command.w_radps),
                   "a commanded velocity is finite");
    command_ = {std::clamp(command.v_mps, -body_.max_speed_mps, body_.max_speed_mps),
                std::clamp(command.w_radps, -body_.max_turn_radps, body_.max_turn_radps)};
    expires_ = expires;
    brakes_hard_ = false;
  }

  void brake_hard() {
    command_ = {};
    brakes_hard_ = true;
  }

  void step() {
    step_objects();
    const Twist2 wanted = time_of_step(steps_) < expires_ ? command_ : Twist2{};
    const double hard_mps2 = std::max(kHardBrake_mps2, body_.max_accel_mps2);
    const double accel_mps2 = brakes_hard_ ? hard_mps2 : body_.max_accel_mps2;
    const double before_mps = twist_.v_mps;
    twist_.v_mps = towards(twist_.v_mps, wanted.v_mps, accel_mps2 * kStep_s);
    if (brakes_hard_ && before_mps != 0) {  // on the arc that it was on
      twist_.w_radps *= twist_.v_mps / before_mps;
    } else {
      twist_.w_radps =
          towards(twist_.w_radps, wanted.w_radps, body_.max_turn_accel_radps2 * kStep_s);
    }
    const bool moves =
        twist_.v_mps != 0 || twist_.w_radps != 0 || wanted.v_mps != 0 || wanted.w_radps != 0;

    const Pose2 free_pose = pose_ * exp_twist(twist_, kStep_s);
    const Vec2 free_motion = free_pose.position() - pose_.position();
    disc_->SetLinearVelocity(units(free_motion / kStep_s));
    first_touches_.contacts.clear();
    world_.Step(static_cast<float>(kStep_s), kVelocityIterations, kPositionIterations);
    ++steps_;

    touched_scene_.clear();
    std::map<std::string, Vec2> touched = touched_objects();
    if (!touched.empty()) {
      const Vec2 at = metres(disc_->GetPosition());
      const Vec2 motion = at - pose_.position();
      const double middle_rad = pose_.theta_rad + twist_.w_radps * kStep_s / 2;
      const double forward_m = motion.dot(Vec2(std::cos(middle_rad), std::sin(middle_rad)));
      motion_ = {forward_m, twist_.w_radps * kStep_s};
      path_m_ += motion.norm();
      pose_ = {at.x(), at.y(), free_pose.theta_rad};
      // What it touches takes speed, and never gives any.
      const double felt_mps = forward_m / kStep_s;
      twist_.v_mps = twist_.v_mps > 0 ? std::clamp(felt_mps, 0.0, twist_.v_mps)
                                      : std::clamp(felt_mps, twist_.v_mps, 0.0);
    } else {
      motion_ = {twist_.v_mps * kStep_s, twist_.w_radps * kStep_s};
      path_m_ += std::abs(motion_.forward_m);
      pose_ = free_pose;
    }
    disc_->SetTransform(units(pose_.position()), 0);
    for (std::size_t i = 0; i < objects_.count(); ++i) {
      if (objects_.stands_against_robot(i)) {
        const Vec2 p_scene = objects_.nearest_on(i, objects_.places()[i], pose_.position()).p_scene;
        touched.emplace(objects_.name(i), p_scene);
        touched_scene_.push_back(p_scene);
      }
    }
    touching_ = !touched.empty();
    note_bearings();
    note(touched, moves);
  }

  std::int64_t steps() const { return steps_; }
  const Pose2& pose() const { return pose_; }
  const Twist2& twist() const { return twist_; }
  const Motion& motion() const { return motion_; }
  double path_m() const { return path_m_; }
  bool touching() const { return touching_; }
  const std::vector<double>& touch_bearings_rad() const { return touch_bearings_rad_; }
  const std::vector<TrueContact>& contacts() const { return contacts_; }

  double clearance_m() const {
    return sim::clearance_m(obstacles_, objects_, objects_.places(), body_, pose_.position());
  }
  const DynamicObjects& dynamic_objects() const { return objects_; }

 private:
  // Single edges rather than polygons: any number of corners, and thin slivers, are fine.
  static void add_edges(b2Body& body, const Outline& outline, std::size_t number) {
    const std::vector<Vec2>& corners = outline.corners_scene;
    const std::size_t edges = corners.size() > 2 ? corners.size() : corners.size() - 1;
    for (std::size_t k = 0; k < edges; ++k) {
      b2EdgeShape edge;
      edge.SetTwoSided(units(corners[k]), units(corners[(k + 1) % corners.size()]));
      b2FixtureDef fixture;
      fixture.shape = &edge;
      fixture.friction = kFriction;
      fixture.userData.pointer = number;
      body.CreateFixture(&fixture);
    }
  }

  // Placed anew at every step and never given a velocity, so that it takes speed and gives none.
  b2Body* object_body(std::size_t object) {
    const Pose2& place = objects_.places()[object];
    b2BodyDef placed;
    placed.type = b2_kinematicBody;
    placed.position = units(place.position());
    placed.angle = static_cast<float>(place.theta_rad);
    placed.userData.pointer = 1 + object;
    b2Body* body = world_.CreateBody(&placed);
    for (const Outline& outline : objects_.outlines(object)) {
      add_edges(*body, outline, 0);
    }
    if (objects_.radius_m(object) > 0) {
      b2CircleShape circle;
      // The robot's disc is made larger for the skin of edges, which a circle has not.
      circle.m_radius =
          static_cast<float>(objects_.radius_m(object) * kUnitsPerMetre) + b2_polygonRadius;
      b2FixtureDef fixture;
      fixture.shape = &circle;
      fixture.friction = kFriction;
      body->CreateFixture(&fixture);
    }
    return body;
  }

  void step_objects() {
    if (objects_.count() == 0) {
      return;
    }
    const std::vector<Pose2> before = objects_.places();
    objects_.step(time_of_step(steps_), time_of_step(steps_ + 1),
                  {pose_.position(), body_.radius_m});
    for (std::size_t i = 0; i < objects_.count(); ++i) {
      const Pose2& place = objects_.places()[i];
      if (!(place == before[i])) {
        object_bodies_[i]->SetTransform(units(place.position()),
                                        static_cast<float>(place.theta_rad));
      }
    }
  }

  std::map<std::string, Vec2> touched_objects() {
    std::map<std::string, Vec2> touched;
    const auto add = [&](b2Contact* contact) {
      b2Fixture* other = contact->GetFixtureA()->GetBody() == disc_ ? contact->GetFixtureB()
                                                                    : contact->GetFixtureA();
      const std::size_t object = other->GetBody()->GetUserData().pointer;
      const std::size_t fixed = other->GetUserData().pointer;
      const std::string& name =
          object > 0 ? objects_.name(object - 1) : obstacles_.outlines()[fixed].object;
      const Vec2 p_scene =
          object > 0
              ? objects_.nearest_on(object - 1, objects_.places()[object - 1], pose_.position())
                    .p_scene
              : nearest_on(obstacles_.outlines()[fixed], pose_.position()).p_scene;
      touched.emplace(name, p_scene);
      // An outline may be touched at several places: each contact is with one edge of it.
      if (contact->GetManifold()->pointCount > 0) {
        b2WorldManifold manifold;
        contact->GetWorldManifold(&manifold);
        touched_scene_.push_back(metres(manifold.points[0]));
      } else {
        touched_scene_.push_back(p_scene);
      }
    };
    for (b2Contact* contact : first_touches_.contacts) {
      add(contact);
    }
    for (const b2ContactEdge* edge = disc_->GetContactList(); edge != nullptr; edge = edge->next) {
      if (edge->contact->IsTouching()) {
        add(edge->contact);
      }
    }
    return touched;
  }

  void note_bearings() {
    touch_bearings_rad_.clear();
    for (const Vec2& p_scene : touched_scene_) {
      const Vec2 p_body = pose_.inverse() * p_scene;
      touch_bearings_rad_.push_back(std::atan2(p_body.y(), p_body.x()));
    }
  }

  void note(const std::map<std::string, Vec2>& touched, bool moves) {
    const Time now = time_of_step(steps_);
    for (const auto& [object, p_scene] : touched) {
      const auto last = last_touch_.find(object);
      if (last == last_touch_.end() || now - last->second >= kApart) {
        contacts_.push_back({now, p_scene, object, moves});
      }
      last_touch_[object] = now;
    }
  }

  Body body_;
  const Obstacles& obstacles_;
  DynamicObjects objects_;
  Pose2 pose_;
  Twist2 twist_;
  Motion motion_;
  Twist2 command_;
  Time expires_{};
  bool brakes_hard_ = false;
  std::int64_t steps_ = 0;
  double path_m_ = 0;
  bool touching_ = false;
  std::vector<Vec2> touched_scene_;
  std::vector<double> touch_bearings_rad_;
  std::vector<TrueContact> contacts_;
  std::map<std::string, Time> last_touch_;
  FirstTouches first_touches_;  // outlives the world that calls it
  b2World world_;
  b2Body* disc_ = nullptr;
  std::vector<b2Body*> object_bodies_;
};

DriveWorld::DriveWorld(const Body& body, const Obstacles& obstacles, const Pose2& T_scene_body,
                       DynamicObjects dynamic_objects)
    : impl_(std::make_unique<Impl>(body, obstacles, T_scene_body, std::move(dynamic_objects))) {}
DriveWorld::~DriveWorld() = default;

void DriveWorld::brake_hard() { impl_->brake_hard(); }

void DriveWorld::drive(const Twist2& command_body, Time expires) {
  impl_->drive(command_body, expires);
}
void DriveWorld::step() { impl_->step(); }
std::int64_t DriveWorld::steps() const { return impl_->steps(); }
Time DriveWorld::now() const { return time_of_step(impl_->steps()); }
Pose2 DriveWorld::T_scene_body() const { return impl_->pose(); }
Twist2 DriveWorld::twist_body() const { return impl_->twist(); }
Motion DriveWorld::last_motion() const { return impl_->motion(); }
double DriveWorld::path_m() const { return impl_->path_m(); }
double DriveWorld::clearance_m() const { return impl_->clearance_m(); }
const DynamicObjects& DriveWorld::dynamic_objects() const { return impl_->dynamic_objects(); }
bool DriveWorld::touching() const { return impl_->touching(); }
const std::vector<double>& DriveWorld::touch_bearings_rad() const {
  return impl_->touch_bearings_rad();
}
const std::vector<TrueContact>& DriveWorld::contacts() const { return impl_->contacts(); }

}  // namespace panoptes::sim
