// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/run_recognition.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace panoptes {
namespace {

constexpr int kSamples = 40;       // pictures that a typical overlap is learned from
constexpr int kLeastSamples = 10;  // fewer say nothing of what is rare
constexpr int kGaps = 3;           // tried a picture that another place is learned from
constexpr int kFastest = 2;        // times the speed of the earlier pass, or one of these of it
constexpr double kFalseARun = 0.01;
// Of what a picture shows: turned by a quarter of the view, or so far on that a quarter of it has
// left it, is another place or heading. A third may be hidden, or not found, where what is found
// would do twice over.
constexpr double kSeenAgain = 0.75;
constexpr double kCertainSeenAgain = 2.0 / 3;
constexpr double kCertain = 2;

double quantile(std::vector<int> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// What one of `count` draws exceeds in one run of 1 / kFalseARun, if the upper half of them falls
// off exponentially.
double seldom_exceeded(const std::vector<int>& drawn, int count) {
  if (std::ssize(drawn) < kLeastSamples) {
    return std::numeric_limits<double>::infinity();
  }
  const double half = quantile(drawn, 0.5);
  const double fall = (quantile(drawn, 0.9) - half) / std::log(0.5 / 0.1);
  return half + std::max(1.0, fall) * std::log(0.5 * count / kFalseARun);
}

bool more_inliers(const PlaceCandidate& a, const PlaceCandidate& b) {
  return a.inliers != b.inliers ? a.inliers > b.inliers : a.place < b.place;
}

class Run {
 public:
  Run(const RecogniserOptions& options, std::vector<PlaceView> views, const Rng& rng)
      : recogniser_(options, rng) {
    for (PlaceView& view : views) {
      recogniser_.add(std::move(view));
    }
  }

  int size() const { return recogniser_.size(); }

  std::vector<PlaceCandidate> query(int picture, int until) {
    std::vector<PlaceCandidate> found = recogniser_.query(recogniser_.place(picture), until);
    for (const PlaceCandidate& candidate : found) {
      compared_[{picture, candidate.place}] = candidate;
    }
    return found;
  }

  const PlaceCandidate& compare(int picture, int earlier) {
    const auto [at, fresh] = compared_.try_emplace({picture, earlier});
    if (fresh) {
      at->second = recogniser_.compare(recogniser_.place(picture), earlier);
    }
    return at->second;
  }
  int inliers(int picture, int earlier) { return compare(picture, earlier).inliers; }

  // Of the pictures before and after with those that they would show on the earlier pass; none
  // vouches for more than the picture shows itself.
  struct Support {
    int inliers = 0;
    double log_chance = 0;  // together with the picture's own
  };
  Support support_of(int picture, int earlier) {
    const int own = inliers(picture, earlier);
    Support support{0, compare(picture, earlier).log_chance};
    for (const int side : {-1, 1}) {
      int most = 0;
      double least_log_chance = 0;
      for (int step = 0; step <= kFastest; ++step) {
        const int neighbour = picture + side;
        const int meets = earlier + side * step;
        if (neighbour < size() && meets >= 0 && meets < neighbour) {
          most = std::max(most, inliers(neighbour, meets));
          least_log_chance = std::min(least_log_chance, compare(neighbour, meets).log_chance);
        }
      }
      support.inliers += std::min(most, own);
      support.log_chance += least_log_chance;
    }
    return support;
  }
  int support(int picture, int earlier) { return support_of(picture, earlier).inliers; }

  // Of the parts of either picture that its neighbours show too, the share that the other one
  // shows: the least of both. What repeats itself, one cupboard of a row or things seen from
  // farther off, agrees with one motion as well as the same place, but is not all there is to see.
  double seen_again(int picture, int earlier, double beyond_chance) {
    const PlaceCandidate& both = compare(picture, earlier);
    return std::min(share_of(both.again_in_view, telling_parts(picture, beyond_chance)),
                    share_of(both.again_in_place, telling_parts(earlier, beyond_chance)));
  }

  // More inliers than the most unlike pictures have, which agree by chance alone: their median and
  // two sigma of a count.
  double beyond_chance() {
    std::vector<int> drawn;
    for (const int picture : sample(1)) {
      int farthest = picture - 1;
      double emd = -1;
      for (int other = 0; other < size(); ++other) {
        const double apart =
            emd_grey(recogniser_.place(picture).signature, recogniser_.place(other).signature);
        if (other != picture && apart > emd) {
          emd = apart;
          farthest = other;
        }
      }
      drawn.push_back(inliers(std::max(picture, farthest), std::min(picture, farthest)));
    }
    const double median = quantile(drawn, 0.5);
    return median + 2 * std::sqrt(median);
  }

  // How many pictures apart most have no more in common than chance gives.
  int horizon(double beyond_chance) {
    int gap = 1;
    for (; gap < size() / 4; ++gap) {
      std::vector<int> apart;
      for (const int picture : sample(gap)) {
        apart.push_back(inliers(picture, picture - gap));
      }
      if (quantile(apart, 0.75) <= beyond_chance) {
        break;
      }
    }
    return gap;
  }

  // The most inliers with a candidate that shows another place than the best one.
  int elsewhere(std::vector<PlaceCandidate> candidates, int horizon, double unusual) {
    std::sort(candidates.begin(), candidates.end(), more_inliers);
    const int best = candidates.front().place;
    for (const PlaceCandidate& other : candidates) {
      if (std::abs(other.place - best) > horizon &&
          inliers(std::max(best, other.place), std::min(best, other.place)) <= unusual) {
        return other.inliers;
      }
    }
    return 0;
  }

 private:
  static double share_of(PictureParts found, PictureParts of) {
    return of == 0 ? 0 : static_cast<double>(std::popcount(found & of)) / std::popcount(of);
  }

  // Those that neighbours show again: of a plain wall, noise alone has features. All with features
  // where no neighbour shows anything of it.
  PictureParts telling_parts(int picture, double beyond_chance) {
    PictureParts parts = 0;
    for (const int apart : {-2, -1, 1, 2}) {
      const int neighbour = picture + apart;
      if (neighbour < 0 || neighbour >= size()) {
        continue;
      }
      const PlaceCandidate& both =
          compare(std::max(picture, neighbour), std::min(picture, neighbour));
      if (both.inliers > beyond_chance) {
        parts |= neighbour < picture ? both.again_in_view : both.again_in_place;
      }
    }
    return parts != 0 ? parts : parts_with_features(recogniser_.place(picture));
  }

  // Evenly spread pictures that have one so many before them.
  std::vector<int> sample(int gap) const {
    const int count = std::min(kSamples, size() - gap);
    std::vector<int> pictures;
    for (int i = 0; i < count; ++i) {
      pictures.push_back(gap + i * (size() - gap) / count);
    }
    return pictures;
  }

  PlaceRecogniser recogniser_;
  std::map<std::pair<int, int>, PlaceCandidate> compared_;
};

// What pictures a little more than the horizon apart reach, and with support: the robot moves on,
// so they show different places, as alike as neighbours are.
struct Reached {
  std::vector<int> alone;
  std::vector<int> supported;
};

Reached reached_nearby(Run& run, int horizon, double beyond_chance) {
  Reached reached;
  for (int picture = horizon + kGaps + kFastest; picture + 1 < run.size(); ++picture) {
    if (run.inliers(picture, picture - horizon) > beyond_chance) {
      continue;  // it stood or crept
    }
    int most = 0;
    int most_supported = 0;
    for (int gap = horizon + kFastest; gap < horizon + kFastest + kGaps; ++gap) {
      const int inliers = run.inliers(picture, picture - gap);
      most = std::max(most, inliers);
      most_supported = std::max(most_supported, inliers + run.support(picture, picture - gap));
    }
    reached.alone.push_back(most);
    reached.supported.push_back(most_supported);
  }
  return reached;
}

// The pictures before this one that show another place, or this one on another visit: not those
// taken while the robot stood or crept.
int end_of_earlier(Run& run, int picture, int horizon, double unusual) {
  int end = std::max(0, picture - horizon);
  while (end > 0 &&
         (run.inliers(picture, end) > unusual || run.inliers(picture, end - 1) > unusual)) {
    --end;
  }
  return end;
}

const PlaceCandidate& best_of(const std::vector<PlaceCandidate>& candidates) {
  return *std::min_element(candidates.begin(), candidates.end(), more_inliers);
}

// Of pictures that all show something.
RunRecognition recognise_full(const RecogniserOptions& options, std::vector<PlaceView> views,
                              const Rng& rng, const std::function<void(double)>& progress) {
  Run run(options, std::move(views), rng);
  const int count = run.size();
  RunRecognition result;
  result.pictures.resize(count);
  result.threshold = result.threshold_support = std::numeric_limits<double>::infinity();
  if (count < 2) {
    return result;
  }
  const double beyond_chance = run.beyond_chance();
  result.horizon = run.horizon(beyond_chance);
  const Reached nearby = reached_nearby(run, result.horizon, beyond_chance);
  result.threshold = seldom_exceeded(nearby.alone, count);
  result.threshold_support = seldom_exceeded(nearby.supported, count);
  if (!result.learned()) {
    return result;
  }
  const double unusual = quantile(nearby.alone, 0.9);

  std::vector<int> ends(count);
  std::vector<std::vector<PlaceCandidate>> shortlists(count);
  std::vector<int> elsewhere(count, 0);  // inliers with the best of wrong places that look alike
  std::vector<int> of_full_lists;
  for (int picture = 0; picture < count; ++picture) {
    if (progress) {
      progress(static_cast<double>(picture) / count);
    }
    ends[picture] = end_of_earlier(run, picture, result.horizon, unusual);
    shortlists[picture] = run.query(picture, ends[picture]);
    if (std::ssize(shortlists[picture]) == options.shortlist) {
      elsewhere[picture] = run.elsewhere(shortlists[picture], result.horizon, unusual);
      of_full_lists.push_back(elsewhere[picture]);
    }
  }
  double typical = 0;
  if (const double threshold = seldom_exceeded(of_full_lists, count); std::isfinite(threshold)) {
    result.threshold_support *= threshold / result.threshold;
    result.threshold = threshold;
    typical = quantile(of_full_lists, 0.5);
  }

  // so that by chance less than one in 1 / kFalseARun runs has a pair that agrees as well
  const double log_chance_allowed =
      std::log(kFalseARun / (static_cast<double>(count) * options.shortlist));
  for (int picture = 0; picture < count; ++picture) {
    std::vector<PlaceCandidate> candidates = shortlists[picture];
    for (const int neighbour : {picture - 1, picture + 1}) {
      if (neighbour < 0 || neighbour >= count || shortlists[neighbour].empty()) {
        continue;
      }
      // where its best would have been met from here
      const PlaceCandidate& best = best_of(shortlists[neighbour]);
      for (int step = 0; step <= kFastest && best.inliers > unusual; ++step) {
        const int meets = best.place + (picture - neighbour) * step;
        if (meets >= 0 && meets < ends[picture]) {
          candidates.push_back(run.compare(picture, meets));
        }
      }
    }
    if (candidates.empty()) {
      continue;
    }
    const PlaceCandidate best = best_of(candidates);
    const auto support = run.support_of(picture, best.place);
    // a picture that matches wrong places better than most must match the right one better, too
    const double harder = 1 + std::max(0.0, elsewhere[picture] - typical) / result.threshold;
    double confidence = std::max(best.inliers / result.threshold,
                                 (best.inliers + support.inliers) / result.threshold_support) /
                        harder;
    const double seen_again = run.seen_again(picture, best.place, beyond_chance);
    const double needed = confidence >= kCertain ? kCertainSeenAgain : kSeenAgain;
    if (seen_again < needed) {
      confidence = std::min(confidence, seen_again / needed);
    }
    result.pictures[picture] = {best.place,
                                best.emd_grey,
                                best.inliers,
                                support.inliers,
                                seen_again,
                                confidence,
                                confidence >= 1 && support.log_chance <= log_chance_allowed};
  }
  return result;
}

}  // namespace

bool RunRecognition::learned() const { return std::isfinite(threshold); }

RunRecognition recognise_run(const RecogniserOptions& options, std::vector<PlaceView> views,
                             const Rng& rng, const std::function<void(double)>& progress) {
  std::vector<const PictureContent*> contents;
  contents.reserve(views.size());
  for (const PlaceView& view : views) {
    contents.push_back(&view.content);
  }
  const std::vector<PictureFault> faults = picture_faults(contents);
  std::vector<int> full;  // their places in the run
  std::vector<PlaceView> full_views;
  for (int picture = 0; picture < std::ssize(views); ++picture) {
    if (faults[picture] == PictureFault::kNone) {
      full.push_back(picture);
      full_views.push_back(std::move(views[picture]));
    }
  }
  RunRecognition result = recognise_full(options, std::move(full_views), rng, progress);
  std::vector<Recognised> pictures(views.size());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    pictures[i].fault = faults[i];
  }
  for (std::size_t i = 0; i < full.size(); ++i) {
    Recognised& picture = pictures[full[i]] = result.pictures[i];
    picture.earlier = picture.earlier < 0 ? -1 : full[picture.earlier];
  }
  result.pictures = std::move(pictures);
  return result;
}

}  // namespace panoptes
