// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/keyframe_files.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <opencv2/imgcodecs.hpp>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/crc32.h"
#include "core/io/digits.h"
#include "core/io/file.h"
#include "core/io/picture.h"

namespace panoptes {
namespace {

constexpr const char* kFolder = "keyframes";
constexpr const char* kTable = "keyframes.csv";
constexpr const char* kSignatures = "signatures.bin";
constexpr const char* kFeatures = "features.bin";
constexpr const char* kMaps = "maps.bin";

enum Column : std::size_t {
  kKeyframe,
  kStamp,
  kX,
  kY,
  kTheta,
  kSignature,
  // here the points of each loop camera
  kCell,
  kFirstColumn,
  kFirstRow,
  kMapBytes,
  kCrc,
  kColumns
};
constexpr std::array<const char*, kColumns> kNames{
    "keyframe", "stamp_s",      "x_m",       "y_m",       "theta_deg", "signature",
    "cell_m",   "first_column", "first_row", "map_bytes", "crc32"};
constexpr std::string_view kPointsOf = "_features";  // after where a camera looks
constexpr const char* kGrid = "grid";
constexpr const char* kMosaic = "mosaic";

// Enough to find a place again; with all of them a run of 600 s would take 50 MB instead of 40.
constexpr std::size_t kPoints = 240;
constexpr std::size_t kDescriptor_bytes = 32;
constexpr std::size_t kPoint_bytes = 4 + kDescriptor_bytes;
constexpr std::size_t kShare_bytes = 4;
constexpr float kPerPixel = 8;
constexpr int kNothing = 128;          // of a map's picture: no evidence
constexpr int kMostMapSide = 1 << 14;  // cells: 16 m of millimetres

std::string hexadecimal(std::uint32_t value) {
  std::array<char, 9> digits{};
  std::snprintf(digits.data(), digits.size(), "%08x", value);
  return digits.data();
}

void put_16(std::string& bytes, std::uint16_t value) {
  bytes += static_cast<char>(value & 0xFFU);
  bytes += static_cast<char>(value >> 8U);
}
std::uint16_t get_16(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint16_t>(static_cast<std::uint8_t>(bytes[at]) |
                                    static_cast<std::uint8_t>(bytes[at + 1]) << 8U);
}

void put_32(std::string& bytes, std::uint32_t value) {
  put_16(bytes, static_cast<std::uint16_t>(value & 0xFFFFU));
  put_16(bytes, static_cast<std::uint16_t>(value >> 16U));
}
std::uint32_t get_32(std::string_view bytes, std::size_t at) {
  return get_16(bytes, at) | static_cast<std::uint32_t>(get_16(bytes, at + 2)) << 16U;
}

std::string bytes_of(const PlaceSignature& signature) {
  std::string bytes;
  for (const float share : signature.cumulative) {
    put_32(bytes, std::bit_cast<std::uint32_t>(share));
  }
  return bytes;
}

std::uint16_t eighths(float px) {
  return static_cast<std::uint16_t>(std::clamp(std::lround(kPerPixel * px), 0L, 0xFFFFL));
}

std::size_t points_kept(const LocalFeatures& features) {
  return std::min(features.px.size(), kPoints);
}

// Of more points every so manyth: they come sorted by size.
std::string bytes_of(const LocalFeatures& features) {
  std::string bytes;
  const std::size_t kept = points_kept(features);
  for (std::size_t n = 0; n < kept; ++n) {
    const std::size_t i = n * features.px.size() / kept;
    put_16(bytes, eighths(features.px[i].x()));
    put_16(bytes, eighths(features.px[i].y()));
    bytes.append(features.descriptors.ptr<char>(static_cast<int>(i)), kDescriptor_bytes);
  }
  return bytes;
}
LocalFeatures features_of(std::string_view bytes) {
  LocalFeatures features;
  const std::size_t count = bytes.size() / kPoint_bytes;
  if (count > 0) {
    features.descriptors.create(static_cast<int>(count), kDescriptor_bytes, CV_8U);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view point = bytes.substr(i * kPoint_bytes, kPoint_bytes);
    features.px.emplace_back(get_16(point, 0) / kPerPixel, get_16(point, 2) / kPerPixel);
    std::copy_n(point.data() + 4, kDescriptor_bytes,
                features.descriptors.ptr<char>(static_cast<int>(i)));
  }
  return features;
}

/// A grid as a picture, and where it lies.
struct Drawn {
  int first_column = 0;
  std::string png;
};

Drawn drawn(const GridCrop& grid) {
  Drawn out;
  int end_column = 0;
  bool any = false;
  for (const GridCrop::Row& row : grid.rows) {
    if (row.begin < row.end) {
      out.first_column = any ? std::min(out.first_column, row.begin) : row.begin;
      end_column = any ? std::max(end_column, row.end) : row.end;
      any = true;
    }
  }
  const int rows = std::max<int>(1, static_cast<int>(grid.rows.size()));
  cv::Mat picture(rows, std::max(1, end_column - out.first_column), CV_8UC1, cv::Scalar(kNothing));
  for (std::size_t r = 0; r < grid.rows.size(); ++r) {
    const GridCrop::Row& row = grid.rows[r];
    auto* pixels = picture.ptr<std::uint8_t>(rows - 1 - static_cast<int>(r));
    for (int column = row.begin; column < row.end; ++column) {
      const std::int8_t evidence =
          grid.cells[row.offset + static_cast<std::size_t>(column - row.begin)];
      // adds 128 to what two's complement holds
      pixels[column - out.first_column] = static_cast<std::uint8_t>(evidence) ^ 0x80U;
    }
  }
  std::vector<std::uint8_t> png;
  const std::vector<int> fast{cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_RLE};
  PANOPTES_CHECK(cv::imencode(".png", picture, png, fast), "a grey picture becomes a PNG");
  out.png.assign(png.begin(), png.end());
  return out;
}

GridCrop grid_of(const cv::Mat& picture, double cell_m, int first_column, int first_row) {
  GridCrop grid;
  grid.cell_m = cell_m;
  grid.first_row = first_row;
  for (int r = picture.rows - 1; r >= 0; --r) {
    const auto* begin = picture.ptr<std::uint8_t>(r);
    const auto* end = begin + picture.cols;
    const auto* low = std::find_if(begin, end, [](std::uint8_t p) { return p != kNothing; });
    while (end > low && end[-1] == kNothing) {
      --end;
    }
    grid.rows.push_back({first_column + static_cast<int>(low - begin),
                         first_column + static_cast<int>(end - begin), grid.cells.size()});
    std::transform(low, end, std::back_inserter(grid.cells),
                   [](std::uint8_t p) { return static_cast<std::int8_t>(p ^ 0x80U); });
  }
  return grid;
}

constexpr const char* kCure = "; copy the whole run again or repeat it";

// A file of keyframes one after the other.
class Pile {
 public:
  Pile(std::string name, std::string_view bytes) : name_(std::move(name)), bytes_(bytes) {}

  std::string_view take(std::size_t size) {
    if (size > bytes_.size() - at_) {
      throw fault(bytes_.size(), "the file ends " + std::to_string(size - (bytes_.size() - at_)) +
                                     " bytes before the keyframe that " + kTable + " tells of");
    }
    taken_ = at_;
    at_ += size;
    return bytes_.substr(taken_, size);
  }
  void finish() const {
    if (at_ < bytes_.size()) {
      throw fault(at_, "goes on after the last keyframe that " + std::string(kTable) + " tells of");
    }
  }
  // Of what was taken last.
  ConfigError fault_in(std::size_t byte, const std::string& what) const {
    return fault(taken_ + byte, what);
  }

 private:
  ConfigError fault(std::size_t byte, const std::string& what) const {
    return ConfigError(name_ + ": byte " + std::to_string(byte) + ": " + what + kCure);
  }

  std::string name_;
  std::string_view bytes_;
  std::size_t at_ = 0;
  std::size_t taken_ = 0;
};

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find(',', at), line.size());
    fields.push_back(line.substr(at, end - at));
    at = end + 1;
  }
  return fields;
}

std::vector<std::string> header_of(const std::vector<std::string>& looks) {
  std::vector<std::string> names(kNames.begin(), kNames.end());
  std::vector<std::string> points;
  for (const std::string& look : looks) {
    points.push_back(look + std::string(kPointsOf));
  }
  names.insert(names.begin() + kCell, points.begin(), points.end());
  return names;
}

// A line of the table.
class Row {
 public:
  Row(std::string place, std::string_view text, const std::vector<std::string>& names)
      : place_(std::move(place)),
        text_(text),
        fields_(split(text)),
        names_(names),
        cameras_(names.size() - kColumns) {
    if (fields_.size() != names.size()) {
      throw fault("has " + std::to_string(fields_.size()) + " fields instead of " +
                  std::to_string(names.size()));
    }
  }

  std::string header() const { return joined(names_, ","); }
  std::size_t cameras() const { return cameras_; }
  std::string_view operator[](Column column) const { return fields_[index(column)]; }
  std::string_view before_crc() const {
    return text_.substr(0, text_.size() - fields_.back().size() - 1);
  }
  double number(Column column, double low, double high) const {
    return number(index(column), low, high);
  }
  int whole(Column column, int low, int high) const { return whole(index(column), low, high); }
  std::size_t points(std::size_t camera) const {
    return static_cast<std::size_t>(whole(kCell + camera, 0, kPoints));
  }
  ConfigError fault(Column column, const std::string& what) const {
    return fault(index(column), what);
  }

 private:
  std::size_t index(Column column) const { return column < kCell ? column : column + cameras_; }
  double number(std::size_t field, double low, double high) const {
    const std::optional<double> value = parse_number(fields_[field]);
    if (!value || !(*value >= low && *value <= high)) {
      throw fault(field, "is not a number from " + shortest(low) + " to " + shortest(high));
    }
    return *value;
  }
  int whole(std::size_t field, int low, int high) const {
    const double value = number(field, low, high);
    if (value != std::floor(value)) {
      throw fault(field, "is not a whole number");
    }
    return static_cast<int>(value);
  }
  ConfigError fault(std::size_t field, const std::string& what) const {
    return fault(names_[field] + ": " + what);
  }
  ConfigError fault(const std::string& what) const {
    return ConfigError(place_ + ": " + what + kCure);
  }

  std::string place_;
  std::string_view text_;
  std::vector<std::string_view> fields_;
  const std::vector<std::string>& names_;
  std::size_t cameras_;
};

struct Piles {
  Pile signatures;
  Pile features;
  Pile maps;
};

KeptKeyframe parse_keyframe(const Row& row, int number, Piles& piles) {
  constexpr double kFarthest_m = 1e9;
  constexpr int kFarthestCell = 1'000'000'000;
  row.whole(kKeyframe, number, number);
  KeptKeyframe keyframe;
  const std::optional<Time> stamp = parse_seconds(row[kStamp]);
  if (!stamp) {
    throw row.fault(kStamp, "is no instant in seconds");
  }
  keyframe.stamp = *stamp;
  keyframe.T_map_keyframe = {row.number(kX, -kFarthest_m, kFarthest_m),
                             row.number(kY, -kFarthest_m, kFarthest_m),
                             deg_to_rad(row.number(kTheta, -360, 360))};

  PlaceSignature& signature = keyframe.place.signature;
  signature.grid = row[kSignature] == kGrid;
  if (!signature.grid && row[kSignature] != kMosaic) {
    throw row.fault(kSignature, "is neither grid nor mosaic");
  }
  signature.cumulative.resize(signature_shares(signature.grid, row.cameras()));
  const std::string_view shares = piles.signatures.take(kShare_bytes * signature.cumulative.size());
  for (std::size_t i = 0; i < signature.cumulative.size(); ++i) {
    const auto share = std::bit_cast<float>(get_32(shares, kShare_bytes * i));
    constexpr float kRoundoff = 1e-4F;
    if (!(share >= 0 && share <= 1 + kRoundoff)) {
      throw piles.signatures.fault_in(kShare_bytes * i, "is no share from 0 to 1");
    }
    signature.cumulative[i] = share;
  }

  std::string_view features;
  std::uint32_t crc = crc32(shares, crc32(row.before_crc(), crc32(row.header())));
  for (std::size_t camera = 0; camera < row.cameras(); ++camera) {
    features = piles.features.take(kPoint_bytes * row.points(camera));
    crc = crc32(features, crc);
    keyframe.place.features.push_back(features_of(features));
  }

  const double cell_m = row.number(kCell, 1e-6, kFarthest_m);
  const int first_column = row.whole(kFirstColumn, -kFarthestCell, kFarthestCell);
  const int first_row = row.whole(kFirstRow, -kFarthestCell, kFarthestCell);
  const std::string_view map =
      piles.maps.take(static_cast<std::size_t>(row.whole(kMapBytes, 0, kFarthestCell)));
  try {
    keyframe.grid = std::make_shared<const GridCrop>(grid_of(
        decode_picture(map, kMostMapSide, PictureColours::kGrey), cell_m, first_column, first_row));
  } catch (const ConfigError&) {
    throw piles.maps.fault_in(0, "the map of keyframe " + std::to_string(number) + " is no PNG");
  }
  if (row[kCrc] != hexadecimal(crc32(map, crc))) {
    throw row.fault(kCrc, "says otherwise than the keyframe's bytes in this table, " +
                              std::string(kSignatures) + ", " + kFeatures + " and " + kMaps);
  }
  return keyframe;
}

}  // namespace

KeyframeFiles keyframe_files(const KeptKeyframes& keyframes) {
  KeyframeFiles files;
  const std::string header = joined(header_of(keyframes.looks), ",");
  files.table = header + "\n";
  for (std::size_t k = 0; k < keyframes.all.size(); ++k) {
    const KeptKeyframe& keyframe = keyframes.all[k];
    PANOPTES_CHECK(keyframe.place.features.size() == keyframes.looks.size(),
                   "a picture a loop camera");
    const Pose2& T_map_keyframe = keyframe.T_map_keyframe;
    const Drawn map = drawn(*keyframe.grid);
    const std::string signature = bytes_of(keyframe.place.signature);
    std::vector<std::string> fields{std::to_string(k),
                                    seconds(keyframe.stamp),
                                    shortest(T_map_keyframe.x_m),
                                    shortest(T_map_keyframe.y_m),
                                    shortest(rad_to_deg(T_map_keyframe.theta_rad)),
                                    keyframe.place.signature.grid ? kGrid : kMosaic};
    std::string features;
    for (const LocalFeatures& points : keyframe.place.features) {
      features += bytes_of(points);
      fields.push_back(std::to_string(points_kept(points)));
    }
    for (const std::string& field :
         {shortest(keyframe.grid->cell_m), std::to_string(map.first_column),
          std::to_string(keyframe.grid->first_row), std::to_string(map.png.size())}) {
      fields.push_back(field);
    }
    const std::string row = joined(fields, ",");
    const std::uint32_t crc =
        crc32(map.png, crc32(features, crc32(signature, crc32(row, crc32(header)))));
    files.table += joined({row, hexadecimal(crc)}, ",") + "\n";
    files.signatures += signature;
    files.features += features;
    files.maps += map.png;
  }
  return files;
}

KeptKeyframes parse_keyframes(const std::string& folder, const KeyframeFiles& files) {
  const auto file = [&](const char* name) {
    return (std::filesystem::path(folder) / name).string();
  };
  Piles piles{{file(kSignatures), files.signatures},
              {file(kFeatures), files.features},
              {file(kMaps), files.maps}};
  KeptKeyframes keyframes;
  std::vector<std::string> names;
  int line = 0;
  for (std::size_t at = 0; line == 0 || at < files.table.size();) {
    const std::string place = file(kTable) + ":" + std::to_string(++line);
    const std::size_t end = files.table.find('\n', at);
    if (end == std::string::npos) {
      throw ConfigError(place + ": the line was cut off" + kCure);
    }
    const std::string_view text = std::string_view(files.table).substr(at, end - at);
    at = end + 1;
    if (line > 1) {
      keyframes.all.push_back(parse_keyframe(Row(place, text, names), line - 2, piles));
      continue;
    }
    std::vector<std::string>& looks = keyframes.looks;
    looks.clear();
    for (const std::string_view field : split(text)) {
      if (field.ends_with(kPointsOf)) {
        looks.emplace_back(field.substr(0, field.size() - kPointsOf.size()));
      }
    }
    names = header_of(looks);
    if (looks.empty() || text != joined(names, ",")) {
      throw ConfigError(place + ": other columns than this version keeps; repeat the run with it");
    }
  }
  for (const Pile* pile : {&piles.signatures, &piles.features, &piles.maps}) {
    pile->finish();
  }
  return keyframes;
}

void write_keyframes(const std::filesystem::path& run_dir, const KeptKeyframes& keyframes) {
  const std::filesystem::path folder = run_dir / kFolder;
  std::error_code fault;
  std::filesystem::create_directories(folder, fault);
  if (fault) {
    throw IoError(folder.string() + ": cannot be made: " + fault.message());
  }
  const KeyframeFiles files = keyframe_files(keyframes);
  write_file(folder / kSignatures, files.signatures);
  write_file(folder / kFeatures, files.features);
  write_file(folder / kMaps, files.maps);
  write_file(folder / kTable, files.table);
}

KeptKeyframes read_keyframes(const std::filesystem::path& run_dir) {
  const std::filesystem::path folder = run_dir / kFolder;
  const auto bytes = [&](const char* name) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(folder / name, ignored)) {
      throw ConfigError((folder / name).string() + ": no such file" + kCure);
    }
    return read_file(folder / name);
  };
  return parse_keyframes(folder.string(),
                         {bytes(kTable), bytes(kSignatures), bytes(kFeatures), bytes(kMaps)});
}

}  // namespace panoptes
