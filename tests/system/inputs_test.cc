// SPDX-License-Identifier: BSD-3-Clause
// What a run was made of: trials believe no verdict on something else, and costs are the program's.
#include "core/config/inputs.h"

#include <chrono>

#include <gmock/gmock.h>

#include "core/io/file.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A room of 6 x 6 m, made of every kind of file that a world can be made of.
class Inputs : public SystemTest {
 protected:
  void SetUp() override {
    SystemTest::SetUp();
    std::string cells;
    for (int row = 0; row < 60; ++row) {
      for (int column = 0; column < 60; ++column) {
        const bool wall = row == 0 || column == 0 || row == 59 || column == 59;
        cells += static_cast<char>(wall ? 0 : 254);
      }
    }
    write("plan.pgm", "P5\n60 60\n255\n" + cells);
    write("plan.yaml",
          "image: plan.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n"
          "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
    const fs::path office = fs::path(PANOPTES_SOURCE_DIR) / "assets" / "office";
    for (const char* name : {"wall.png", "floor.png", "crate.png", "block.png"}) {
      const bool is_wall = name == std::string("wall.png");  // not to be taken for floor
      fs::copy_file(office / (is_wall ? "wall.png" : "carpet_sand.png"), folder_ / "work" / name);
    }
    write("block.obj",
          "mtllib block.mtl\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\n"
          "vt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
    write("block.mtl", "newmtl paint\nKd 1 1 1\nmap_Kd block.png\n");
    write("included.yaml",
          "name: crates\nboxes: [{name: crate, size_m: [0.5, 0.5, 0.5], at: {x_m: 1, y_m: 1}, "
          "picture: crate.png}]\n");
    write("world.yaml",
          "name: small\nambient: 1\ninclude: [included.yaml]\n"
          "floor_plan: {map: plan.yaml, height_m: 1, wall: wall.png, floor: floor.png}\n"
          "objects: [{name: block, mesh: block.obj, at: {x_m: 4.5, y_m: 4.5}}]\n");
    for (const char* name : {"rig.yaml", "robot.yaml"}) {
      const std::string from =
          name == std::string("rig.yaml") ? "rigs/front-back-floor.yaml" : "robots/pioneer3dx.yaml";
      write(name, read_file(kScenes + from));
    }
    write("m.yaml",
          "rig: rig.yaml\nrobot: robot.yaml\ndrive: none\nuntil: {duration_s: 0.3}\n"
          "platform: {kind: simulated, world: world.yaml, start: {x_m: 3, y_m: 3}}\n");
  }

  Said trials() const {
    return panoptes({"trials", "m.yaml", "--seeds", "1", "--quiet", "--out", "t"});
  }
  std::string full(const std::string& name) const {
    return fs::canonical(folder_ / "work" / name).string();
  }
};

TEST_F(Inputs, AreEveryFileThatWasReadAndTheProgram) {
  const Said nowhere = explore("m.yaml", "nothing", {"--inputs", "/nosuch/x"});
  EXPECT_EQ(nowhere.status, 2);
  EXPECT_EQ(
      nowhere.err,
      "--inputs /nosuch/x: cannot be created: No such file or directory; name another file\n");
  EXPECT_FALSE(fs::exists(folder_ / "work" / "nothing"));
  EXPECT_EQ(explore("m.yaml", "within", {"--inputs", "within/made-of.sha256"}).status, 0);
  ASSERT_EQ(explore("m.yaml", "run", {"--inputs", "run.sha256"}).status, 0);
  const auto files = parse_inputs(read_file(folder_ / "work" / "run.sha256"));
  for (const char* name :
       {"m.yaml", "rig.yaml", "robot.yaml", "world.yaml", "included.yaml", "plan.yaml", "plan.pgm",
        "wall.png", "floor.png", "crate.png", "block.obj", "block.mtl", "block.png"}) {
    EXPECT_TRUE(files.contains(full(name))) << name;
  }
  EXPECT_TRUE(files.contains(fs::canonical(PANOPTES_PROGRAM).string()));
}

TEST_F(Inputs, ThatChangedMakeARunAnother) {
  ASSERT_EQ(trials().status, 0);
  const fs::path verdict = folder_ / "work" / "t" / "m" / "1" / "metrics.json";
  const auto made = fs::last_write_time(verdict);
  ASSERT_EQ(trials().status, 0);
  EXPECT_EQ(fs::last_write_time(verdict), made);  // kept
  for (const char* name : {"included.yaml", "plan.yaml", "plan.pgm", "wall.png", "floor.png",
                           "crate.png", "block.obj", "block.mtl", "block.png"}) {
    const std::string before = read_file(folder_ / "work" / name);
    write(name, before + "\n");
    const Said said = trials();
    EXPECT_EQ(said.status, 2) << name;
    EXPECT_EQ(said.err, "t/m/1: holds a run of before " + full(name) +
                            " changed; name another folder with --out\n");
    write(name, before);
  }
  for (const auto& [name, change] : std::map<std::string, std::pair<std::string, std::string>>{
           {"world.yaml", {"ambient: 1", "ambient: 0.9"}},
           {"rig.yaml", {"rate_hz: 15", "rate_hz: 14"}},
           {"robot.yaml", {"max_speed_mps: 0.6", "max_speed_mps: 0.5"}}}) {
    const std::string before = read_file(folder_ / "work" / name);
    std::string after = before;
    ASSERT_NE(after.find(change.first), std::string::npos) << name;
    after.replace(after.find(change.first), change.first.size(), change.second);
    write(name, after);
    const Said said = trials();
    EXPECT_EQ(said.status, 2) << name;
    EXPECT_THAT(said.err, HasSubstr("t/m/1: holds a run ")) << name;
    write(name, before);
  }
  ASSERT_EQ(trials().status, 0);
  EXPECT_EQ(fs::last_write_time(verdict), made);
}

TEST_F(Inputs, ThatTheProgramIsOneOf) {
  ASSERT_EQ(trials().status, 0);
  const fs::path listing = folder_ / "work" / "t" / "m" / "1" / "inputs.sha256";
  std::string text;
  for (auto [file, hash] : parse_inputs(read_file(listing))) {
    if (file == fs::canonical(PANOPTES_PROGRAM)) {
      hash.front() = hash.front() == '0' ? '1' : '0';  // as one built from other sources has
    }
    text += inputs_text({{file, hash}});
  }
  write_file(listing, text);
  const Said said = trials();
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "t/m/1: holds a run of another program; name another folder with --out\n");
}

TEST_F(Inputs, CostsBeginWithTheProgramNotWithWhatBecameIt) {
  ASSERT_EQ(explore("m.yaml", "baked", {}).status, 0);
  const auto before = std::chrono::steady_clock::now();
  Fate fate;
  fate.script =
      "hog=$(head -c 150000000 /dev/zero | tr '\\0' x); "
      "end=$((SECONDS + 2)); while [ $SECONDS -lt $end ]; do :; done; "
      "exec \"$0\" \"$@\"";
  const Said said = explore("m.yaml", "run", {}, fate);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;
  EXPECT_EQ(said.status, 0) << said.err;
  constexpr double kBefore_s = 1;  // at least: SECONDS counts whole ones
  EXPECT_LT(metrics("run")["wall_s"], took.count() - kBefore_s);
  EXPECT_LT(metrics("run")["cpu_s"].get<double>(),
            metrics("baked")["cpu_s"].get<double>() + kBefore_s);
  EXPECT_LT(metrics("run")["peak_memory_mb"].get<double>(),
            metrics("baked")["peak_memory_mb"].get<double>() + 50);
}

}  // namespace
}  // namespace panoptes
