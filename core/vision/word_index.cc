// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/word_index.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr int kExamples = 16;  // descriptors a word to learn from
constexpr int kRounds = 4;     // of k-majority: more change little
constexpr int kBytes = 32;     // a descriptor
constexpr int kBlock = 256;    // descriptors compared at once: their distances stay in the cache

// The row of `words` that is nearest to each row of `descriptors`, the first of equals.
std::vector<std::uint16_t> nearest(const cv::Mat& descriptors, const cv::Mat& words) {
  std::vector<std::uint16_t> rows;
  rows.reserve(descriptors.rows);
  for (int first = 0; first < descriptors.rows; first += kBlock) {
    const int until = std::min(first + kBlock, descriptors.rows);
    const std::vector<std::int16_t> bits =
        descriptor_distances_bits(descriptors.rowRange(first, until), words);
    for (auto row = bits.begin(); row != bits.end(); row += words.rows) {
      rows.push_back(static_cast<std::uint16_t>(std::min_element(row, row + words.rows) - row));
    }
  }
  return rows;
}

// Of each bit what most of a word's examples have; a word without examples stays as it is.
void move_to_majority(const cv::Mat& examples, const std::vector<std::uint16_t>& word_of,
                      cv::Mat& words) {
  std::vector<std::array<int, 8 * kBytes>> set(words.rows);
  std::vector<int> members(words.rows, 0);
  for (int row = 0; row < examples.rows; ++row) {
    const std::uint8_t* bytes = examples.ptr(row);
    ++members[word_of[row]];
    for (int bit = 0; bit < 8 * kBytes; ++bit) {
      set[word_of[row]][bit] += bytes[bit / 8] >> (bit % 8) & 1;
    }
  }
  for (int word = 0; word < words.rows; ++word) {
    for (int bit = 0; bit < 8 * kBytes && members[word] > 0; ++bit) {
      const int mask = 1 << (bit % 8);
      std::uint8_t& byte = words.ptr(word)[bit / 8];
      byte = static_cast<std::uint8_t>(2 * set[word][bit] > members[word] ? byte | mask
                                                                          : byte & ~mask);
    }
  }
}

}  // namespace

WordIndex::WordIndex(int words, int cameras, Rng rng)
    : count_(words), cameras_(cameras), rng_(rng) {
  PANOPTES_CHECK(words >= 1 && words <= 1 << 16, "words have numbers of 16 bits");
  PANOPTES_CHECK(cameras >= 1, "a camera");
}

void WordIndex::add(const PlaceFeatures& features) {
  PANOPTES_CHECK(static_cast<int>(features.size()) == cameras_, "a picture a camera");
  for (const LocalFeatures& picture : features) {
    descriptors_.push_back(picture.descriptors);
    known_ += picture.descriptors.rows;
  }
  shown_.resize(descriptors_.size());
  if (known_ >= std::max(kExamples * count_, 2 * learned_)) {
    learn();
  } else if (!words_.empty()) {
    for (int camera = 0; camera < cameras_; ++camera) {
      enter(cameras_ * (size() - 1) + camera);
    }
  }
}

void WordIndex::learn() {
  // as many examples as are needed, evenly from all that was seen
  const int wanted = kExamples * count_;
  cv::Mat examples(0, kBytes, CV_8U);
  examples.reserve(wanted);
  std::int64_t seen = 0;
  for (const cv::Mat& picture : descriptors_) {
    for (int row = 0; row < picture.rows; ++row, ++seen) {
      if (seen * wanted / known_ >= examples.rows) {
        examples.push_back(picture.row(row));
      }
    }
  }
  Rng rng = rng_.fork(std::to_string(known_));
  std::vector<int> order(examples.rows);
  std::iota(order.begin(), order.end(), 0);
  words_ = cv::Mat(0, kBytes, CV_8U);
  for (int word = 0; word < count_; ++word) {
    std::swap(order[word], order[word + rng.index(examples.rows - word)]);
    words_.push_back(examples.row(order[word]));
  }
  for (int round = 0; round < kRounds; ++round) {
    move_to_majority(examples, nearest(examples, words_), words_);
  }
  learned_ = known_;
  pictures_with_.assign(count_, {});
  for (int picture = 0; picture < cameras_ * size(); ++picture) {
    enter(picture);
  }
}

void WordIndex::enter(int picture) {
  shown_[picture] = nearest(descriptors_[picture], words_);
  std::vector<int> count(count_, 0);
  for (const std::uint16_t word : shown_[picture]) {
    ++count[word];
  }
  for (int word = 0; word < count_; ++word) {
    if (count[word] > 0) {
      pictures_with_[word].push_back({picture, count[word]});
    }
  }
}

std::vector<std::vector<double>> WordIndex::shared(int place, int until,
                                                   const std::vector<Facing>& facings) const {
  PANOPTES_CHECK(place >= 0 && place < size() && until <= size(), "places that are remembered");
  std::vector<std::vector<double>> shares(std::max(0, until),
                                          std::vector<double>(facings.size(), 0));
  // by facing and camera of the earlier place: the cameras of `place` that show the same
  std::vector<std::vector<int>> partners(facings.size() * cameras_);
  for (std::size_t facing = 0; facing < facings.size(); ++facing) {
    for (const CameraPair& pair : facings[facing].pairs) {
      partners[facing * cameras_ + pair.a].push_back(pair.b);
    }
  }
  // of each word, camera by camera
  std::vector<int> counts(static_cast<std::size_t>(count_) * cameras_, 0);
  for (int camera = 0; camera < cameras_; ++camera) {
    for (const std::uint16_t word : shown_[cameras_ * place + camera]) {
      ++counts[cameras_ * word + camera];
    }
  }
  double all = 0;
  for (int word = 0; word < count_; ++word) {
    const std::span count(counts.begin() + cameras_ * word, cameras_);
    const int shown = std::accumulate(count.begin(), count.end(), 0);
    if (shown == 0) {
      continue;
    }
    const std::vector<Entry>& entries = pictures_with_[word];
    const double rare =
        std::log(static_cast<double>(cameras_) * size() / static_cast<double>(entries.size()));
    all += rare * shown;
    for (const Entry& entry : entries) {
      if (entry.picture >= cameras_ * until) {
        break;
      }
      std::vector<double>& share = shares[entry.picture / cameras_];
      const int camera = entry.picture % cameras_;
      for (std::size_t facing = 0; facing < facings.size(); ++facing) {
        for (const int partner : partners[facing * cameras_ + camera]) {
          share[facing] += rare * std::min(entry.count, count[partner]);
        }
      }
    }
  }
  for (std::vector<double>& share : shares) {
    for (double& of_facing : share) {
      of_facing /= std::max(all, 1e-300);
    }
  }
  return shares;
}

}  // namespace panoptes
