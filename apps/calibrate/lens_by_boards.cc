// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/lens_by_boards.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/io/file.h"
#include "core/io/picture.h"

namespace panoptes {
namespace {

/// What one picture shows.
struct Looked {
  std::optional<BoardCorners> corners;
  int width_px = 0;
  int height_px = 0;
  std::vector<double> brightness;  // of each part of the picture, in grey levels
  std::string fault;
};

Looked look_at(const std::string& file, const Board& board) {
  Looked looked;
  try {
    const cv::Mat grey =
        decode_picture(read_file(file), kMostPictureSide_px, PictureColours::kGrey);
    looked.width_px = grey.cols;
    looked.height_px = grey.rows;
    cv::Mat parts;
    cv::resize(grey, parts, cv::Size(kPartsAcross, kPartsDown), 0, 0, cv::INTER_AREA);
    for (int row = 0; row < parts.rows; ++row) {
      for (int column = 0; column < parts.cols; ++column) {
        looked.brightness.push_back(parts.at<std::uint8_t>(row, column));
      }
    }
    looked.corners = find_board(grey, board);
  } catch (const ConfigError& error) {
    const std::string what = error.what();
    looked.fault = what.starts_with(file) ? what : file + ": " + what;
  }
  return looked;
}

std::vector<std::string> evenly(const std::vector<std::string>& files, int most) {
  if (static_cast<int>(files.size()) <= most) {
    return files;
  }
  std::vector<std::string> some;
  for (int i = 0; i < most; ++i) {
    some.push_back(files[files.size() * static_cast<std::size_t>(i) / most]);
  }
  return some;
}

/// Parts where a fisheye draws nothing stay as dark as the darkest in every picture.
std::vector<bool> lit_parts(const std::vector<Looked>& all) {
  std::vector<double> brightest(kPartsAcross * kPartsDown, 0);
  for (const Looked& looked : all) {
    for (std::size_t part = 0; part < looked.brightness.size(); ++part) {
      brightest[part] = std::max(brightest[part], looked.brightness[part]);
    }
  }
  constexpr double kDark = 0.1;  // of what the brightest part gets
  const double most = *std::max_element(brightest.begin(), brightest.end());
  std::vector<bool> lit;
  for (const double grey : brightest) {
    lit.push_back(grey > kDark * most);
  }
  return lit;
}

}  // namespace

LensByBoards lens_by_boards(const LensByBoardsOptions& options, const CameraPictures& pictures,
                            const std::function<void(double)>& progress) {
  LensByBoards told;
  told.camera = pictures.camera;
  told.pictures = pictures.files.size();
  told.looked_at = evenly(pictures.files, options.most_pictures);
  std::vector<Looked> all(told.looked_at.size());
  std::atomic<std::size_t> next{0};
  std::size_t done = 0;
  std::mutex telling;
  std::exception_ptr thrown;
  const auto look = [&] {
    try {
      for (std::size_t i = next++; i < all.size(); i = next++) {
        all[i] = look_at(told.looked_at[i], options.board);
        const std::scoped_lock lock(telling);
        progress(static_cast<double>(++done) / static_cast<double>(all.size()));
      }
    } catch (...) {
      next = all.size();  // the others stop, too
      const std::scoped_lock lock(telling);
      thrown = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int i = 1; i < options.num_threads; ++i) {
      helpers.emplace_back(look);
    }
    look();
  }
  if (thrown) {
    std::rethrow_exception(thrown);
  }
  std::vector<std::string> faults;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Looked& looked = all[i];
    if (!looked.fault.empty()) {
      faults.push_back(looked.fault);
      continue;
    }
    if (told.width_px == 0) {
      told.width_px = looked.width_px;
      told.height_px = looked.height_px;
    } else if (looked.width_px != told.width_px || looked.height_px != told.height_px) {
      faults.push_back(fmt::format(
          "{}: is {} x {} pixels and others are {} x {}; give pictures of one camera and one size",
          told.looked_at[i], looked.width_px, looked.height_px, told.width_px, told.height_px));
    }
    if (looked.corners) {
      told.with_board.push_back(i);
      told.corners.push_back(*looked.corners);
    }
  }
  if (!faults.empty()) {
    throw ConfigError(faults);
  }
  const std::vector<bool> lit = lit_parts(all);
  told.fit = options.model ? fit_lens(options.fit, options.board, told.corners, told.width_px,
                                      told.height_px, *options.model, lit)
                           : fit_best_lens(options.fit, options.board, told.corners, told.width_px,
                                           told.height_px, lit);
  return told;
}

}  // namespace panoptes
