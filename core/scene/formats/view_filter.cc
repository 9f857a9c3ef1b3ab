#include "core/scene/formats/view_filter.h"

#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

#include "core/support/error.h"

namespace burin {
namespace {

// Whether * and ? make `pattern` into `text`.
bool Fits(const std::string& pattern, const std::string& text) {
  size_t p = 0, t = 0;
  size_t star = std::string::npos, retry = 0;
  while (t < text.size()) {
    if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
      ++p;
      ++t;
    } else if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      retry = t;
    } else if (star != std::string::npos) {
      p = star + 1;
      t = ++retry;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string::npos;
}

std::vector<std::string> Patterns(const std::string& list) {
  std::vector<std::string> patterns;
  std::istringstream stream(list);
  for (std::string pattern; std::getline(stream, pattern, ',');) {
    const size_t first = pattern.find_first_not_of(' ');
    if (first == std::string::npos) continue;
    patterns.push_back(pattern.substr(first, pattern.find_last_not_of(' ') - first + 1));
  }
  return patterns;
}

// 1 for the images that one of the patterns fits.
std::vector<char> Fitting(const std::string& list, const char* option, const PosedScene& posed) {
  std::vector<char> fitting(posed.images.size(), 0);
  for (const std::string& pattern : Patterns(list)) {
    bool any = false;
    for (size_t i = 0; i < posed.images.size(); ++i) {
      const std::string& name = posed.images[i].name;
      if (!Fits(pattern, name) && !Fits(pattern, std::filesystem::path(name).filename().string())) {
        continue;
      }
      fitting[i] = 1;
      any = true;
    }
    if (!any) {
      throw InputError(posed.file,
                       std::string(option) + " '" + pattern + "': no view has such a name" +
                           (posed.images.empty() ? "" : "; the first is " + posed.images[0].name));
    }
  }
  return fitting;
}

}  // namespace

void LeaveOutViews(const ViewFilter& filter, PosedScene* posed) {
  std::vector<char> keep(posed->images.size(), 1);
  if (!filter.views.empty()) keep = Fitting(filter.views, "--views", *posed);
  if (!filter.skip.empty()) {
    const std::vector<char> out = Fitting(filter.skip, "--skip-views", *posed);
    for (size_t i = 0; i < keep.size(); ++i) keep[i] = keep[i] != 0 && out[i] == 0;
  }
  const auto first = std::find(keep.begin(), keep.end(), 0);
  if (first == keep.end()) return;
  posed->notes.push_back(std::to_string(std::count(keep.begin(), keep.end(), 0)) + " of " +
                         std::to_string(keep.size()) +
                         " views left out by --views and --skip-views; the first is " +
                         posed->images[first - keep.begin()].name);
  KeepImages(keep, posed);
}

void KeepImages(const std::vector<char>& keep, PosedScene* posed) {
  std::vector<PosedImage> images;
  std::vector<int> index(keep.size(), -1);
  for (size_t i = 0; i < keep.size(); ++i) {
    if (keep[i] == 0) continue;
    index[i] = static_cast<int>(images.size());
    images.push_back(std::move(posed->images[i]));
  }
  posed->images = std::move(images);
  Tracks tracks;
  for (size_t p = 0; p < posed->points.size(); ++p) {
    std::vector<int> views;
    for (const int view : posed->points[p].views) {
      if (index[view] >= 0) views.push_back(index[view]);
    }
    posed->points[p].views = std::move(views);
    if (posed->tracks.IsEmpty()) continue;
    tracks.BeginPoint();
    for (Measurement measurement : posed->tracks.Of(p)) {
      measurement.view = index[measurement.view];
      if (measurement.view >= 0) tracks.Add(measurement);
    }
  }
  posed->tracks = std::move(tracks);
}

}  // namespace burin
