// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/body_faces.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/pose2.h"
#include "tests/support/scratch.h"

namespace panoptes::sim {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string kMeshes = PANOPTES_SOURCE_DIR "/tests/data/meshes/";

struct Extent {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
};

Extent extent_of(const std::vector<Face>& faces, std::size_t from = 0,
                 std::size_t count = std::numeric_limits<std::size_t>::max()) {
  Extent extent;
  for (std::size_t i = from; i < std::min(faces.size(), from + std::min(count, faces.size()));
       ++i) {
    for (const Vec3& p : faces[i]) {
      extent.low = extent.low.cwiseMin(p);
      extent.high = extent.high.cwiseMax(p);
    }
  }
  return extent;
}

void expect_extent(const Extent& extent, const Vec3& low, const Vec3& high) {
  constexpr double kSingle_m = 1e-6;
  EXPECT_LT((extent.low - low).norm(), kSingle_m) << extent.low.transpose();
  EXPECT_LT((extent.high - high).norm(), kSingle_m) << extent.high.transpose();
}

class BodyFaces : public ScratchTest {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(path(name)).parent_path());
    std::ofstream(path(name)) << text;
    return path(name);
  }
  static Body read(const BodyShape& shape) {
    Body body;
    body.shape = shape;
    body.shape->mention = "robot.yaml:3:1";
    read_body_faces(body);
    return body;
  }
  static std::vector<Face> faces(const std::string& mesh) {
    BodyShape shape;
    shape.mesh = mesh;
    return *read(shape).faces;
  }
  template <class Shape>
  static std::string fault(const Shape& shape) {
    try {
      if constexpr (std::is_same_v<Shape, BodyShape>) {
        read(shape);
      } else {
        faces(shape);
      }
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "taken";
  }
};

TEST_F(BodyFaces, AreThoseOfAMeshWhereTheRobotFilePutsIt) {
  Body cylinder;
  read_body_faces(cylinder);
  EXPECT_EQ(cylinder.faces, nullptr);
  BodyShape shape;
  shape.mesh = kMeshes + "box_mm.stl";  // 0.1 .. 0.7, -0.2 .. 0.3, 0 .. 0.4 m
  shape.scale = 0.001;
  expect_extent(extent_of(*read(shape).faces), {0.1, -0.2, 0}, {0.7, 0.3, 0.4});
  shape.at_m = {-0.3, 0, 0.1};
  shape.yaw_rad = deg_to_rad(90);
  expect_extent(extent_of(*read(shape).faces), {-0.6, 0.1, 0.1}, {-0.1, 0.7, 0.5});
  shape = {};
  shape.mesh = kMeshes + "box.obj";  // of y up
  expect_extent(extent_of(*read(shape).faces), {0.1, -0.2, 0}, {0.7, 0.3, 0.4});
}

TEST_F(BodyFaces, AreThoseOfARobotInUrdf) {
  const std::string robot =
      write("robots/here/urdf/robot.urdf",
            "<robot name='r'>"
            "<link name='base'><visual><origin xyz='0 0 0.1'/><geometry><box size='0.4 0.3 0.2'/>"
            "</geometry></visual>"
            "<collision><geometry><box size='9 9 9'/></geometry></collision></link>"
            "<link name='mast'><collision><origin xyz='0 0 0.25'/><geometry>"
            "<cylinder radius='0.02' length='0.5'/></geometry></collision></link>"
            "<link name='ball'><visual><geometry><sphere radius='0.1'/></geometry></visual></link>"
            "<link name='nothing'/>"
            "<link name='part'><visual><geometry>"
            "<mesh filename='package://here/meshes/part.stl' scale='0.001 0.001 0.0005'/>"
            "</geometry></visual></link>"
            "<joint name='j' type='fixed'><parent link='base'/><child link='mast'/>"
            "<origin xyz='-0.1 0 0.2' rpy='0 1.5707963267948966 0'/></joint>"
            "<joint name='k' type='continuous'><parent link='mast'/><child link='ball'/>"
            "<origin xyz='0 0 0.5'/></joint>"
            "<joint name='l' type='fixed'><parent link='base'/><child link='nothing'/></joint>"
            "<joint name='m' type='fixed'><parent link='nothing'/><child link='part'/>"
            "<origin xyz='0 0 1'/></joint>"
            "</robot>");
  std::filesystem::create_directories(path("robots/here/meshes"));
  std::filesystem::copy(kMeshes + "box_mm.stl", path("robots/here/meshes/part.stl"));
  const std::vector<Face> all = faces(robot);
  // The base's box; the mast lies along x, for its joint turns it, and the ball is on its end.
  expect_extent(extent_of(all, 0, 12), {-0.2, -0.15, 0}, {0.2, 0.15, 0.2});
  const auto reaches = [&](const Vec3& p) {
    return std::any_of(all.begin(), all.end(), [&](const Face& face) {
      return std::any_of(face.begin(), face.end(),
                         [&](const Vec3& corner) { return (corner - p).norm() < 1e-6; });
    });
  };
  EXPECT_TRUE(reaches({-0.1, 0.02, 0.2}));
  EXPECT_TRUE(reaches({0.4, 0.02, 0.2}));
  EXPECT_TRUE(reaches({0.5, 0, 0.2})) << "the end of the ball";
  EXPECT_TRUE(reaches({0.7, 0.3, 1.2})) << "half as high as it is, one metre up";
}

TEST_F(BodyFaces, NeedNoColoursAndMayBeInSmallUnits) {
  BodyShape shape;
  shape.mesh = write("tall.obj",  // 1.2 m high in millimetres
                     "mtllib lost.mtl\nv -200 -200 0\nv 200 -200 0\nv 0 200 1200\nf 1 2 3\n");
  shape.up = Up::kZ;
  shape.scale = 0.001;
  expect_extent(extent_of(*read(shape).faces), {-0.2, -0.2, 0}, {0.2, 0.2, 1.2});
  const std::string robot = write("small.urdf",
                                  "<robot name='r'><!-- <xacro:include filename='old'/> -->"
                                  "<link name='base'><visual><geometry><mesh filename='tall.obj' "
                                  "scale='0.001 0.001 0.001'/></geometry></visual></link></robot>");
  expect_extent(extent_of(faces(robot)), {-0.2, -0.2, 0}, {0.2, 0.2, 1.2});
}

TEST_F(BodyFaces, SayWhatIsWrong) {
  EXPECT_THAT(fault(path("none.urdf")), HasSubstr("none.urdf"));
  EXPECT_THAT(fault(write("a.urdf", "<robot name='r'")),
              AllOf(HasSubstr("robot.yaml:3:1: robot '"), HasSubstr("is no URDF")));
  EXPECT_THAT(fault(write("b.urdf", "<robot name='r'><link name='base'/></robot>")),
              HasSubstr("has no link with a shape"));
  EXPECT_THAT(fault(write("c.urdf",
                          "<robot name='r' xmlns:xacro='x'><xacro:include filename='y'/></robot>")),
              HasSubstr("run `xacro FILE > robot.urdf` first"));
  EXPECT_THAT(
      fault(write("d.urdf",
                  "<robot name='r'><link name='base'><visual><geometry><mesh "
                  "filename='package://far/away.stl'/></geometry></visual></link></robot>")),
      AllOf(HasSubstr("has the link base with the mesh 'package://far/away.stl'"),
            HasSubstr("put the robot's package there")));
  EXPECT_THAT(fault(path("none.stl")), HasSubstr("does not exist"));
  EXPECT_THAT(fault(write("f.urdf",
                          "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>"
                          "<joint name='1' type='fixed'><parent link='a'/><child link='b'/></joint>"
                          "<joint name='2' type='fixed'><parent link='b'/><child link='c'/></joint>"
                          "<joint name='3' type='fixed'><parent link='c'/><child link='b'/></joint>"
                          "</robot>")),
              HasSubstr("has the link b under two joints"));
  EXPECT_THAT(fault(write("g.urdf",
                          "<robot name='r'><link name='base'><visual><geometry><mesh "
                          "filename='model://far/away.stl'/></geometry></visual></link></robot>")),
              HasSubstr("name it by package://"));
  BodyShape size;
  size.mesh = kMeshes + "box_mm.stl";  // taken for metres
  EXPECT_THAT(fault(size), HasSubstr("correct the shape's scale, up, at_m"));
  size.scale = 1e-5;
  EXPECT_THAT(fault(size), HasSubstr("correct the shape's scale, up, at_m"));
  BodyShape up;
  up.mesh = write("e.urdf", "<robot name='r'/>");
  up.up = Up::kY;
  EXPECT_THAT(fault(up), HasSubstr("leave `up` out"));
}

}  // namespace
}  // namespace panoptes::sim
