// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/picture.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>
#include <system_error>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/crc32.h"

namespace panoptes {
namespace {

constexpr std::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);
constexpr std::string_view kNoPicture =
    "is not a picture that can be read; save it again as PNG or JPEG";
constexpr std::string_view kDamaged = "is damaged or cut short; save it again as PNG or JPEG";

// The headers are read here, by hand: a size must be known to be bearable before anything is
// decoded, and OpenCV 4.6 reads no header alone.
std::uint32_t byte_at(std::string_view bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes[at]);
}
std::uint32_t big_endian(std::string_view bytes, std::size_t at) {
  return byte_at(bytes, at) << 24U | byte_at(bytes, at + 1) << 16U | byte_at(bytes, at + 2) << 8U |
         byte_at(bytes, at + 3);
}
std::uint32_t little_endian(std::string_view bytes, std::size_t at) {
  return byte_at(bytes, at + 3) << 24U | byte_at(bytes, at + 2) << 16U |
         byte_at(bytes, at + 1) << 8U | byte_at(bytes, at);
}

std::optional<PictureSize> size_of(std::uint32_t width, std::uint32_t height) {
  constexpr std::uint32_t kMost = 1U << 30U;
  if (width == 0 || height == 0 || width > kMost || height > kMost) {
    return std::nullopt;
  }
  return PictureSize{static_cast<int>(width), static_cast<int>(height)};
}

std::optional<PictureSize> png_size(std::string_view bytes) {
  if (bytes.size() < 24 || !bytes.starts_with(kPngSignature) || bytes.substr(12, 4) != "IHDR") {
    return std::nullopt;
  }
  return size_of(big_endian(bytes, 16), big_endian(bytes, 20));
}

std::optional<PictureSize> jpeg_size(std::string_view bytes) {
  if (!bytes.starts_with("\xff\xd8")) {
    return std::nullopt;
  }
  std::size_t at = 2;
  while (at + 4 <= bytes.size() && byte_at(bytes, at) == 0xff) {
    const std::uint32_t marker = byte_at(bytes, at + 1);
    if (marker == 0xff) {
      ++at;
      continue;
    }
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame) {
      return at + 9 > bytes.size() ? std::nullopt
                                   : size_of(byte_at(bytes, at + 7) << 8U | byte_at(bytes, at + 8),
                                             byte_at(bytes, at + 5) << 8U | byte_at(bytes, at + 6));
    }
    at += 2 + (byte_at(bytes, at + 2) << 8U | byte_at(bytes, at + 3));
  }
  return std::nullopt;
}

/// Of a bitmap that is not compressed and whole: OpenCV writes to the terminal about others.
std::optional<PictureSize> bmp_size(std::string_view bytes) {
  if (bytes.size() < 54 || !bytes.starts_with("BM") || little_endian(bytes, 14) < 40) {
    return std::nullopt;
  }
  const std::uint32_t height = little_endian(bytes, 22);  // negative when its top row is first
  const std::optional<PictureSize> size =
      size_of(little_endian(bytes, 18), (height >> 31U) != 0 ? ~height + 1 : height);
  const std::uint32_t bits = byte_at(bytes, 28);
  if (!size || little_endian(bytes, 30) != 0 || little_endian(bytes, 46) > 256 ||
      byte_at(bytes, 29) != 0 || (bits != 8 && bits != 24 && bits != 32)) {
    return std::nullopt;
  }
  const std::uint64_t row_bytes = (static_cast<std::uint64_t>(size->width_px) * bits + 31) / 32 * 4;
  const std::uint64_t end =
      little_endian(bytes, 10) + row_bytes * static_cast<std::uint64_t>(size->height_px);
  return end <= bytes.size() ? size : std::nullopt;
}

/// A portable anymap: its header, and where the pixels begin.
struct Anymap {
  bool text = false;
  int channels = 1;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t most = 1;
  std::size_t pixels_at = 0;
};

/// The next number of an anymap, behind white space and comments.
std::optional<std::uint32_t> next_number(std::string_view bytes, std::size_t& at) {
  while (at < bytes.size()) {
    if (bytes[at] == '#') {
      at = std::min(bytes.find('\n', at), bytes.size());
    } else if (std::isspace(static_cast<unsigned char>(bytes[at])) != 0) {
      ++at;
    } else {
      break;
    }
  }
  std::uint32_t value = 0;
  const char* const begin = bytes.data() + at;
  const auto [end, error] = std::from_chars(begin, bytes.data() + bytes.size(), value);
  if (error != std::errc()) {
    return std::nullopt;
  }
  at += static_cast<std::size_t>(end - begin);
  return value;
}

std::optional<Anymap> anymap_header(std::string_view bytes) {
  if (bytes.size() < 3 || bytes[0] != 'P' ||
      std::string_view("2356").find(bytes[1]) == std::string_view::npos) {
    return std::nullopt;
  }
  Anymap map;
  map.text = bytes[1] == '2' || bytes[1] == '3';
  map.channels = bytes[1] == '3' || bytes[1] == '6' ? 3 : 1;
  std::size_t at = 2;
  for (std::uint32_t* field : {&map.width, &map.height, &map.most}) {
    const std::optional<std::uint32_t> number = next_number(bytes, at);
    if (!number) {
      return std::nullopt;
    }
    *field = *number;
  }
  map.pixels_at = at + 1;  // one white space ends the header
  if (map.most == 0 || map.most > 65535 || map.pixels_at > bytes.size()) {
    return std::nullopt;
  }
  return map;
}

/// Our own reader: OpenCV's writes to the terminal about files that are cut short.
cv::Mat decode_anymap(std::string_view bytes, const Anymap& header) {
  const auto width = static_cast<int>(header.width);
  const auto height = static_cast<int>(header.height);
  const std::size_t samples = static_cast<std::size_t>(header.width) * header.height *
                              static_cast<std::size_t>(header.channels);
  const std::size_t sample_bytes = header.text ? 2 : header.most > 255 ? 2 : 1;  // text: "0 "
  if (bytes.size() - header.pixels_at + (header.text ? 1 : 0) < samples * sample_bytes) {
    throw ConfigError(std::string(kDamaged));
  }
  cv::Mat pixels(height, width, CV_8UC(header.channels));
  std::size_t at = header.pixels_at;
  unsigned char* out = pixels.data;
  for (std::size_t i = 0; i < samples; ++i) {
    std::uint32_t value = 0;
    if (header.text) {
      const std::optional<std::uint32_t> number = next_number(bytes, at);
      if (!number) {
        throw ConfigError(std::string(kDamaged));
      }
      value = *number;
    } else {
      value = byte_at(bytes, at++);
      if (sample_bytes == 2) {
        value = value << 8U | byte_at(bytes, at++);
      }
    }
    out[i] = static_cast<unsigned char>((255ULL * std::min(value, header.most) + header.most / 2) /
                                        header.most);
  }
  if (header.channels == 3) {
    cv::cvtColor(pixels, pixels, cv::COLOR_RGB2BGR);
  }
  return pixels;
}

/// A PNG with what its pixels need alone. Colour profiles and the like, about which libpng writes
/// to the terminal, are left out; a wrong checksum or end is said.
std::string bare_png(std::string_view bytes) {
  std::string bare(kPngSignature);
  bool has_pixels = false;
  std::size_t at = kPngSignature.size();
  while (at + 12 <= bytes.size()) {
    const std::size_t length = big_endian(bytes, at);
    if (length > bytes.size() - at - 12) {
      break;
    }
    const std::string_view kind = bytes.substr(at + 4, 4);
    if (kind == "IHDR" || kind == "PLTE" || kind == "tRNS" || kind == "IDAT" || kind == "IEND") {
      if (crc32(bytes.substr(at + 4, length + 4)) != big_endian(bytes, at + 8 + length)) {
        break;
      }
      bare.append(bytes.substr(at, length + 12));
      has_pixels = has_pixels || kind == "IDAT";
    }
    if (kind == "IEND" && has_pixels) {
      return bare;
    }
    at += length + 12;
  }
  throw ConfigError(std::string(kDamaged));
}

bool is_picture(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::array<std::string_view, 7> kEndings{".jpg", ".jpeg", ".png", ".bmp",
                                                     ".pgm", ".ppm",  ".pnm"};
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

}  // namespace

std::vector<std::string> pictures_in(const std::filesystem::path& folder) {
  std::vector<std::string> files;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (entry.is_regular_file(ignored) && is_picture(entry.path())) {
      files.push_back(entry.path().string());
    }
  }
  std::sort(files.begin(), files.end(), natural_less);
  return files;
}

std::optional<PictureSize> picture_size(std::string_view bytes) {
  if (const std::optional<Anymap> map = anymap_header(bytes)) {
    return size_of(map->width, map->height);
  }
  for (const auto& size : {png_size(bytes), jpeg_size(bytes), bmp_size(bytes)}) {
    if (size) {
      return size;
    }
  }
  return std::nullopt;
}

cv::Mat decode_picture(std::string_view bytes, int most_side_px, PictureColours colours) {
  const std::optional<PictureSize> size = picture_size(bytes);
  if (!size) {
    throw ConfigError(std::string(kNoPicture));
  }
  if (size->width_px > most_side_px || size->height_px > most_side_px) {
    throw ConfigError("is " + std::to_string(size->width_px) + " x " +
                      std::to_string(size->height_px) + " pixels; make it at most " +
                      std::to_string(most_side_px) + " wide and high");
  }
  cv::Mat pixels;
  if (const std::optional<Anymap> map = anymap_header(bytes)) {
    pixels = decode_anymap(bytes, *map);
    if (colours == PictureColours::kGrey && pixels.channels() == 3) {
      cv::cvtColor(pixels, pixels, cv::COLOR_BGR2GRAY);
    } else if (colours == PictureColours::kBgr && pixels.channels() == 1) {
      cv::cvtColor(pixels, pixels, cv::COLOR_GRAY2BGR);
    }
    return pixels;
  }
  std::string whole = bytes.starts_with(kPngSignature) ? bare_png(bytes) : std::string(bytes);
  if (whole.starts_with("\xff\xd8") && whole.rfind("\xff\xd9") == std::string::npos) {
    throw ConfigError(std::string(kDamaged));
  }
  const cv::Mat encoded(1, static_cast<int>(whole.size()), CV_8U, whole.data());
  pixels = cv::imdecode(
      encoded, (colours == PictureColours::kGrey ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR) |
                   cv::IMREAD_IGNORE_ORIENTATION);
  if (pixels.empty()) {
    throw ConfigError(std::string(kDamaged));
  }
  return pixels;
}

}  // namespace panoptes
