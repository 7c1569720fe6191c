// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/mesh.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/world/layers.h"
#include "tests/support/scratch.h"

namespace panoptes::sim {
namespace {

using ::testing::HasSubstr;
using ::testing::Values;
namespace fs = std::filesystem;

constexpr double kSingle_m = 1e-6;  // meshes are read in single precision

std::string data(const std::string& name) {
  return std::string(PANOPTES_SOURCE_DIR "/tests/data/meshes/") + name;
}

World world_of(const ObjectSettings& object) {
  WorldSettings settings;
  settings.objects = {object};
  return make_world(settings);
}

struct Format {
  std::string file;
  double scale = 1;
  bool has_picture = true;
  Up up = Up::kUsual;
};

class EveryFormat : public ::testing::TestWithParam<Format> {
 protected:
  World read() const {
    ObjectSettings box;
    box.name = "box";
    box.mesh = data(GetParam().file);
    box.scale = GetParam().scale;
    box.up = GetParam().up;
    return world_of(box);
  }
};

TEST_P(EveryFormat, GivesTheSameOutlineAndHeight) {
  const World world = read();
  const std::vector<Outline> found = outlines(world, 0.39, 0.5);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(outlines(world, 0.4 + kSingle_m, 0.5).empty());
  EXPECT_TRUE(outlines(world, -1, -kSingle_m).empty());
  ASSERT_EQ(found[0].corners_scene.size(), 4U);
  for (const Vec2& corner : {Vec2(0.1, -0.2), Vec2(0.7, -0.2), Vec2(0.7, 0.3), Vec2(0.1, 0.3)}) {
    EXPECT_TRUE(std::any_of(found[0].corners_scene.begin(), found[0].corners_scene.end(),
                            [&](const Vec2& p) { return (p - corner).norm() < kSingle_m; }))
        << corner.transpose();
  }
}

TEST_P(EveryFormat, HasItsFacesOutwards) {
  const World world = read();
  ASSERT_EQ(world.objects[0].triangles.size(), 12U);
  double six_volumes_m3 = 0;
  for (const Triangle& t : world.objects[0].triangles) {
    six_volumes_m3 += t.corners[0].p_object.dot(t.corners[1].p_object.cross(t.corners[2].p_object));
  }
  EXPECT_NEAR(six_volumes_m3 / 6, 0.6 * 0.5 * 0.4, kSingle_m);
}

// Upper left red, upper right green, lower left blue, lower right white, as seen from outside.
TEST_P(EveryFormat, ShowsItsPictureUpright) {
  const World world = read();
  ASSERT_EQ(world.textures.size(), 1U);
  const cv::Mat& picture = world.textures[0].bgr;
  if (!GetParam().has_picture) {
    EXPECT_EQ(picture.size(), cv::Size(1, 1));
    return;
  }
  ASSERT_EQ(picture.size(), cv::Size(8, 8));
  EXPECT_EQ(picture.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 255));
  EXPECT_EQ(picture.at<cv::Vec3b>(7, 0), cv::Vec3b(255, 0, 0));
  for (const Triangle& t : world.objects[0].triangles) {
    const Vec3 normal = (t.corners[1].p_object - t.corners[0].p_object)
                            .cross(t.corners[2].p_object - t.corners[0].p_object)
                            .normalized();
    const Vec3 up = std::abs(normal.z()) < 0.5 ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::UnitY());
    const Vec3 right = up.cross(normal);
    const Vec3 middle(0.4, 0.05, 0.2);
    for (const Corner& corner : t.corners) {
      const Vec3 p = corner.p_object - middle;
      EXPECT_NEAR(corner.uv.x(), p.dot(right) > 0 ? 1 : 0, kSingle_m);
      EXPECT_NEAR(corner.uv.y(), p.dot(up) > 0 ? 0 : 1, kSingle_m);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, EveryFormat,
                         Values(Format{"box.obj"}, Format{"box.gltf"}, Format{"box_embedded.gltf"},
                                Format{"box_mirrored.gltf"}, Format{"box.glb"}, Format{"box.dae"},
                                Format{"box_z_mm.dae"}, Format{"box.ply"},
                                Format{"box.stl", 1, false}, Format{"box_mm.stl", 0.001, false}),
                         [](const ::testing::TestParamInfo<Format>& format) {
                           std::string name = format.param.file;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

TEST(Meshes, UpMayBeGivenWhereTheFormatHasNone) {
  ObjectSettings box;
  box.mesh = data("box.stl");
  box.up = Up::kY;
  const Corner y = world_of(box).objects[0].triangles[0].corners[0];
  box.up = Up::kZ;
  const Corner z = world_of(box).objects[0].triangles[0].corners[0];
  EXPECT_EQ(y.p_object, Vec3(z.p_object.x(), -z.p_object.z(), z.p_object.y()));
}

class BadMesh : public ScratchTest {
 protected:
  std::string message_of(const ObjectSettings& object) const {
    try {
      world_of(object);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "no error";
  }
  std::string message_of(const std::string& name, const std::string& text) const {
    const std::string path = (folder_ / name).string();
    std::ofstream(path) << text;
    ObjectSettings object;
    object.name = "thing";
    object.mesh = path;
    object.mesh_mention = "w.yaml:3:9";
    std::string message = message_of(object);
    const std::string beginning = "w.yaml:3:9: mesh '" + path + "' ";
    return message.starts_with(beginning) ? message.substr(beginning.size()) : message;
  }
};

TEST_F(BadMesh, ATooFineOneIsRefusedByItsHeader) {
  EXPECT_EQ(message_of("m.ply",
                       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                       "element face 1000000\nend_header\n"),
            "has 1000000 triangles; a world takes 400000 in all: make it coarser (Blender: "
            "Decimate), or cut it up");
  EXPECT_EQ(message_of("v.ply",
                       "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\n"
                       "element face 1\nend_header\n"),
            "says that it has more corners than a file of its size can; export it again");
  std::string faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 500'000; ++i) {
    faces += "f 1 2 3\n";
  }
  EXPECT_THAT(message_of("m.obj", faces), HasSubstr("has 500000 triangles; a world takes"));
}

TEST_F(BadMesh, AWorldCountsAllItsMeshes) {
  std::string faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 250'000; ++i) {
    faces += "f 1 2 3\n";
  }
  std::ofstream((folder_ / "m.obj").string()) << faces;
  WorldSettings settings;
  for (const char* name : {"a", "b"}) {
    ObjectSettings object;
    object.name = name;
    object.mesh = (folder_ / "m.obj").string();
    object.mention = std::string("w.yaml:1:") + name;
    settings.objects.push_back(object);
  }
  try {
    make_world(settings);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "w.yaml:1:b: 'b' brings the world to 500000 triangles; it takes 400000: make "
                 "meshes coarser or use fewer");
  }
}

TEST_F(BadMesh, AWrongSizeAsksForAScale) {
  const std::string mm = "v 0 0 0\nv 6000 0 0\nv 0 3000 0\nf 1 2 3\n";
  EXPECT_EQ(message_of("m.obj", mm),
            "is 6e+03 m big; things here are from 1 mm to 1 km: give its `scale` (0.001 for "
            "millimetres)");
  EXPECT_THAT(message_of("n.obj", "v 0 0 0\nv 1e-5 0 0\nv 0 1e-5 0\nf 1 2 3\n"),
              HasSubstr("is 1e-05 m big"));
}

TEST_F(BadMesh, FacesWithoutAnAreaAreNone) {
  EXPECT_EQ(message_of("m.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n"),
            "has no faces; export it with its surfaces");
}

TEST_F(BadMesh, UpIsNotSaidTwice) {
  ObjectSettings box;
  box.name = "box";
  box.mesh = data("box.glb");
  box.mesh_mention = "w.yaml:3:9";
  box.up = Up::kZ;
  EXPECT_EQ(message_of(box),
            "w.yaml:3:9: up: a glb file says itself which axis is up; leave `up` out");
}

TEST_F(BadMesh, NoiseIsRefusedInEveryFormat) {
  for (const char* name : {"m.gltf", "m.glb", "m.obj", "m.dae", "m.ply", "m.stl", "m.xyz"}) {
    EXPECT_THAT(message_of(name, "\x01\x02 no mesh at all {{{ <<<"),
                ::testing::AnyOf(HasSubstr("cannot be read: "), HasSubstr("has no faces")))
        << name;
  }
}

}  // namespace
}  // namespace panoptes::sim
