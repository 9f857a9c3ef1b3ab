#include "core/evidence/verdict.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <string_view>
#include <utility>

#include "core/scene/doubts.h"
#include "core/support/fixed_text.h"
#include "core/support/median.h"

namespace burin {
namespace {

constexpr size_t kLeastWindows = 30;  // for any figure
constexpr double kChance = 3.0 / (2 * kMatchAcross + 1);
constexpr double kLeastOnLine = 0.33;     // E
constexpr double kClearlyAtPlace = 0.75;  // A of photographs that only noise keeps from their lines
constexpr double kLeastAtPlace = 0.6;     // A
constexpr int kCoarseSidePx = 256;        // where a mesh far from the surface may still fit
constexpr double kSharpPx = 0.35;         // of the small images
constexpr double kDoubtfulNoisePx = 0.5;
constexpr double kFarthestAcross = 7.5;  // of matches that noise is measured by
constexpr double kMisfitShare = 0.4;     // of the median E over the views
constexpr double kLeastMedian = 0.2;     // of it, for a view to stand out
constexpr double kLeastOfRest = 0.4;     // E of the others, for a view to be named
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

using Matches = std::vector<const WindowMatch*>;

bool OnLine(const WindowMatch& match) { return std::abs(match.row) <= 1; }

double WithoutChance(double share) { return (share - kChance) / (1 - kChance); }

// Of E from so many windows.
double StandardError(double on_line, size_t windows) {
  const auto count = static_cast<double>(windows);
  const double share = on_line * (1 - kChance) + kChance;
  return std::sqrt(std::max(share * (1 - share), 1 / count) / count) / (1 - kChance);
}

// P(x > y) for x at the places predicted and y by chance, ties half.
double AtPlace(const Matches& matches) {
  std::vector<std::pair<float, bool>> scores;  // true = predicted
  size_t predicted = 0;
  for (const WindowMatch* match : matches) {
    scores.emplace_back(match->at_prediction, true);
    ++predicted;
    for (const float score : match->by_chance) {
      if (!std::isnan(score)) scores.emplace_back(score, false);
    }
  }
  const size_t chance = scores.size() - predicted;
  if (predicted == 0 || chance == 0) return kNone;
  std::sort(scores.begin(), scores.end());
  double above = 0;
  double below = 0;  // by chance, smaller than the scores that are now looked at
  for (size_t k = 0; k < scores.size();) {
    double same[2] = {0, 0};
    const float score = scores[k].first;
    for (; k < scores.size() && scores[k].first == score; ++k) ++same[scores[k].second ? 1 : 0];
    above += same[1] * (below + same[0] / 2);
    below += same[0];
  }
  return above / (static_cast<double>(predicted) * static_cast<double>(chance));
}

Evidence EvidenceOf(const Matches& matches) {
  Evidence evidence;
  evidence.windows = static_cast<int>(matches.size());
  if (matches.size() < kLeastWindows) return evidence;
  double on_line = 0;
  std::vector<double> across;
  for (const WindowMatch* match : matches) {
    on_line += OnLine(*match) ? 1 : 0;
    if (match->clear && std::abs(match->across) < kFarthestAcross) {
      across.push_back(match->scale * std::abs(match->across));
    }
  }
  evidence.on_line = WithoutChance(on_line / static_cast<double>(matches.size()));
  evidence.at_place = AtPlace(matches);
  evidence.noise_px = kSigmaOfMedian * Median(std::move(across)) / std::sqrt(2.0);
  return evidence;
}

// E of a view as the mean over its partners, so that a large pair does not decide.
double OnLineByPartner(const Matches& matches, int view) {
  if (matches.size() < kLeastWindows) return kNone;
  std::map<int, std::pair<double, double>> partners;  // on the line, all
  for (const WindowMatch* match : matches) {
    auto& [on_line, all] = partners[match->reference == view ? match->second : match->reference];
    on_line += OnLine(*match) ? 1 : 0;
    ++all;
  }
  double sum = 0;
  for (const auto& [partner, counts] : partners) sum += counts.first / counts.second;
  return WithoutChance(sum / static_cast<double>(partners.size()));
}

// Those of pairs without a view in `misfits`.
Matches Fitting(const std::vector<WindowMatch>& matches, const std::vector<int>& misfits) {
  const auto out = [&](int view) {
    return std::find(misfits.begin(), misfits.end(), view) != misfits.end();
  };
  Matches fitting;
  for (const WindowMatch& match : matches) {
    if (!out(match.reference) && !out(match.second)) fitting.push_back(&match);
  }
  return fitting;
}

// In either role.
std::vector<Matches> ByView(const Matches& matches, size_t views) {
  std::vector<Matches> by_view(views);
  for (const WindowMatch* match : matches) {
    by_view[match->reference].push_back(match);
    by_view[match->second].push_back(match);
  }
  return by_view;
}

// By the upper bound of what chance leaves of a view's E: of two views that share a pair, it is the one with
// other bad pairs.
std::vector<int> Misfits(const std::vector<WindowMatch>& matches, size_t views) {
  std::vector<int> misfits;
  while (3 * misfits.size() < views) {
    const std::vector<Matches> by_view = ByView(Fitting(matches, misfits), views);
    std::vector<double> known;
    int worst = -1;
    double least = std::numeric_limits<double>::infinity();
    for (size_t v = 0; v < views; ++v) {
      const double on_line = OnLineByPartner(by_view[v], static_cast<int>(v));
      if (std::isnan(on_line)) continue;
      known.push_back(on_line);
      const double bound = on_line + 2 * StandardError(on_line, by_view[v].size());
      if (bound >= least) continue;
      least = bound;
      worst = static_cast<int>(v);
    }
    const double median = Median(known);
    if (!(median >= kLeastMedian) || least > kMisfitShare * median) break;
    misfits.push_back(worst);
  }
  // One that has bad pairs with others of them only may be right.
  std::vector<int> against_fitting(views, 0);
  const auto fits = [&](int view) {
    return std::find(misfits.begin(), misfits.end(), view) == misfits.end();
  };
  for (const WindowMatch& match : matches) {
    if (fits(match.second)) ++against_fitting[match.reference];
    if (fits(match.reference)) ++against_fitting[match.second];
  }
  misfits.erase(std::remove_if(misfits.begin(), misfits.end(),
                               [&](int view) {
                                 return against_fitting[view] < static_cast<int>(kLeastWindows);
                               }),
                misfits.end());
  return misfits;
}

// Adds views that their tracks speak against, and no photograph for.
void AddMisfitsByTracks(const std::vector<WindowMatch>& matches, const TrackErrors& tracks,
                        size_t views, std::vector<int>* misfits) {
  if (tracks.MostAreOff()) return;
  const std::vector<Matches> by_view = ByView(Fitting(matches, *misfits), views);
  for (const int view : tracks.off) {
    const bool fits = OnLineByPartner(by_view[view], view) >= kLeastOnLine;
    const bool known = std::find(misfits->begin(), misfits->end(), view) != misfits->end();
    if (!fits && !known) misfits->push_back(view);
  }
}

// What there is to say when there are too few windows.
std::string WhyNoWindows(const Scene& scene, size_t windows) {
  int largest = 0;
  for (const View& view : scene.views) {
    largest = std::max({largest, view.camera.width, view.camera.height});
  }
  if (largest < kLeastSidePx) {
    return "photographs of " + std::to_string(largest) + " px are too small, it takes " +
           std::to_string(kLeastSidePx);
  }
  return std::to_string(windows) +
         " textured windows of the mesh are seen by two photographs, it takes " +
         std::to_string(kLeastWindows);
}

void Conclude(const Scene& scene, SceneVerdict* verdict) {
  const Evidence& evidence = verdict->evidence;
  if (evidence.windows < static_cast<int>(kLeastWindows)) {
    verdict->verdict = Verdict::kCannotTell;
    verdict->reason = WhyNoWindows(scene, verdict->matches.size());
  } else if (evidence.on_line < kLeastOnLine && evidence.at_place < kClearlyAtPlace) {
    verdict->verdict = Verdict::kWrong;
    verdict->reason =
        "the photographs do not fit cameras and mesh: best matches lie beside the epipolar lines "
        "(E " +
        Fixed(evidence.on_line, 2) + " of 1; right cameras have at least " +
        Fixed(kLeastOnLine, 2) + ")";
  } else if (evidence.at_place < kLeastAtPlace) {
    verdict->verdict = Verdict::kWrong;
    verdict->reason =
        "the mesh does not fit the photographs: they agree no better where it puts them than "
        "elsewhere (A " +
        Fixed(evidence.at_place, 2) + ", chance is 0.50)";
  } else if (!verdict->misfits.empty()) {
    verdict->verdict = Verdict::kDoubtful;
    verdict->reason = std::to_string(verdict->misfits.size()) +
                      (verdict->misfits.size() == 1 ? " view does" : " views do") +
                      " not fit the others";
    for (size_t k = 0; k < verdict->misfits.size(); ++k) {
      verdict->reason += (k == 0 ? ": " : ", ") + scene.views[verdict->misfits[k]].name;
    }
  } else if (evidence.noise_px >= kDoubtfulNoisePx) {
    verdict->verdict = Verdict::kDoubtful;
    verdict->reason = "the cameras are off by about " + Fixed(evidence.noise_px, 2) + " px";
  } else {
    verdict->verdict = Verdict::kGood;
  }
}

// What is wrong, by matches in small images, where the same search reaches further. A mesh that fits there
// is one that refinement can bring closer; lines that fit there sharply are those of right cameras.
void JudgeFromAfar(const std::vector<WindowMatch>& matches, SceneVerdict* verdict) {
  const Matches fitting = Fitting(matches, verdict->misfits);
  const Evidence afar = EvidenceOf(fitting);
  if (verdict->evidence.on_line >= kLeastOnLine && afar.at_place >= kLeastAtPlace) {
    verdict->verdict = Verdict::kDoubtful;
    verdict->reason =
        "the mesh is far from the surface: only small images agree where it puts them (A " +
        Fixed(afar.at_place, 2) + ", of larger ones " + Fixed(verdict->evidence.at_place, 2) + ")";
  } else if (verdict->evidence.on_line < kLeastOnLine && afar.on_line >= kLeastOnLine &&
             afar.noise_px < kSharpPx * fitting.front()->scale) {
    verdict->reason =
        "the mesh does not fit the photographs: best matches lie on the epipolar lines, but far "
        "from "
        "where it puts them";
  }
}

// Most views have their sparse points elsewhere than measured. Photographs that can tell decide.
void JudgeByTracks(const Scene& scene, SceneVerdict* verdict) {
  const std::string reason =
      "cameras and sparse points are not of one reconstruction: in " +
      std::to_string(verdict->tracks.off.size()) + " of " + std::to_string(verdict->tracks.known) +
      " views these are not where they were measured (" + TrackErrorText(scene) + ")";
  switch (verdict->verdict) {
    case Verdict::kGood:
      verdict->verdict = Verdict::kDoubtful;
      verdict->reason = reason + "; but the photographs fit";
      break;
    case Verdict::kDoubtful:
    case Verdict::kWrong:
      verdict->reason += "; " + reason;
      break;
    case Verdict::kCannotTell:
      verdict->verdict = Verdict::kWrong;
      verdict->reason = reason;
      break;
  }
}

// Views whose photograph is that of another view too, byte by byte.
int SharedPhotographs(const Scene& scene) {
  std::map<std::string_view, int> views_of;
  std::vector<cv::Mat> whole;
  whole.reserve(scene.views.size());
  for (const View& view : scene.views) {
    if (view.gray.empty()) continue;
    whole.push_back(view.gray.isContinuous() ? view.gray : view.gray.clone());
    const cv::Mat& image = whole.back();
    ++views_of[{reinterpret_cast<const char*>(image.data), image.total() * image.elemSize()}];
  }
  int shared = 0;
  for (const auto& [bytes, views] : views_of) shared += views > 1 ? views : 0;
  return shared;
}

}  // namespace

SceneVerdict JudgeMatches(const Scene& scene, std::vector<WindowMatch> matches) {
  SceneVerdict verdict;
  verdict.matches = std::move(matches);
  const size_t views = scene.views.size();
  std::set<std::pair<int, int>> pairs;
  for (const WindowMatch& match : verdict.matches) pairs.insert({match.reference, match.second});
  verdict.pairs = static_cast<int>(pairs.size());
  verdict.evidence = EvidenceOf(Fitting(verdict.matches, {}));
  if (std::vector<int> misfits = Misfits(verdict.matches, views); !misfits.empty()) {
    const Evidence rest = EvidenceOf(Fitting(verdict.matches, misfits));
    if (rest.on_line >= kLeastOfRest) {
      verdict.misfits = std::move(misfits);
      verdict.evidence = rest;
    }
  }
  verdict.tracks = MeasureTrackErrors(scene);
  if (!verdict.tracks.off.empty()) {
    std::vector<int> misfits = verdict.misfits;
    AddMisfitsByTracks(verdict.matches, verdict.tracks, views, &misfits);
    const Evidence rest = EvidenceOf(Fitting(verdict.matches, misfits));
    if (!(rest.on_line < kLeastOfRest)) {
      verdict.misfits = std::move(misfits);
      verdict.evidence = rest;
    }
  }
  verdict.views.resize(views);
  for (const int view : verdict.misfits) verdict.views[view].misfit = true;
  // A view that does not fit has its figures from all pairs, the others from pairs that fit.
  const std::vector<Matches> of_all = ByView(Fitting(verdict.matches, {}), views);
  const std::vector<Matches> of_fitting = ByView(Fitting(verdict.matches, verdict.misfits), views);
  for (size_t v = 0; v < views; ++v) {
    const Matches& of_view = verdict.views[v].misfit ? of_all[v] : of_fitting[v];
    verdict.views[v].evidence = EvidenceOf(of_view);
    verdict.views[v].evidence.on_line = OnLineByPartner(of_view, static_cast<int>(v));
  }
  Conclude(scene, &verdict);
  return verdict;
}

SceneVerdict JudgeScene(const Scene& scene, const TriangleMesh& mesh,
                        const std::vector<CameraPair>& pairs) {
  SceneVerdict verdict = JudgeMatches(scene, MatchWindows(scene, mesh, pairs));
  if (verdict.verdict == Verdict::kWrong) {
    JudgeFromAfar(MatchWindows(scene, mesh, pairs, kCoarseSidePx), &verdict);
  }
  if (verdict.tracks.MostAreOff()) JudgeByTracks(scene, &verdict);
  const int shared = SharedPhotographs(scene);
  if (2 * static_cast<size_t>(shared) > scene.views.size()) {
    verdict.verdict = Verdict::kWrong;
    verdict.reason = "the same photograph is in several views: " + std::to_string(shared) + " of " +
                     std::to_string(scene.views.size()) + " views have one that another has too";
  }
  return verdict;
}

}  // namespace burin
