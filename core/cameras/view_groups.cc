#include "core/cameras/view_groups.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace burin {
namespace {

// Of every view the lowest that common tracks link to it.
std::vector<int> LinkViews(int view_count, const Tracks& tracks) {
  std::map<std::pair<int, int>, int> common;
  for (size_t p = 0; p < tracks.PointCount(); ++p) {
    for (const Measurement& a : tracks.Of(p)) {
      for (const Measurement& b : tracks.Of(p)) {
        if (a.view < b.view) ++common[{a.view, b.view}];
      }
    }
  }
  std::vector<int> lowest(view_count);
  std::iota(lowest.begin(), lowest.end(), 0);
  for (const auto& [views, count] : common) {
    const int a = lowest[views.first];
    const int b = lowest[views.second];
    if (count < kFewestCommonTracks || a == b) continue;
    std::replace(lowest.begin(), lowest.end(), std::max(a, b), std::min(a, b));
  }
  return lowest;
}

ViewGroups Numbered(const std::vector<int>& lowest) {
  ViewGroups groups;
  groups.of_view.assign(lowest.size(), -1);
  for (size_t v = 0; v < lowest.size(); ++v) {
    if (std::count(lowest.begin(), lowest.end(), lowest[v]) < 2) continue;
    const bool first = lowest[v] == static_cast<int>(v);
    groups.of_view[v] = first ? groups.count++ : groups.of_view[lowest[v]];
  }
  return groups;
}

// The group of most of a track's measurements, -1 where they have none; of equal ones the lowest.
int GroupOf(const Tracks::Range& track, const ViewGroups& groups) {
  std::map<int, int> measured;
  for (const Measurement& one : track) {
    if (groups.of_view[one.view] >= 0) ++measured[groups.of_view[one.view]];
  }
  int most = -1;
  for (const auto& [group, count] : measured) {
    if (most < 0 || count > measured[most]) most = group;
  }
  return most;
}

}  // namespace

std::vector<int> ViewGroups::ViewsOf(int group) const {
  std::vector<int> views;
  for (size_t v = 0; v < of_view.size(); ++v) {
    if (of_view[v] == group) views.push_back(static_cast<int>(v));
  }
  return views;
}

ViewGroups GroupViews(int view_count, Tracks* tracks, std::vector<int>* kept) {
  kept->resize(tracks->PointCount());
  std::iota(kept->begin(), kept->end(), 0);
  for (;;) {
    ViewGroups groups = Numbered(LinkViews(view_count, *tracks));
    Tracks left;
    std::vector<int> left_kept;
    for (size_t p = 0; p < tracks->PointCount(); ++p) {
      const int group = GroupOf(tracks->Of(p), groups);
      std::vector<Measurement> own;
      for (const Measurement& measured : tracks->Of(p)) {
        if (group >= 0 && groups.of_view[measured.view] == group) own.push_back(measured);
      }
      if (own.size() < 2) continue;
      left.BeginPoint();
      for (const Measurement& measured : own) left.Add(measured);
      left_kept.push_back((*kept)[p]);
    }
    const bool settled = left.Count() == tracks->Count();
    *tracks = std::move(left);
    *kept = std::move(left_kept);
    if (settled) return groups;
  }
}

}  // namespace burin
