// SPDX-License-Identifier: BSD-3-Clause
// Cameras that deliver from threads of their own, on a robot whose base is no Pioneer.
#include "hw/camera_source.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "hw/physical/physical_robot.h"
#include "tests/hw/physical/fake_base.h"

namespace panoptes::hw {
namespace {

using std::chrono::milliseconds;

constexpr Duration kLong = std::chrono::seconds(60);  // nobody waits for it
constexpr Duration kSoon = std::chrono::seconds(20);  // of a machine that is busy

class FakeCameras final : public CameraSource {
 public:
  ~FakeCameras() override {
    done_ = true;
    if (thread_.joinable()) {
      thread_.join();
    }
  }

  void start(std::function<Time()> now, std::function<void()> arrived) override {
    now_ = std::move(now);
    arrived_ = std::move(arrived);
    if (every_ > Duration::zero()) {
      thread_ = std::thread([this] {
        while (!done_) {
          post();
          std::this_thread::sleep_for(every_);
        }
      });
    }
  }

  std::optional<CameraSet> next() override {
    const std::lock_guard lock(mutex_);
    if (sets_.empty()) {
      return std::nullopt;
    }
    CameraSet set = sets_.front();
    sets_.pop_front();
    taken_.notify_all();
    return set;
  }

  /// On any thread: a set of now, or a while ago, has arrived.
  Time post(Duration ago = {}) {
    const Time stamp = now_() - ago;
    {
      const std::lock_guard lock(mutex_);
      sets_.push_back({stamp, {{"front", {stamp, {}}}}});
      posted_.push_back(stamp);
    }
    arrived_();
    return stamp;
  }

  /// On a thread of its own, as soon as it is started.
  void post_every(Duration every) { every_ = every; }

  /// Whether all that was posted is taken in time.
  bool taken_within(Duration time) {
    std::unique_lock lock(mutex_);
    return taken_.wait_for(lock, time, [&] { return sets_.empty(); });
  }

  std::vector<Time> posted() {
    const std::lock_guard lock(mutex_);
    return posted_;
  }

 private:
  std::function<Time()> now_;
  std::function<void()> arrived_;
  Duration every_{};
  std::mutex mutex_;
  std::condition_variable taken_;
  std::deque<CameraSet> sets_;
  std::vector<Time> posted_;
  std::atomic<bool> done_ = false;
  std::thread thread_;
};

struct Sighted {
  explicit Sighted(Duration every = {}, Duration first_ago = {}) {
    auto made_base = std::make_unique<FakeBase>();
    auto made_cameras = std::make_unique<FakeCameras>();
    base = made_base.get();
    cameras = made_cameras.get();
    cameras->post_every(every);
    base->report({{base->now() - first_ago, {}, {}, 0}});
    robot = std::make_unique<PhysicalRobot>(std::move(made_base), std::move(made_cameras));
  }

  FakeBase* base = nullptr;
  FakeCameras* cameras = nullptr;
  std::unique_ptr<PhysicalRobot> robot;
};

// Its base reports nothing meanwhile, and has reported so long ago that nothing is known of now.
TEST(CameraSource, WakesARobotThatWaits) {
  Sighted sighted({}, std::chrono::seconds(10));
  const Time before = sighted.robot->now();
  Time posted;
  bool taken = false;
  std::thread devices([&] {
    sighted.base->until_waited_for();
    posted = sighted.cameras->post();
    taken = sighted.cameras->taken_within(kSoon);
    sighted.base->report(
        {{posted - milliseconds(10), {}, {}, 0}, {posted + milliseconds(10), {0.2, 0, 0}, {}, 0}});
  });
  const Observation seen = sighted.robot->observe(sighted.robot->now() + kLong);
  devices.join();
  EXPECT_TRUE(taken);
  EXPECT_EQ(seen.stamp, posted);
  EXPECT_TRUE(seen.pictures.contains("front"));
  EXPECT_FALSE(seen.odometry.extrapolated);
  EXPECT_EQ(sighted.robot->devices().at("cameras").at("sets"), 1);
  // By one clock.
  EXPECT_GE(posted, before);
  EXPECT_LE(posted, sighted.robot->now());
}

TEST(CameraSource, IsNotWaitedForBeyondTheDeadline) {
  Sighted sighted;
  const Time deadline = sighted.robot->now() + milliseconds(20);
  const Observation seen = sighted.robot->observe(deadline);
  EXPECT_TRUE(seen.pictures.empty());
  EXPECT_GE(sighted.robot->now(), deadline);
}

TEST(CameraSource, IsNotHeldUpByASetThatIsOlderThanEveryReport) {
  Sighted sighted;
  sighted.cameras->post(std::chrono::seconds(5));
  const Time posted = sighted.cameras->post();
  sighted.base->report({{posted + milliseconds(10), {}, {}, 0}});
  const Observation seen = sighted.robot->observe(sighted.robot->now() + kLong);
  EXPECT_EQ(seen.stamp, posted);
  EXPECT_FALSE(seen.pictures.empty());
}

// The cameras go on while the robot is taken down.
TEST(CameraSource, LosesNoSetWhereBaseAndCamerasReportFromTheirOwnThreads) {
  constexpr std::size_t kSets = 200;
  Sighted sighted(milliseconds(2));
  std::atomic<bool> done = false;
  std::thread reports([&] {
    while (!done) {
      const Time now = sighted.base->now();
      sighted.base->report({{now, {0.1 * to_seconds(now), 0, 0}, {0.1, 0}, 0}});
      std::this_thread::sleep_for(milliseconds(5));
    }
  });
  std::vector<Time> seen;
  while (seen.size() < kSets && sighted.robot->now() < Time(kLong)) {
    const Observation one = sighted.robot->observe(sighted.robot->now() + kSoon);
    EXPECT_TRUE(one.pictures.contains("front"));
    seen.push_back(one.stamp);
  }
  done = true;
  reports.join();
  std::vector<Time> posted = sighted.cameras->posted();
  sighted.robot.reset();
  ASSERT_GE(posted.size(), kSets);
  posted.resize(kSets);
  EXPECT_EQ(seen, posted);
}

}  // namespace
}  // namespace panoptes::hw
