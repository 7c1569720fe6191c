// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/dataset.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <opencv2/imgcodecs.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/config/geometry_fields.h"
#include "core/io/dataset_table.h"
#include "core/io/digits.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kOdometry = "mav0/odom0/data.csv";
constexpr std::string_view kCommands = "mav0/cmd0/data.csv";
constexpr std::string_view kEvents = "mav0/events.csv";

// Between two rows of one drive: a robot of ours answers within a minute (frame_deadline_s).
constexpr Duration kLongestGap = std::chrono::hours(1);
// What odometry may jump besides, where stamps are rough.
constexpr double kJump_m = 1;

std::string in_folder(const std::string& folder, std::string_view file) {
  return (fs::path(folder) / file).string();
}

template <class T>
std::optional<T> settings(const std::string& folder, const DatasetText& text, const char* file) {
  const std::optional<std::string> found = text(file);
  return found ? std::optional<T>(read_settings_text<T>(*found, in_folder(folder, file)))
               : std::nullopt;
}

RecordedBeliefs beliefs(const std::string& folder, const DatasetText& text) {
  return {settings<RecordingInfo>(folder, text, "recording.yaml"),
          settings<Rig>(folder, text, "rig.yaml"), settings<Body>(folder, text, "robot.yaml")};
}

ConfigError no_odometry(const std::string& folder, const std::vector<std::string>& cameras) {
  return ConfigError(folder + ": has pictures of " +
                     (cameras.empty() ? "no camera" : joined(cameras)) + " but no " +
                     std::string(kOdometry) +
                     " (#timestamp [ns], x [m], y [m], theta [rad], v [m/s], w [rad/s]): the "
                     "wheels' odometry at the instant of each picture is needed");
}

/// What happened at an observation besides what its row of odometry says.
struct Event {
  std::size_t row;
  Time stamp;
  std::string kind;
  std::string subject;
  std::string value;
};

/// Reads one table after the other, and what they say of each other.
class Reader {
 public:
  Reader(const std::string& folder, const std::vector<std::string>& cameras,
         const DatasetText& text)
      : folder_(folder), text_(text) {
    dataset_.folder = folder;
    dataset_.cameras = cameras;
  }

  Dataset read() {
    const std::optional<DatasetTable> odometry = table(kOdometry, 6);
    if (!odometry) {
      throw no_odometry(folder_, dataset_.cameras);
    }
    if (dataset_.cameras.empty()) {
      throw ConfigError(folder_ + ": has no pictures: no mav0/<camera>/data.csv is there");
    }
    for (const std::string& camera : dataset_.cameras) {
      read_camera(camera);
    }
    read_events();
    for (std::size_t row = 0; row < odometry->size(); ++row) {
      observe(*odometry, row);
    }
    if (next_event_ < events_.size() && !dataset_.observations.empty() &&
        events_[next_event_].stamp <= dataset_.observations.back().stamp) {
      throw no_row_for(events_[next_event_]);
    }
    look_at_what_is_left();
    if (dataset_.observations.empty()) {
      throw ConfigError(in_folder(folder_, kOdometry) + ": holds no observation");
    }
    read_commands();
    dataset_.believed = beliefs(folder_, text_);
    return std::move(dataset_);
  }

 private:
  struct Camera {
    std::optional<DatasetTable> table;
    std::vector<RecordedPicture> pictures;
    std::size_t next = 0;
  };

  std::optional<DatasetTable> table(std::string_view file, std::size_t columns) {
    const std::optional<std::string> text = text_(std::string(file));
    if (!text) {
      return std::nullopt;
    }
    DatasetTable read(in_folder(folder_, file), *text, columns);
    if (read.torn()) {
      dataset_.remarks.push_back(read.file() +
                                 ": the last row is torn, for the recording was cut short; it is "
                                 "left out");
    }
    return read;
  }

  void read_camera(const std::string& name) {
    const std::string folder = "mav0/" + name;
    std::optional<DatasetTable> rows = table(folder + "/data.csv", 2);
    if (!rows) {
      throw ConfigError(in_folder(folder_, folder) + ": has no data.csv");
    }
    Camera& camera = cameras_[name];
    for (std::size_t row = 0; row < rows->size(); ++row) {
      const Time stamp = rows->stamp(row, 0);
      const std::string& file = rows->text(row, 1);
      if (!camera.pictures.empty() && stamp <= camera.pictures.back().stamp) {
        throw rows->fault(row, "is not after the row before");
      }
      if (file.empty() || file.find('/') != std::string::npos || file == "." || file == "..") {
        throw rows->fault(row, "must name a file of data/");
      }
      camera.pictures.push_back({stamp, folder + "/data/" + file, rows->place(row)});
    }
    camera.table = std::move(rows);
  }

  void read_events() {
    events_table_ = table(kEvents, 4);
    if (!events_table_) {
      return;
    }
    const DatasetTable& rows = *events_table_;
    static constexpr std::array<std::string_view, 7> kKinds = {
        "deadline", "now", "bumper", "motors", "picture", "missing", "contact"};
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const std::string& kind = rows.text(row, 1);
      if (std::find(kKinds.begin(), kKinds.end(), kind) == kKinds.end()) {
        throw rows.fault(row,
                         "no such event; known are deadline, now, bumper, motors, picture, "
                         "missing and contact");
      }
      if (kind != "contact") {  // a matter of the truth
        events_.push_back({row, rows.stamp(row, 0), kind, rows.text(row, 2), rows.text(row, 3)});
      }
    }
  }

  bool flag(const Event& event) const {
    if (event.value != "0" && event.value != "1") {
      throw events_table_->fault(event.row, event.kind + " must be 0 or 1");
    }
    return event.value == "1";
  }

  // Pictures of the observation's own instant are its own, and those that its events name.
  void observe(const DatasetTable& odometry, std::size_t row) {
    RecordedObservation seen;
    seen.stamp = seen.now = odometry.stamp(row, 0);
    seen.odometry.T_odom_body = {odometry.bounded(row, 1, kFarthest_m),
                                 odometry.bounded(row, 2, kFarthest_m),
                                 odometry.bounded(row, 3, kMostTurned_rad)};
    seen.odometry.twist_body = {odometry.bounded(row, 4, kFastest_mps),
                                odometry.bounded(row, 5, kFastest_radps)};
    bool waited = false;
    std::map<std::string, std::size_t> named;  // rows of events
    for (bool first = true; next_event_ < events_.size(); ++next_event_, first = false) {
      const Event& event = events_[next_event_];
      if (event.stamp != seen.stamp || (event.kind == "deadline" && !first)) {
        break;  // the next one's
      }
      if (event.kind == "deadline") {
        waited = true;
      } else if (event.kind == "now") {
        seen.now = events_table_->stamp(event.row, 3);
      } else if (event.kind == "bumper") {
        health_.bumper_pressed = flag(event);
      } else if (event.kind == "motors") {
        health_.motors_enabled = flag(event);
      } else if (event.kind == "picture") {
        if (!cameras_.contains(event.subject)) {
          throw events_table_->fault(event.row, "there is no camera " + event.subject);
        }
        named[event.subject] = event.row;
      }
    }
    seen.health = health_;
    check_follows(odometry, row, seen);
    if (!waited && next_event_ < events_.size() && events_[next_event_].stamp < seen.stamp) {
      throw no_row_for(events_[next_event_]);
    }
    for (auto& [name, camera] : cameras_) {
      const auto other = named.find(name);
      const Time stamp = other == named.end() ? seen.stamp : events_table_->stamp(other->second, 3);
      const RecordedPicture* next =
          waited || camera.next == camera.pictures.size() ? nullptr : &camera.pictures[camera.next];
      if (next != nullptr && next->stamp < stamp) {
        throw no_row_for(*next, "before " + odometry.place(row));
      }
      if (next != nullptr && next->stamp == stamp) {
        seen.pictures.emplace(name, *next);
        ++camera.next;
      } else if (other != named.end()) {
        throw events_table_->fault(other->second,
                                   "there is no such picture in the data.csv of " + name);
      }
    }
    dataset_.observations.push_back(std::move(seen));
  }

  static ConfigError no_row_for(const RecordedPicture& picture, const std::string& where) {
    return ConfigError(picture.mention + ": no row " + where +
                       " has this picture's instant; one is needed at each picture, in the order "
                       "of time");
  }

  ConfigError no_row_for(const Event& event) const {
    return events_table_->fault(event.row,
                                "no row of " + std::string(kOdometry) + " has this instant");
  }

  // Rows are in the order they were handed over in, as far apart as a robot on wheels gets.
  void check_follows(const DatasetTable& odometry, std::size_t row,
                     const RecordedObservation& seen) const {
    if (std::chrono::abs(seen.now - seen.stamp) > kLongestGap) {
      throw odometry.fault(row, "is over an hour away from its \"now\" in " + std::string(kEvents));
    }
    if (dataset_.observations.empty()) {
      if (std::chrono::abs(seen.now.time_since_epoch()) > kLongestGap) {
        throw odometry.fault(row,
                             "is over an hour away from 0, when a run begins; subtract it from "
                             "every time stamp of the dataset, and from its pictures' names");
      }
      return;
    }
    const RecordedObservation& before = dataset_.observations.back();
    if (seen.now < before.now) {
      throw odometry.fault(row, "is before the row before; rows must be in the order of time");
    }
    if (seen.now - before.now > kLongestGap) {
      throw odometry.fault(row,
                           "is over an hour after the row before; that is no single drive: cut the "
                           "dataset there, or mend the stamp");
    }
    const double way_m =
        (seen.odometry.T_odom_body.position() - before.odometry.T_odom_body.position()).norm();
    const double time_s = std::abs(to_seconds(seen.stamp - before.stamp));
    if (way_m > kJump_m + kFastest_mps * time_s) {
      throw odometry.fault(row, "jumps " + shortest(way_m) + " m in " + shortest(time_s) +
                                    " s; no robot on wheels is faster than " +
                                    shortest(kFastest_mps) + " m/s: mend or remove what is wrong");
    }
  }

  // Pictures that no observation took, after the last one that could have: the frame set that was
  // being written.
  void look_at_what_is_left() {
    std::size_t taken = 0;
    std::size_t left = 0;
    const RecordedPicture* first_left = nullptr;
    for (const auto& [name, camera] : cameras_) {
      taken += camera.next;
      left += camera.pictures.size() - camera.next;
      first_left =
          camera.next < camera.pictures.size() ? &camera.pictures[camera.next] : first_left;
    }
    if (taken == 0 && left > 0) {
      throw no_row_for(*first_left, "of " + std::string(kOdometry));
    }
    if (left > 0) {
      dataset_.remarks.push_back(in_folder(folder_, "mav0") + ": " + std::to_string(left) +
                                 " pictures of an incomplete frame set at the end are left out");
    }
  }

  void read_commands() {
    const std::optional<DatasetTable> rows = table(kCommands, 4);
    if (!rows) {
      return;
    }
    for (std::size_t row = 0; row < rows->size(); ++row) {
      const Time stamp = rows->stamp(row, 0);
      if (!dataset_.commands.empty() && stamp < dataset_.commands.back().stamp) {
        throw rows->fault(row, "is before the row before");
      }
      dataset_.commands.push_back(
          {stamp, {rows->finite(row, 1), rows->finite(row, 2)}, Duration(rows->whole(row, 3))});
    }
  }

  std::string folder_;
  const DatasetText& text_;
  Dataset dataset_;
  std::map<std::string, Camera> cameras_;
  std::optional<DatasetTable> events_table_;
  std::vector<Event> events_;
  std::size_t next_event_ = 0;
  Health health_;
};

DatasetText text_of(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw ConfigError(folder.string() +
                      (fs::exists(folder, error) ? ": is not a folder" : ": no such folder"));
  }
  if (!fs::is_directory(folder / "mav0", error)) {
    throw ConfigError(folder.string() +
                      ": is no dataset: it has no folder mav0 (the EuRoC layout, as panoptes "
                      "record writes it)");
  }
  return [folder](const std::string& file) { return read_part(folder / file); };
}

// The folders of mav0 that hold a camera's pictures: not the truth's, nor other sensors'.
std::vector<std::string> camera_folders(const fs::path& mav) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(mav, error)) {
    if (fs::is_directory(entry.path() / "data", error)) {
      names.push_back(entry.path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  std::vector<std::string> cameras;
  for (const std::string& name : names) {
    const bool of_truth = std::any_of(names.begin(), names.end(), [&](const std::string& camera) {
      return name == camera + "_depth" || name == camera + "_labels" || name == camera + "_floor";
    });
    if (!of_truth) {
      cameras.push_back(name);
    }
  }
  return cameras;
}

ConfigError picture_fault(const Dataset& dataset, const RecordedPicture& picture,
                          const std::string& what) {
  return ConfigError(picture.mention + ": " + in_folder(dataset.folder, picture.file) + " " + what);
}

/// An open file that closes itself.
class OpenFile {
 public:
  explicit OpenFile(const std::string& path) : fd_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~OpenFile() {
    if (fd_ >= 0) {
      ::close(fd_);
    }
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

int big_endian(const unsigned char* bytes) {
  return static_cast<int>((static_cast<unsigned>(bytes[0]) << 24U) |
                          (static_cast<unsigned>(bytes[1]) << 16U) |
                          (static_cast<unsigned>(bytes[2]) << 8U) | bytes[3]);
}

}  // namespace

void bind(Fields& f, RecordingInfo& o) {
  f.needed("schema", o.schema);
  f.require(o.schema == kDatasetSchema, "schema",
            "must be " + std::string(kDatasetSchema) + ", the one this version reads");
  f("version", o.version);
  f("mission", o.mission);
  f("seed", o.seed);
}

std::optional<std::string> read_part(const fs::path& file) {
  std::error_code none;
  if (!fs::exists(file, none)) {
    return std::nullopt;
  }
  if (!fs::is_regular_file(file, none)) {
    throw ConfigError(file.string() + ": is not a file");
  }
  return read_file(file);
}

Dataset parse_dataset(const std::string& folder, const std::vector<std::string>& cameras,
                      const DatasetText& text) {
  return Reader(folder, cameras, text).read();
}

Dataset read_dataset(const fs::path& folder) {
  const DatasetText text = text_of(folder);
  return parse_dataset(folder.string(), camera_folders(folder / "mav0"), text);
}

RecordedBeliefs read_beliefs(const fs::path& folder) {
  const DatasetText text = text_of(folder);
  std::error_code error;
  if (!fs::exists(folder / kOdometry, error)) {
    throw no_odometry(folder.string(), camera_folders(folder / "mav0"));
  }
  return beliefs(folder.string(), text);
}

void check_pictures(const Dataset& dataset, const Rig& rig) {
  constexpr std::array<unsigned char, 8> kBegin{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  constexpr std::array<unsigned char, 4> kEnd{'I', 'E', 'N', 'D'};
  // signature, length and name of IHDR, width, height, bits of a sample
  constexpr std::size_t kHead = 25;
  constexpr std::size_t kTail = 8;  // name and checksum of IEND
  for (const RecordedObservation& seen : dataset.observations) {
    for (const auto& [name, picture] : seen.pictures) {
      const OpenFile file(in_folder(dataset.folder, picture.file));
      if (file.fd() < 0) {
        throw picture_fault(dataset, picture, errno == ENOENT ? "is not there" : "cannot be read");
      }
      struct stat status {};
      std::array<unsigned char, kHead> head{};
      std::array<unsigned char, kTail> tail{};
      const bool whole =
          ::fstat(file.fd(), &status) == 0 && status.st_size >= static_cast<off_t>(kHead + kTail) &&
          ::pread(file.fd(), head.data(), kHead, 0) == kHead &&
          ::pread(file.fd(), tail.data(), kTail, status.st_size - static_cast<off_t>(kTail)) ==
              kTail;
      if (!whole || !std::equal(kBegin.begin(), kBegin.end(), head.begin())) {
        throw picture_fault(dataset, picture, "is not a PNG picture");
      }
      if (!std::equal(kEnd.begin(), kEnd.end(), tail.begin())) {
        throw picture_fault(dataset, picture, "is torn: the end of the PNG picture is missing");
      }
      if (head[24] > 8) {
        throw picture_fault(dataset, picture,
                            "has " + std::to_string(head[24]) +
                                " bits a sample; save the camera's pictures with 8 (mogrify -depth "
                                "8 of ImageMagick does it)");
      }
      const auto camera = rig.cameras.find(name);
      const int width = big_endian(head.data() + 16);
      const int height = big_endian(head.data() + 20);
      if (camera != rig.cameras.end() && (width != camera->second.intrinsics.width_px ||
                                          height != camera->second.intrinsics.height_px)) {
        throw picture_fault(dataset, picture,
                            "has " + std::to_string(width) + " x " + std::to_string(height) +
                                " pixels, the rig's " + name + " has " +
                                std::to_string(camera->second.intrinsics.width_px) + " x " +
                                std::to_string(camera->second.intrinsics.height_px));
      }
    }
  }
}

cv::Mat read_picture(const Dataset& dataset, const RecordedPicture& picture) {
  cv::Mat bgr;
  try {
    const std::string bytes = read_file(in_folder(dataset.folder, picture.file));
    if (!bytes.empty()) {
      const cv::Mat view(1, static_cast<int>(bytes.size()), CV_8UC1,
                         const_cast<char*>(bytes.data()));
      bgr = cv::imdecode(view, cv::IMREAD_COLOR);
    }
  } catch (const cv::Exception&) {  // said below
    bgr.release();
  }
  if (bgr.empty()) {
    throw picture_fault(dataset, picture, "cannot be decoded: it is no whole picture");
  }
  return bgr;
}

}  // namespace panoptes
