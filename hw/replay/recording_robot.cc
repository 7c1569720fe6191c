// SPDX-License-Identifier: BSD-3-Clause
#include "hw/replay/recording_robot.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/io/dataset_table.h"
#include "core/io/dataset_writer.h"
#include "core/io/digits.h"
#include "core/io/file.h"
#include "core/odometry/odometry_source.h"
#include "hw/replay/truth_files.h"

namespace panoptes::hw {
namespace {

namespace fs = std::filesystem;

struct Seen {
  Observation observation;
  Time now;
  std::optional<Truth> news;
  std::map<std::string, TruePicture> true_pictures;
};
using Job = std::variant<Seen, RecordedCommand>;

RecordingInfo with_timing(RecordingInfo info, const Timing& timing) {
  info.timing = timing;
  return info;
}

}  // namespace

/// Writes what it is given, in order, on a thread of its own.
class RecordingRobot::Writer {
 public:
  Writer(const fs::path& folder, const RecordingInfo& info, const Rig& rig, const Body& body,
         const std::optional<Truth>& truth, const std::vector<std::string>& things)
      : folder_(folder), rig_(rig), writer_(folder, info, rig, body) {
    if (truth) {
      truth_.emplace(folder, *truth);
    }
    if (!things.empty()) {
      write_file(folder / "mav0" / "things.csv", things_csv(things));
    }
    thread_ = std::thread([this] { write_all(); });
  }

  ~Writer() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  bool with_truth() const { return truth_.has_value(); }
  std::size_t poses() const { return poses_; }
  std::size_t contacts() const { return contacts_; }

  void add(Job job) {
    constexpr std::size_t kBehind = 16;  // half of them frame sets: a few MB
    if (const Seen* seen = std::get_if<Seen>(&job); seen != nullptr && seen->news) {
      poses_ += seen->news->poses.size();
      contacts_ += seen->news->contacts.size();
    }
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return jobs_.size() < kBehind || fault_; });
    if (fault_) {
      std::rethrow_exception(fault_);
    }
    jobs_.push_back(std::move(job));
    lock.unlock();
    changed_.notify_all();
  }

  void finish() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return (jobs_.empty() && !writing_) || fault_; });
    if (fault_) {
      std::rethrow_exception(fault_);
    }
  }

 private:
  void write_all() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return !jobs_.empty() || ended_; });
      if (jobs_.empty() || fault_) {
        return;
      }
      const Job job = std::move(jobs_.front());
      jobs_.pop_front();
      writing_ = true;
      lock.unlock();
      std::exception_ptr fault;
      try {
        std::visit([this](const auto& one) { write(one); }, job);
      } catch (const IoError& error) {
        fault = std::make_exception_ptr(
            IoError(std::string(error.what()) + (whole_until_ ? "; the recording is whole until " +
                                                                    seconds(*whole_until_) + " s"
                                                              : "; nothing is recorded")));
      } catch (...) {
        fault = std::current_exception();
      }
      lock.lock();
      writing_ = false;
      fault_ = fault;
      changed_.notify_all();
      if (fault_) {
        return;
      }
    }
  }

  // The observation's own row is the last one: with it the frame set is whole.
  void write(const Seen& seen) {
    for (const auto& [name, picture] : seen.true_pictures) {
      write(name, picture);
    }
    if (seen.news) {
      truth_->add(seen.observation.stamp, *seen.news);
      for (const TrueContact& contact : seen.news->contacts) {
        writer_.add_event(contact.stamp, "contact", contact.object,
                          contact.while_moving ? "moving" : "standing");
      }
    }
    writer_.add(seen.observation, seen.now);
    whole_until_ = seen.now;
  }

  void write(const RecordedCommand& command) { writer_.add(command); }

  void write(const std::string& camera, const TruePicture& picture) {
    const auto keep = [&](const char* kind, const cv::Mat& pixels, const std::string& comment) {
      if (pixels.empty()) {
        return;
      }
      const std::string name = camera + kind;
      auto at = true_folders_.find(name);
      if (at == true_folders_.end()) {
        at = true_folders_
                 .emplace(name, PictureFolder(folder_ / "mav0" / name, PictureFolder::Kind::kFlat))
                 .first;
        write_file(folder_ / "mav0" / name / "sensor.yaml",
                   "sensor_type: ground_truth\ncomment: \"" + comment + "\"\n");
      }
      at->second.add(picture.stamp, pixels);
    };
    if (!picture.depth_m.empty()) {
      keep("_depth", millimetres(picture.depth_m),
           depth_comment(rig_.cameras.at(camera).intrinsics));
    }
    keep("_labels", picture.instance, "16 bit, the thing's number in mav0/things.csv");
    keep("_floor", picture.floor_label, "8 bit, 255 on what is below 2 cm");
  }

  fs::path folder_;
  Rig rig_;
  DatasetWriter writer_;
  std::optional<TruthWriter> truth_;
  std::map<std::string, PictureFolder> true_folders_;
  std::optional<Time> whole_until_;
  std::size_t poses_ = 0;  // of the truth, given to be written
  std::size_t contacts_ = 0;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;
  std::exception_ptr fault_;
  bool writing_ = false;
  bool ended_ = false;
  std::thread thread_;
};

RecordingRobot::RecordingRobot(std::unique_ptr<Robot> robot, fs::path folder,
                               const RecordingInfo& info, const Rig& rig, const Body& body,
                               TruePictures true_pictures, bool keep_truth)
    : robot_(std::move(robot)),
      true_pictures_(std::move(true_pictures)),
      writer_(std::make_unique<Writer>(folder, with_timing(info, robot_->timing()), rig, body,
                                       keep_truth ? robot_->truth() : std::nullopt,
                                       true_pictures_.things)) {}

RecordingRobot::~RecordingRobot() = default;

Observation RecordingRobot::observe(Time deadline) {
  Seen seen;
  seen.observation = robot_->observe(deadline);
  seen.now = robot_->now();
  if (!is_finite(seen.observation.odometry)) {
    throw DeviceError(fmt::format(
        "odometry: no number at {} s, and a recording without numbers could not be driven again; "
        "what was recorded until then is whole",
        seconds(seen.observation.stamp)));
  }
  if (writer_->with_truth()) {
    seen.news = robot_->truth_since(writer_->poses(), writer_->contacts());
  }
  if (true_pictures_.of_last_set && !seen.observation.pictures.empty()) {
    seen.true_pictures = true_pictures_.of_last_set();
  }
  Observation observation = seen.observation;
  writer_->add(std::move(seen));
  return observation;
}

void RecordingRobot::drive(const Twist2& command_body, Duration valid_for) {
  robot_->drive(command_body, valid_for);
  writer_->add(RecordedCommand{robot_->now(), command_body, valid_for});
}

void RecordingRobot::stop() { robot_->stop(); }
Time RecordingRobot::now() const { return robot_->now(); }
std::optional<Truth> RecordingRobot::truth() const { return robot_->truth(); }
void RecordingRobot::finish() { writer_->finish(); }

}  // namespace panoptes::hw
