// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/load.h"

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "tests/support/scratch.h"

namespace panoptes::sim {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
namespace fs = std::filesystem;

constexpr double kSingle_m = 1e-6;  // meshes are read in single precision

/// One good triangle and one good picture.
class LoadWorld : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    write("good.obj",
          "mtllib good.mtl\nv 1 2 3\nv 2 2 3\nv 1 3 3\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl paint\n"
          "f 1/1 2/2 3/3\n");
    write("good.mtl", "newmtl paint\nmap_Kd good.png\n");
    cv::imwrite(path("good.png"), cv::Mat(4, 4, CV_8UC3, cv::Scalar(10, 20, 30)));
    cv::imwrite(path("other.png"), cv::Mat(4, 4, CV_8UC3, cv::Scalar(90, 80, 70)));
  }

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
  EXPECT_EQ(message_of<ConfigError>("objects:\n  - {name: a, mesh: absent.obj}\n"),
            path("world.yaml") + ":2:21: objects[0].mesh: no such file: " + path("absent.obj"));
}

TEST_F(LoadWorld, AMeshThatIsNoneIsSaidWithItsPlace) {
  write("broken.gltf", "{ this is not json");
  const std::string message =
      message_of<ConfigError>("objects:\n  - {name: a, mesh: broken.gltf}\n");
  EXPECT_THAT(message, StartsWith(path("world.yaml") + ":2:21: mesh '" + path("broken.gltf") +
                                  "' cannot be read: "));
  EXPECT_THAT(message, HasSubstr("; export it again, as glTF or OBJ"));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST_F(LoadWorld, AMeshWithoutFacesIsSaid) {
  write("empty.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\n");
  EXPECT_EQ(message_of<ConfigError>("objects:\n  - {name: a, mesh: empty.obj}\n"),
            path("world.yaml") + ":2:21: mesh '" + path("empty.obj") +
                "' has no faces; export it with its surfaces");
}

TEST_F(LoadWorld, AMeshWithNumbersThatAreNoneIsSaid) {
  write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(message_of<ConfigError>("objects:\n  - {name: a, mesh: nan.obj}\n"),
            path("world.yaml") + ":2:21: mesh '" + path("nan.obj") +
                "' has a corner that is not a finite number; export it again");
}

TEST_F(LoadWorld, AMissingTextureIsSaid) {
  EXPECT_EQ(
      message_of<ConfigError>(
          "objects:\n  - {name: a, mesh: good.obj, textures: {paint: absent.png}}\n"),
      path("world.yaml") + ":2:49: objects[0].textures.paint: no such file: " + path("absent.png"));
  fs::remove(path("good.png"));
  EXPECT_EQ(message_of<ConfigError>("objects:\n  - {name: a, mesh: good.obj}\n"),
            path("world.yaml") + ":2:21: " + path("good.obj") + ": texture '" + path("good.png") +
                "' does not exist; correct its path or put the file there");
}

TEST_F(LoadWorld, ATextureThatIsNoPictureIsSaid) {
  write("text.png", "no picture");
  EXPECT_EQ(message_of<ConfigError>(
                "objects:\n  - {name: a, mesh: good.obj, textures: {paint: text.png}}\n"),
            path("world.yaml") + ":2:49: texture '" + path("text.png") +
                "' is not a picture that can be read; save it again as PNG or JPEG");
}

TEST_F(LoadWorld, APictureForAnUnknownMaterialIsSaid) {
  EXPECT_EQ(message_of<ConfigError>(
                "objects:\n  - {name: a, mesh: good.obj, textures: {pant: other.png}}\n"),
            path("world.yaml") + ":2:48: mesh '" + path("good.obj") +
                "' has no material 'pant'; it has paint");
}

TEST_F(LoadWorld, AMissingFileOfMaterialsIsSaid) {
  fs::remove(path("good.mtl"));
  EXPECT_EQ(message_of<ConfigError>("objects:\n  - {name: a, mesh: good.obj}\n"),
            path("world.yaml") + ":2:21: mesh '" + path("good.obj") +
                "' takes its materials from '" + path("good.mtl") +
                "', which does not exist; put that file there, or take out its line mtllib");
}

TEST_F(LoadWorld, AFolderIsNoMesh) {
  fs::create_directories(path("folder.obj"));
  EXPECT_EQ(message_of<ConfigError>("objects:\n  - {name: a, mesh: folder.obj}\n"),
            path("world.yaml") +
                ":2:21: objects[0].mesh: is a folder, not a file: " + path("folder.obj"));
}

TEST_F(LoadWorld, AMissingTextureIsNamedOnce) {
  fs::remove(path("good.png"));
  EXPECT_EQ(message_of<ConfigError>("objects:\n  - {name: a, mesh: good.obj}\n  - {name: b, mesh: "
                                    "good.obj}\n  - {name: c, mesh: good.obj, z_m: 1}\nboxes:\n  - "
                                    "{size_m: [1, 1, 1], picture: other.png}\n"),
            path("world.yaml") + ":2:21: " + path("good.obj") + ": texture '" + path("good.png") +
                "' does not exist; correct its path or put the file there");
}

TEST_F(LoadWorld, EveryFaultOfAWorldIsSaidAtOnce) {
  write("empty.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\n");
  const std::string at = path("world.yaml");
  EXPECT_EQ(message_of<ConfigError>(
                "objects:\n  - {name: a, mesh: empty.obj}\n  - {name: b, mesh: good.obj}\n  - "
                "{name: b, mesh: good.obj}\nevents:\n  - {at_s: 1, lights: hall}\n  - {at_s: 1, "
                "move: b, to: {x_m: 1}}\n  - {at_s: 1, open: d}\n"),
            at + ":2:21: mesh '" + path("empty.obj") +
                "' has no faces; export it with its surfaces\n" + at +
                ":4:12: name: 'b' is given twice, first at " + at +
                ":3:12; things need names of their own\n" + at +
                ":6:5: lights: no lamp hangs on 'hall'; nothing here has `group:`\n" + at +
                ":7:5: move: 'b' stands for ever; write `movable: true` where it is placed\n" + at +
                ":8:5: open: there is no 'd'; nothing here has `movable:`");
}

TEST_F(LoadWorld, EventsAreResolvedInOrderOfTime) {
  const World world = load(
      "ambient_group: day\nobjects:\n  - {name: chair, mesh: good.obj, movable: true}\nevents:\n"
      "  - {at_s: 9, move: chair, to: {x_m: 1, y_m: 2, theta_deg: 90}}\n"
      "  - {at_s: 5, over_s: 0.5, lights: day, power: 0.25}\n"
      "  - {at_s: 3, open: chair, angle_deg: 45}\n");
  ASSERT_EQ(world.light_events.size(), 1U);
  EXPECT_EQ(world.light_events[0].group, "day");
  EXPECT_EQ(world.light_events[0].at, time_at(5));
  EXPECT_EQ(world.light_events[0].over, from_seconds(0.5));
  EXPECT_EQ(world.light_events[0].power, 0.25);
  ASSERT_EQ(world.move_events.size(), 2U);
  EXPECT_EQ(world.move_events[0].at, time_at(3));
  EXPECT_EQ(world.move_events[0].T_scene_object.theta_rad, deg_to_rad(45));
  EXPECT_EQ(world.move_events[1].T_scene_object.x_m, 1);
  EXPECT_EQ(world.objects[0].kind, Object::Kind::kMovable);
}

TEST_F(LoadWorld, EventsSayExactlyOneThing) {
  const std::string at = path("world.yaml");
  EXPECT_EQ(message_of<ConfigError>("events:\n  - {at_s: -1, lights: a, move: b}\n  - {at_s: 1}\n"
                                    "  - {at_s: 1, move: b}\n"),
            at + ":2:5: events[0].to: missing; it is where the thing goes\n" + at +
                ":2:12: events[0].at_s: must be from 0 to 1e9, got -1\n" + at +
                ":2:24: events[0].lights: exactly one of lights, move and open must be given, got "
                "a\n" +
                at +
                ":3:5: events[1].lights: exactly one of lights, move and open must be given\n" +
                at + ":4:5: events[2].to: missing; it is where the thing goes");
}

TEST_F(LoadWorld, PeopleWalkRoundThings) {
  const std::string before =
      "boxes:\n  - {name: wall, size_m: [4, 0.1, 2.5], at: {x_m: 0, y_m: 2}}\n";
  const std::string at = path("world.yaml");
  EXPECT_EQ(message_of<ConfigError>(before + "people:\n  - {name: ann, mesh: good.obj, path: [[0, "
                                             "0], [1, 1], [1, 4]]}\n"),
            at +
                ":4:39: path: 'ann' would walk from (1.00, 1.00) to (1.00, 4.00) through or within "
                "0.25 m of 'wall' (" +
                at + ":2:12); lead the path around it");
  EXPECT_EQ(message_of<ConfigError>(before + "people:\n  - {name: ann, mesh: good.obj, path: [[0, "
                                             "1.9], [1, 0]]}\n"),
            at + ":4:39: path: 'ann' stands at (0.00, 1.90) in or within 0.25 m of 'wall' (" + at +
                ":2:12); start elsewhere");
  EXPECT_EQ(message_of<ConfigError>(before + "people:\n  - {name: ann, mesh: good.obj, path: [[0, "
                                             "1.9], [1, 0], [1, 4], [2, 4], [2, 0]]}\n"),
            at + ":4:39: path: 'ann' stands at (0.00, 1.90) in or within 0.25 m of 'wall' (" + at +
                ":2:12); start elsewhere\n" + at +
                ":4:39: path: 'ann' would walk from (1.00, 0.00) to (1.00, 4.00) through or within "
                "0.25 m of 'wall' (" +
                at + ":2:12); lead the path around it\n" + at +
                ":4:39: path: 'ann' would walk from (2.00, 4.00) to (2.00, 0.00) through or within "
                "0.25 m of 'wall' (" +
                at + ":2:12); lead the path around it");
  const World world = load(before +
                           "people:\n  - {name: ann, mesh: good.obj, path: [[0, 0], [0, "
                           "-1]], speed_mps: 0.5, start_s: 3}\n");
  ASSERT_EQ(world.people.size(), 1U);
  const Object& ann = world.objects[world.people[0].object];
  EXPECT_EQ(ann.kind, Object::Kind::kPerson);
  EXPECT_LT((ann.T_scene_object * Vec3(1, 0, 0) - Vec3(0, -1, 0)).norm(), 1e-12);  // looks ahead
  EXPECT_EQ(world.people[0].start, time_at(3));
  EXPECT_EQ(world.people[0].speed_mps, 0.5);
}

TEST_F(LoadWorld, IncludedWorldsStandHereToo) {
  write("shelf.yaml",
        "objects:\n  - {name: sign, mesh: good.obj}\nambient: 0.9\nlights:\n  - "
        "{at_m: [0, 0, 2]}\n");
  const World world = load(
      "ambient: 0.2\ninclude: [shelf.yaml]\nboxes:\n  - {name: box, size_m: [1, "
      "1, 1], at: {x_m: 5, y_m: 5}}\n");
  EXPECT_EQ(world.objects.size(), 2U);
  EXPECT_EQ(world.lights.size(), 1U);
  EXPECT_EQ(world.ambient, 0.2);
}

TEST_F(LoadWorld, WorldsThatIncludeEachOtherAreRefused) {
  write("a.yaml", "include: [b.yaml]\n");
  write("b.yaml", "name: b\ninclude: [world.yaml]\n");
  EXPECT_EQ(message_of<ConfigError>("include:\n  - a.yaml\n"),
            path("b.yaml") + ":2:11: include: '" + path("world.yaml") + "' includes itself (" +
                path("world.yaml") + ":2:5 -> " + path("a.yaml") + ":1:11 -> " + path("b.yaml") +
                ":2:11 -> " + path("world.yaml") + "); take one of these out");
  EXPECT_EQ(message_of<ConfigError>("include: [world.yaml]\n"),
            path("world.yaml") + ":1:11: include: '" + path("world.yaml") + "' includes itself (" +
                path("world.yaml") + ":1:11 -> " + path("world.yaml") + "); take one of these out");
}

TEST_F(LoadWorld, AWorldIncludedTwiceIsSaidOnce) {
  write("shelf.yaml",
        "objects:\n  - {name: sign, mesh: good.obj}\n  - {name: s, mesh: good.obj}\n");
  write("room.yaml", "include:\n  - ./shelf.yaml\n");
  EXPECT_EQ(message_of<ConfigError>("include: [shelf.yaml, room.yaml]\n"),
            path("room.yaml") + ":2:5: include: '" + path("shelf.yaml") + "' is here already, by " +
                path("world.yaml") + ":1:11; take one of the two out");
}

TEST_F(LoadWorld, AnEmptyWorldIsRefused) {
  EXPECT_EQ(message_of<ConfigError>("name: nothing\n"),
            path("world.yaml") +
                ":1:1: the world is empty; give it objects, boxes, a floor_plan, "
                "generate or include");
}

TEST_F(LoadWorld, ThingsOfNoSizeAreRefused) {
  const std::string at = path("world.yaml");
  EXPECT_EQ(message_of<ConfigError>("boxes:\n  - {name: b, size_m: [1, 0, 1]}\nobjects:\n  - "
                                    "{name: a, mesh: good.obj, scale: 0}\n"),
            at + ":2:27: boxes[0].size_m[1]: must be from 0.001 to 1000 metres, got 0\n" + at +
                ":4:38: objects[0].scale: must be > 0, got 0");
}

TEST_F(LoadWorld, AWorldFarFromTheOriginIsRefused) {
  const std::string at = path("world.yaml");
  EXPECT_EQ(message_of<ConfigError>(
                "boxes:\n  - {name: a, size_m: [1, 1, 1], at: {x_m: 5e6}}\n"
                "  - {name: b, size_m: [1, 1, 1], at: {x_m: 5e6, y_m: 3}}\n"
                "  - {name: c, size_m: [1, 1, 1], at: {x_m: 5000002, y_m: 3}, movable: true}\n"),
            at + ":4:12: 'c' stands 5e+06 m from the origin, and 2 more too far; a world reaches "
                 "1000 m along each axis, for farther out pictures are drawn too coarsely: move "
                 "the world to the origin");
  EXPECT_EQ(message_of<ConfigError>("objects:\n  - {name: tower, mesh: good.obj, z_m: 998}\n"),
            at + ":2:12: 'tower' stands 1001 m from the origin; a world reaches 1000 m along each "
                 "axis, for farther out pictures are drawn too coarsely: move the world to the "
                 "origin");
  const std::string cure =
      "must be within 1000 m of the origin, for farther out pictures are drawn too coarsely; move "
      "the world there, got ";
  EXPECT_EQ(message_of<ConfigError>(
                "lights:\n  - {at_m: [0, 2000, 3]}\nevents:\n  - {at_s: 1, move: b, to: {x_m: "
                "1e9}}\npeople:\n  - {name: p, path: [[0, 0], [-1e9, 0]]}\n"),
            at + ":2:16: lights[0].at_m[1]: " + cure + "2000\n" + at +
                ":4:28: events[0].to: must be within 1000 m of the origin, for farther out "
                "pictures are drawn too coarsely; move the world there\n" +
                at + ":6:31: people[0].path[1][0]: " + cure + "-1e9");
}

TEST_F(LoadWorld, NumbersThatLeadNowhereAreRefused) {
  const std::string at = path("world.yaml");
  EXPECT_EQ(
      message_of<ConfigError>(
          "ambient: 1e7\nsun: {from: [1e300, 0, 0]}\n"
          "boxes: [{name: b, size_m: [1, 1e-12, 1], picture_m: [1e-9, 1]}]\n"
          "lights: [{at_m: [0, 0, 2], group: hall, normal: [0, 0, 0], size_m: [1e-9, 1]}]\n"
          "events: [{at_s: 1, lights: hall, power: 1e300}]\n"),
      at +
          ":1:10: ambient: must be from 0 to 1000, where 1 lights a white surface white, got "
          "1e7\n" +
          at + ":2:13: sun.from: must be from 1e-6 to 1e6 long: it is the direction to the sun\n" +
          at + ":3:31: boxes[0].size_m[1]: must be from 0.001 to 1000 metres, got 1e-12\n" + at +
          ":3:53: boxes[0].picture_m: must be at least 0.001 metres both ways, or [0, 0] for once "
          "over each face\n" +
          at +
          ":4:49: lights[0].normal: must be from 1e-6 to 1e6 long: it is where the light "
          "shines to\n" +
          at + ":4:69: lights[0].size_m[0]: must be from 0.001 to 1000 metres, got 1e-9\n" + at +
          ":5:41: events[0].power: must be from 0 to 100, got 1e300");
}

TEST_F(LoadWorld, APictureTooLargeIsRefusedByItsHeader) {
  // A PNG's signature and header: 30000 x 30000, and nothing else.
  const std::string header("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x75\x30\0\0\x75\x30\x08\x02\0\0\0",
                           29);
  std::ofstream(path("huge.png"), std::ios::binary) << header << "\0\0\0\0";
  EXPECT_EQ(message_of<ConfigError>("boxes:\n  - {size_m: [1, 1, 1], picture: huge.png}\n"),
            path("world.yaml") + ":2:34: texture '" + path("huge.png") +
                "' is 30000 x 30000 pixels; make it at most 8192 wide and high");
}

TEST_F(LoadWorld, ADamagedPictureIsSaidWithoutNoise) {
  std::string png;
  {
    std::vector<unsigned char> bytes;
    cv::imencode(".png", cv::Mat(64, 64, CV_8UC3, cv::Scalar(1, 2, 3)), bytes);
    png.assign(bytes.begin(), bytes.end());
  }
  ::testing::internal::CaptureStderr();
  for (const std::size_t keep : {png.size() - 4, png.size() / 2, std::size_t{40}}) {
    std::ofstream(path("cut.png"), std::ios::binary) << png.substr(0, keep);
    EXPECT_EQ(message_of<ConfigError>("boxes:\n  - {size_m: [1, 1, 1], picture: cut.png}\n"),
              path("world.yaml") + ":2:34: texture '" + path("cut.png") +
                  "' is damaged or cut short; save it again as PNG or JPEG");
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST_F(LoadWorld, AnUnknownAssetOfOursIsTheMachinesFault) {
  const std::string message =
      message_of<IoError>("boxes:\n  - {size_m: [1, 1, 1], picture: data:office/wool.png}\n");
  EXPECT_THAT(
      message,
      StartsWith(path("world.yaml") +
                 ":2:34: boxes[0].picture: no such file: data:office/wool.png, looked for in "));
  EXPECT_THAT(message, HasSubstr("/assets"));
}

TEST_F(LoadWorld, AGeneratedPlaceThatDoesNotFitIsSaidWithItsPlace) {
  EXPECT_THAT(message_of<ConfigError>("generate: {office: {size_m: [2, 2]}}\n"),
              StartsWith(path("world.yaml") + ":1:29: generate.office.size_m: "));
  EXPECT_THAT(message_of<ConfigError>("generate: {ofice: {size_m: [2, 2]}}\n"),
              StartsWith(path("world.yaml") + ":1:12: generate: must be one of office, home, "));
}

TEST_F(LoadWorld, SettingsAreWrittenAndReadBackExactly) {
  write(
      "world.yaml",
      "name: all\nambient: 0.3\nambient_group: day\nsky_bgr: [0.9, 0.7, 0.6]\n"
      "sun: {from: [1, 2, 3], power: 0.7, group: day}\n"
      "lights: [{at_m: [0, 0, 2.5], group: hall}]\n"
      "generate: {office: {size_m: [12, 9], desks: 14, seed: 5}}\n"
      "boxes: [{name: door, size_m: [0.9, 0.04, 2], hinge_m: [-0.45, 0], movable: true, picture: "
      "good.png, faces: {top: \"\", front: other.png}, picture_m: [0.3, 0.1]}]\n"
      "objects: [{name: sign, mesh: good.obj, scale: 0.1, up: z, textures: {paint: other.png}}]\n"
      "events: [{at_s: 1, open: door, angle_deg: 33}, {at_s: 2, lights: hall, power: 0.1}, {at_s: "
      "3, over_s: 1, move: door, to: {x_m: 1, theta_deg: 7}}]\n"
      "people: [{name: ann, mesh: good.obj, path: [[0, 0], [1, 0.1]], returns: false}]\n");
  const std::string written = write_settings(read_settings<WorldSettings>(path("world.yaml")));
  write("again.yaml", written);
  EXPECT_EQ(write_settings(read_settings<WorldSettings>(path("again.yaml"))), written);
}

}  // namespace
}  // namespace panoptes::sim
