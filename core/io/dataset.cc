// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/dataset.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <unordered_set>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/config/geometry_fields.h"
#include "core/io/dataset_rows.h"
#include "core/io/dataset_table.h"
#include "core/io/file.h"
#include "core/io/frame_set_assembly.h"
#include "core/io/picture.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kCommands = "mav0/cmd0/data.csv";
constexpr std::string_view kEvents = "mav0/events.csv";

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
  std::string message =
      folder + ": has pictures of " + (cameras.empty() ? "no camera" : joined(cameras)) +
      " but no " + std::string(kOdometryFile) +
      " (#timestamp [ns], x [m], y [m], theta [rad], v [m/s], w [rad/s]; the last "
      "two may be absent): the wheels' odometry is needed, at whatever instants, "
      "from the first pictures to the last";
  if (!cameras.empty()) {
    message += "; without it panoptes loops " +
               in_folder(folder, "mav0/" + cameras.front() + "/data") +
               " finds places by their looks alone";
  }
  return ConfigError(message);
}

std::string torn(const std::string& file) {
  return file + ": the last row is torn, for the recording was cut short; it is left out";
}

// What stands before the first comma of each row.
std::unordered_set<std::string> first_fields(const std::optional<std::string>& text) {
  std::unordered_set<std::string> fields;
  std::string_view rest = text ? std::string_view(*text) : std::string_view();
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    const std::size_t comma = line.find(',');
    if (comma != std::string_view::npos && !line.starts_with('#')) {
      fields.emplace(line.substr(0, comma));
    }
  }
  return fields;
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

  Dataset read(const Rig& rig) {
    if (!text_(std::string(kOdometryFile))) {
      throw no_odometry(folder_, dataset_.cameras);
    }
    if (dataset_.cameras.empty()) {
      throw ConfigError(folder_ + ": has no pictures: no mav0/<camera>/data.csv is there");
    }
    dataset_.ours = is_ours();
    if (dataset_.ours) {
      read_ours();
    } else {
      assemble_observations(dataset_, rig, text_);
    }
    dataset_.believed = beliefs(folder_, text_);
    return std::move(dataset_);
  }

 private:
  struct Camera {
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
      dataset_.warnings.push_back(torn(read.file()));
    }
    return read;
  }

  // It has files that nobody else writes, and most rows of its odometry are of a picture's instant
  // or an event's; one that was changed afterwards is as another program's.
  bool is_ours() const {
    if (!text_("recording.yaml") && !text_(std::string(kEvents)) &&
        !text_(std::string(kCommands))) {
      return false;
    }
    std::unordered_set<std::string> instants = first_fields(text_(std::string(kEvents)));
    for (const std::string& camera : dataset_.cameras) {
      instants.merge(first_fields(text_(data_csv(camera))));
    }
    const std::unordered_set<std::string> rows = first_fields(text_(std::string(kOdometryFile)));
    const auto of_an_instant = std::count_if(
        rows.begin(), rows.end(), [&](const std::string& row) { return instants.contains(row); });
    return 2 * static_cast<std::size_t>(of_an_instant) >= rows.size();
  }

  void read_ours() {
    const DatasetTable odometry = *table(kOdometryFile, 6);
    if (odometry.size() > 0 &&
        std::chrono::abs(odometry.stamp(0, 0).time_since_epoch()) > kLongestGap) {
      dataset_.epoch = odometry.stamp(0, 0).time_since_epoch();
    }
    for (const std::string& camera : dataset_.cameras) {
      read_camera(camera);
    }
    read_events();
    for (std::size_t row = 0; row < odometry.size(); ++row) {
      observe(odometry, row);
    }
    if (next_event_ < events_.size() && !dataset_.observations.empty() &&
        events_[next_event_].stamp <= dataset_.observations.back().stamp) {
      throw no_row_for(events_[next_event_]);
    }
    look_at_what_is_left();
    if (dataset_.observations.empty()) {
      throw ConfigError(odometry.file() + ": holds no observation");
    }
    read_commands();
  }

  // On the clock of the run.
  Time stamp(const DatasetTable& rows, std::size_t row, std::size_t column) const {
    return rows.stamp(row, column) - dataset_.epoch;
  }

  void read_camera(const std::string& name) {
    const std::optional<DatasetTable> rows = table(data_csv(name), 2);
    if (!rows) {
      throw no_pictures(folder_, name);
    }
    Camera& camera = cameras_[name];
    camera.pictures = picture_rows(*rows, name);
    for (RecordedPicture& picture : camera.pictures) {
      picture.stamp -= dataset_.epoch;
    }
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
        events_.push_back({row, stamp(rows, row, 0), kind, rows.text(row, 2), rows.text(row, 3)});
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
    seen.stamp = seen.now = stamp(odometry, row, 0);
    seen.odometry = odometry_row(odometry, row);
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
        seen.now = stamp(*events_table_, event.row, 3);
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
      const Time taken =
          other == named.end() ? seen.stamp : stamp(*events_table_, other->second, 3);
      const RecordedPicture* next =
          waited || camera.next == camera.pictures.size() ? nullptr : &camera.pictures[camera.next];
      if (next != nullptr && next->stamp < taken) {
        throw no_row_for(*next, "before " + odometry.place(row));
      }
      if (next != nullptr && next->stamp == taken) {
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
                                "no row of " + std::string(kOdometryFile) + " has this instant");
  }

  // Rows are in the order they were handed over in, as far apart as a robot on wheels gets.
  void check_follows(const DatasetTable& odometry, std::size_t row,
                     const RecordedObservation& seen) const {
    if (std::chrono::abs(seen.now - seen.stamp) > kLongestGap) {
      throw odometry.fault(row, "is over an hour away from its \"now\" in " + std::string(kEvents));
    }
    if (dataset_.observations.empty()) {
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
    check_speed(odometry, row, before.odometry, seen.odometry, seen.stamp - before.stamp);
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
      throw no_row_for(*first_left, "of " + std::string(kOdometryFile));
    }
    if (left > 0) {
      dataset_.warnings.push_back(in_folder(folder_, "mav0") + ": " + std::to_string(left) +
                                  " pictures of an incomplete frame set at the end are left out");
    }
  }

  void read_commands() {
    const std::optional<DatasetTable> rows = table(kCommands, 4);
    if (!rows) {
      return;
    }
    for (std::size_t row = 0; row < rows->size(); ++row) {
      const Time told = stamp(*rows, row, 0);
      if (!dataset_.commands.empty() && told < dataset_.commands.back().stamp) {
        throw rows->fault(row, "is before the row before");
      }
      dataset_.commands.push_back(
          {told, {rows->finite(row, 1), rows->finite(row, 2)}, Duration(rows->whole(row, 3))});
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

}  // namespace

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

namespace {

// What may be done about a picture that is not whole.
constexpr std::string_view kPictureCure =
    ": copy it again from where it was recorded, or remove its row";

ConfigError picture_fault(const std::string& folder, const RecordedPicture& picture,
                          const std::string& what) {
  return ConfigError(picture.mention + ": " + in_folder(folder, picture.file) + " " + what);
}

cv::Mat decoded(const std::string& folder, const RecordedPicture& picture, PictureColours colours) {
  const std::string bytes = read_file(in_folder(folder, picture.file));
  try {
    return decode_picture(bytes, kMostPictureSide_px, colours);
  } catch (const ConfigError& error) {
    throw picture_fault(folder, picture, error.what());
  } catch (const cv::Exception&) {
    throw picture_fault(folder, picture,
                        "is no whole picture and cannot be decoded" + std::string(kPictureCure));
  }
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

/// The first and the last bytes of a picture.
struct PictureEnds {
  std::string head;
  std::string tail;
};

PictureEnds ends_of(const std::string& folder, const RecordedPicture& picture) {
  constexpr off_t kHead = 64;
  constexpr off_t kTail = 4096;  // some cameras pad their files
  const OpenFile file(in_folder(folder, picture.file));
  if (file.fd() < 0) {
    throw picture_fault(
        folder, picture,
        (errno == ENOENT ? "is not there" : "cannot be read") + std::string(kPictureCure));
  }
  struct stat status {};
  if (::fstat(file.fd(), &status) != 0 || !S_ISREG(status.st_mode)) {
    throw picture_fault(folder, picture, "is not a file" + std::string(kPictureCure));
  }
  const auto read = [&](off_t from, off_t bytes) {
    std::string part(static_cast<std::size_t>(bytes), '\0');
    if (::pread(file.fd(), part.data(), part.size(), from) != bytes) {
      throw picture_fault(folder, picture, "cannot be read");
    }
    return part;
  };
  PictureEnds ends{read(0, std::min(status.st_size, kHead)), {}};
  ends.tail = read(std::max<off_t>(0, status.st_size - kTail), std::min(status.st_size, kTail));
  if (ends.head.starts_with("\xff\xd8") && !picture_size(ends.head)) {
    ends.head = read(0, status.st_size);  // its size stands behind what the camera says of itself
  }
  return ends;
}

// What is wrong with a picture as far as its ends tell; empty where nothing is.
std::string fault_of(const PictureEnds& ends) {
  constexpr std::string_view kPngEnd = "IEND\xae\x42\x60\x82";
  constexpr std::size_t kPngBits = 24;  // of a sample
  const bool is_png = ends.head.starts_with("\x89PNG\r\n\x1a\n");
  const bool is_jpeg = ends.head.starts_with("\xff\xd8");
  if ((!is_png && !is_jpeg) || !picture_size(ends.head) || ends.head.size() <= kPngBits) {
    return "is not a PNG or JPEG picture" + std::string(kPictureCure);
  }
  if (is_png && !ends.tail.ends_with(kPngEnd)) {
    return "is torn, the end of the PNG picture is missing" + std::string(kPictureCure);
  }
  if (is_jpeg && ends.tail.rfind("\xff\xd9") == std::string::npos) {
    return "is torn, the end of the JPEG picture is missing" + std::string(kPictureCure);
  }
  const int bits = is_png ? static_cast<unsigned char>(ends.head[kPngBits]) : 8;
  return bits <= 8 ? ""
                   : "has " + std::to_string(bits) +
                         " bits a sample; save the camera's pictures with 8 (mogrify -depth "
                         "8 of ImageMagick does it)";
}

/// Throws for a picture that is no whole one as far as its ends tell, or not of its lens's size, of
/// which others may have been.
void check_picture(const std::string& folder, const RecordedPicture& picture,
                   const std::string& camera, const Intrinsics* lens, bool others_fit = false) {
  const PictureEnds ends = ends_of(folder, picture);
  if (const std::string fault = fault_of(ends); !fault.empty()) {
    throw picture_fault(folder, picture, fault);
  }
  const PictureSize size = picture_size(ends.head).value();
  if (lens != nullptr && (size.width_px != lens->width_px || size.height_px != lens->height_px)) {
    throw picture_fault(
        folder, picture,
        fmt::format("has {} x {} pixels, the rig's {} has {} x {}{}", size.width_px, size.height_px,
                    camera, lens->width_px, lens->height_px,
                    others_fit ? ", as the pictures before it" + std::string(kPictureCure)
                               : ": give the rig file that these pictures were taken with"));
  }
}

}  // namespace

void bind(Fields& f, Timing& o) {
  const auto seconds = [&f](const char* key, Duration& value) {
    double s = to_seconds(value);
    f.needed(key, s, not_negative);
    value = from_seconds(s);
  };
  seconds("period_s", o.period);
  seconds("worst_latency_s", o.worst_latency);
}

Timing recorded_timing(const Dataset& dataset) {
  if (dataset.believed.info && dataset.believed.info->timing) {
    return *dataset.believed.info->timing;
  }
  Timing timing;
  std::vector<Duration> cycles;
  for (std::size_t i = 0; i < dataset.observations.size(); ++i) {
    const RecordedObservation& seen = dataset.observations[i];
    timing.worst_latency = std::max(timing.worst_latency, seen.now - seen.stamp);
    if (i > 0) {
      cycles.push_back(seen.stamp - dataset.observations[i - 1].stamp);
    }
  }
  if (!cycles.empty()) {
    const auto middle = cycles.begin() + static_cast<std::ptrdiff_t>(cycles.size() / 2);
    std::nth_element(cycles.begin(), middle, cycles.end());
    timing.period = *middle;
  }
  timing.worst_latency += timing.period;
  return timing;
}

void bind(Fields& f, RecordingInfo& o) {
  f.needed("schema", o.schema);
  f.require(o.schema == kDatasetSchema, "schema",
            "must be " + std::string(kDatasetSchema) + ", the one this version reads");
  f("version", o.version);
  f("mission", o.mission);
  f("seed", o.seed);
  f("timing", o.timing);
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

std::optional<std::int64_t> start_unix_ns(const Dataset& dataset) {
  constexpr Duration kYear2000 = std::chrono::seconds(946'684'800);  // no robot has run that long
  return dataset.epoch >= kYear2000 ? std::optional<std::int64_t>(dataset.epoch.count())
                                    : std::nullopt;
}

Dataset parse_dataset(const std::string& folder, const std::vector<std::string>& cameras,
                      const DatasetText& text, const Rig& rig) {
  return Reader(folder, cameras, text).read(rig);
}

Dataset read_dataset(const fs::path& folder, const Rig& rig) {
  const DatasetText text = text_of(folder);
  return parse_dataset(folder.string(), camera_folders(folder / "mav0"), text, rig);
}

std::vector<RecordedPicture> recorded_pictures(const fs::path& folder, const std::string& camera) {
  const std::optional<std::string> text = read_part(folder / data_csv(camera));
  if (!text) {
    throw no_pictures(folder.string(), camera);
  }
  return picture_rows(DatasetTable(in_folder(folder.string(), data_csv(camera)), *text, 2,
                                   written_by(folder.string())),
                      camera);
}

std::string torn_row(const fs::path& folder, const std::string& file) {
  const std::optional<std::string> text = read_part(folder / file);
  const bool is_torn = text && !text->empty() && !text->ends_with('\n') &&
                       written_by(folder.string()) == TableBy::kPanoptes;
  return is_torn ? torn(in_folder(folder.string(), file)) : "";
}

RecordedBeliefs read_beliefs(const fs::path& folder) {
  const DatasetText text = text_of(folder);
  std::error_code error;
  if (!fs::exists(folder / kOdometryFile, error)) {
    throw no_odometry(folder.string(), camera_folders(folder / "mav0"));
  }
  return beliefs(folder.string(), text);
}

void check_pictures(const Dataset& dataset, const Rig& rig) {
  for (const RecordedObservation& seen : dataset.observations) {
    for (const auto& [name, picture] : seen.pictures) {
      const auto camera = rig.cameras.find(name);
      check_picture(dataset.folder, picture, name,
                    camera != rig.cameras.end() ? &camera->second.intrinsics : nullptr);
    }
  }
}

void check_pictures(const fs::path& folder, const std::string& camera, const Intrinsics& lens) {
  bool others_fit = false;
  for (const RecordedPicture& picture : recorded_pictures(folder, camera)) {
    check_picture(folder.string(), picture, camera, &lens, others_fit);
    others_fit = true;
  }
}

cv::Mat read_picture(const Dataset& dataset, const RecordedPicture& picture) {
  return decoded(dataset.folder, picture, PictureColours::kBgr);
}

cv::Mat read_grey_picture(const fs::path& folder, const RecordedPicture& picture) {
  return decoded(folder.string(), picture, PictureColours::kGrey);
}

}  // namespace panoptes
