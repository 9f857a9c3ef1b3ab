#include "reconstruct/stereo_views.h"

#include <algorithm>
#include <opencv2/core/utility.hpp>

#include "core/support/parallel.h"
#include "reconstruct/depth_files.h"

namespace burin {
namespace {

// Views go side by side on burin's threads, so OpenCV starts none of its own.
class OneOpenCvThread {
 public:
  OneOpenCvThread() : before_(cv::getNumThreads()) { cv::setNumThreads(1); }
  ~OneOpenCvThread() { cv::setNumThreads(before_); }
  OneOpenCvThread(const OneOpenCvThread&) = delete;
  OneOpenCvThread& operator=(const OneOpenCvThread&) = delete;

 private:
  int before_;
};

FusedDepth MatchView(const Scene& scene, int view, const std::vector<int>& partners,
                     const std::vector<Eigen::Vector3d>& points, int agreeing_pairs) {
  std::vector<DepthMap> maps;
  maps.reserve(partners.size());
  for (const int partner : partners) {
    maps.push_back(MatchPair(scene.views[view], scene.views[partner], points));
  }
  return FusePairs(maps, scene.views[view].mask, agreeing_pairs);
}

}  // namespace

StereoViews MatchViews(const Scene& scene, const StereoViewsRules& rules,
                       const std::function<void(double share)>& between) {
  const int count = static_cast<int>(scene.views.size());
  const std::vector<std::vector<int>> partners = ChooseStereoPartners(scene, rules.pairs);
  std::vector<std::vector<Eigen::Vector3d>> seen(count);
  for (const ScenePoint& point : scene.points) {
    for (const int v : point.views) seen[v].push_back(point.position);
  }
  const DepthFiles files(rules.folder);
  StereoViews result;
  result.depths.resize(count);
  std::vector<char> read(count, 0);
  const OneOpenCvThread one_thread;
  const int batch = ThreadCount();
  for (int first = 0; first < count; first += batch) {
    between(static_cast<double>(first) / count);
    ParallelFor(std::min(batch, count - first), 1, [&](int begin, int end) {
      for (int v = first + begin; v < first + end; ++v) {
        const std::uint64_t key = DepthKey(scene, v, partners[v], seen[v], rules.agreeing_pairs);
        FusedDepth& depth = result.depths[v];
        if (files.Read(v, key, &depth)) {
          read[v] = 1;
        } else {
          depth = MatchView(scene, v, partners[v], seen[v], rules.agreeing_pairs);
          files.Write(v, key, depth);
        }
        depth.partners = partners[v];
      }
    });
  }
  for (int v = 0; v < count; ++v) {
    result.matched += result.depths[v].map.depth.empty() ? 0 : 1;
    result.read += read[v];
  }
  return result;
}

}  // namespace burin
