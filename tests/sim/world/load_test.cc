// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/load.h"

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"

namespace panoptes::sim {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
namespace fs = std::filesystem;

constexpr double kSingle_m = 1e-6;  // meshes are read in single precision

/// A folder of its own for each test, with one good triangle and one good picture in it.
class LoadWorld : public ::testing::Test {
 protected:
  LoadWorld() {
    const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(::testing::TempDir()) / ("panoptes-world-" + test);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write("good.obj",
          "mtllib good.mtl\nv 1 2 3\nv 2 2 3\nv 1 3 3\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl paint\n"
          "f 1/1 2/2 3/3\n");
    write("good.mtl", "newmtl paint\nmap_Kd good.png\n");
    cv::imwrite(path("good.png"), cv::Mat(4, 4, CV_8UC3, cv::Scalar(10, 20, 30)));
    cv::imwrite(path("other.png"), cv::Mat(4, 4, CV_8UC3, cv::Scalar(90, 80, 70)));
  }
  ~LoadWorld() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name)) << text;
  }

  World load(const std::string& yaml) const {
    write("world.yaml", yaml);
    return load_world(path("world.yaml"));
  }

  template <class Error>
  std::string message_of(const std::string& yaml) const {
    try {
      load(yaml);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  fs::path folder_;
};

TEST_F(LoadWorld, MeshesStandUprightWithTheirPictures) {
  const World world = load(
      "name: test\nambient: 0.5\nlights:\n  - {at_m: [1, 2, 3], size_m: [1, 0.5], power: 2}\n"
      "objects:\n  - {name: sign, mesh: good.obj, at: {x_m: 5, y_m: 6, theta_deg: 90}, z_m: 7}\n");
  EXPECT_EQ(world.name, "test");
  EXPECT_EQ(world.ambient, 0.5);
  ASSERT_EQ(world.lights.size(), 1U);
  EXPECT_EQ(world.lights[0].at_m, Vec3(1, 2, 3));
  EXPECT_EQ(world.lights[0].normal, Vec3(0, 0, -1));
  ASSERT_EQ(world.objects.size(), 1U);
  const Object& sign = world.objects[0];
  EXPECT_EQ(sign.name, "sign");
  ASSERT_EQ(sign.triangles.size(), 1U);
  const Corner& first = sign.triangles[0].corners[0];
  EXPECT_LT((first.p_object - Vec3(1, -3, 2)).norm(), kSingle_m);  // y up there, z up here
  EXPECT_LT((sign.T_scene_object * first.p_object - Vec3(5 + 3, 6 + 1, 7 + 2)).norm(), kSingle_m);
  EXPECT_LT((first.uv - Vec2(0, 1)).norm(), kSingle_m);  // bottom left of the picture
  ASSERT_EQ(world.textures.size(), 1U);
  EXPECT_EQ(world.textures[0].bgr.at<cv::Vec3b>(0, 0), cv::Vec3b(10, 20, 30));
}

TEST_F(LoadWorld, AWorldMayGiveAMaterialAnotherPicture) {
  const World world = load(
      "objects:\n  - {name: a, mesh: good.obj}\n  - {name: b, mesh: good.obj, textures: {paint: "
      "other.png}}\n  - {name: c, mesh: good.obj}\n");
  ASSERT_EQ(world.textures.size(), 2U);  // each picture once
  EXPECT_EQ(world.objects[0].triangles[0].texture, 0);
  EXPECT_EQ(world.objects[1].triangles[0].texture, 1);
  EXPECT_EQ(world.objects[2].triangles[0].texture, 0);
}

TEST_F(LoadWorld, AMissingWorldFileIsSaid) {
  EXPECT_THROW(load_world(path("absent.yaml")), ConfigError);
}

TEST_F(LoadWorld, EveryBrokenKeyIsSaidWithItsPlace) {
  EXPECT_EQ(message_of<ConfigError>("ambiant: 1\nobjects:\n  - {mesh: good.obj, z_m: high}\n"),
            path("world.yaml") + ":1:1: ambiant: unknown key; did you mean ambient?\n" +
                path("world.yaml") + ":3:27: objects[0].z_m: must be a number, got high");
}

TEST_F(LoadWorld, AMissingMeshIsSaidWithItsPlace) {
  EXPECT_EQ(message_of<IoError>("objects:\n  - {name: a, mesh: absent.obj}\n"),
            path("world.yaml") + ":2:21: objects[0].mesh: no such file: " + path("absent.obj"));
}

TEST_F(LoadWorld, AMeshThatIsNoneIsSaidWithItsPlace) {
  write("broken.gltf", "{ this is not json");
  const std::string message = message_of<IoError>("objects:\n  - {name: a, mesh: broken.gltf}\n");
  EXPECT_THAT(message, StartsWith(path("world.yaml") + ":2:21: mesh '" + path("broken.gltf") +
                                  "' cannot be read: "));
  EXPECT_THAT(message, HasSubstr("; export it again, as glTF or OBJ"));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST_F(LoadWorld, AMeshWithoutFacesIsSaid) {
  write("empty.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\n");
  EXPECT_EQ(message_of<IoError>("objects:\n  - {name: a, mesh: empty.obj}\n"),
            path("world.yaml") + ":2:21: mesh '" + path("empty.obj") +
                "' has no faces; export it with its surfaces");
}

TEST_F(LoadWorld, AMeshWithNumbersThatAreNoneIsSaid) {
  write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(message_of<IoError>("objects:\n  - {name: a, mesh: nan.obj}\n"),
            path("world.yaml") + ":2:21: mesh '" + path("nan.obj") +
                "' has a corner that is not a finite number; export it again");
}

TEST_F(LoadWorld, AMissingTextureIsSaid) {
  EXPECT_EQ(
      message_of<IoError>(
          "objects:\n  - {name: a, mesh: good.obj, textures: {paint: absent.png}}\n"),
      path("world.yaml") + ":2:49: objects[0].textures.paint: no such file: " + path("absent.png"));
  fs::remove(path("good.png"));
  EXPECT_EQ(message_of<IoError>("objects:\n  - {name: a, mesh: good.obj}\n"),
            path("world.yaml") + ":2:21: " + path("good.obj") + ": texture '" + path("good.png") +
                "' does not exist; correct its path or put the file there");
}

TEST_F(LoadWorld, ATextureThatIsNoPictureIsSaid) {
  write("text.png", "no picture");
  EXPECT_EQ(
      message_of<IoError>("objects:\n  - {name: a, mesh: good.obj, textures: {paint: text.png}}\n"),
      path("world.yaml") + ":2:49: texture '" + path("text.png") +
          "' is not a picture that can be read; save it again as PNG or JPEG");
}

TEST_F(LoadWorld, APictureForAnUnknownMaterialIsSaid) {
  EXPECT_EQ(message_of<ConfigError>(
                "objects:\n  - {name: a, mesh: good.obj, textures: {pant: other.png}}\n"),
            path("world.yaml") + ":2:48: mesh '" + path("good.obj") +
                "' has no material 'pant'; it has paint");
}

}  // namespace
}  // namespace panoptes::sim
