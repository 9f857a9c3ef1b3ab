#include "reconstruct/depth_files.h"

#include <cstdio>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/support/atomic_file.h"
#include "core/support/counter_random.h"
#include "core/support/error.h"

namespace burin {
namespace {

constexpr std::uint64_t kVersion =
    1;  // of what MatchPair and FusePairs make of the same photographs

constexpr int kTiffLzw =
    5;  // without it OpenCV writes three planes of floats as LogLuv, which rounds them

class Hash {
 public:
  void Add(std::uint64_t value) { state_ = MixBits(state_ * 3 + value); }
  void Add(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    Add(bits);
  }
  void Add(const Camera& camera) {
    for (const double value :
         {static_cast<double>(camera.width), static_cast<double>(camera.height), camera.fx,
          camera.fy, camera.cx, camera.cy}) {
      Add(value);
    }
    for (int k = 0; k < 9; ++k) Add(camera.rotation(k));
    for (int k = 0; k < 3; ++k) Add(camera.translation[k]);
  }
  void Add(const cv::Mat& picture) {
    Add(static_cast<std::uint64_t>(picture.type()));
    for (int row = 0; row < picture.rows; ++row) {
      const std::uint8_t* bytes = picture.ptr(row);
      const size_t count = picture.cols * picture.elemSize();
      size_t at = 0;
      for (; at + 8 <= count; at += 8) {
        std::uint64_t eight = 0;
        std::memcpy(&eight, bytes + at, 8);
        Add(eight);
      }
      for (; at < count; ++at) Add(static_cast<std::uint64_t>(bytes[at]));
    }
  }
  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = kVersion;
};

}  // namespace

std::uint64_t DepthKey(const Scene& scene, int view, const std::vector<int>& partners,
                       const std::vector<Eigen::Vector3d>& points, int least) {
  Hash hash;
  hash.Add(static_cast<std::uint64_t>(least));
  hash.Add(scene.views[view].mask);
  std::vector<int> views = partners;
  views.push_back(view);
  for (const int v : views) {
    hash.Add(scene.views[v].camera);
    hash.Add(scene.views[v].gray);
  }
  for (const Eigen::Vector3d& point : points) {
    for (int k = 0; k < 3; ++k) hash.Add(point[k]);
  }
  return hash.value();
}

std::filesystem::path DepthFiles::PathOf(int view, std::uint64_t key) const {
  char name[64];
  std::snprintf(name, sizeof(name), "depth_%04d_%016llx.tiff", view,
                static_cast<unsigned long long>(key));
  return folder_ / name;
}

bool DepthFiles::Read(int view, std::uint64_t key, FusedDepth* depth) const {
  if (folder_.empty() || !std::filesystem::exists(PathOf(view, key))) return false;
  const cv::Mat planes = cv::imread(PathOf(view, key).string(), cv::IMREAD_UNCHANGED);
  if (planes.type() != CV_32FC3) return false;
  std::vector<cv::Mat> of;
  cv::split(planes, of);
  depth->map.depth = of[0];
  depth->map.sigma = of[1];
  of[2].convertTo(depth->pairs, CV_32S);
  return true;
}

void DepthFiles::Write(int view, std::uint64_t key, const FusedDepth& depth) const {
  if (folder_.empty() || depth.map.depth.empty()) return;
  cv::Mat pairs;
  depth.pairs.convertTo(pairs, CV_32F);
  cv::Mat planes;
  cv::merge(std::vector<cv::Mat>{depth.map.depth, depth.map.sigma, pairs}, planes);
  WriteAtomically(PathOf(view, key), [&](const std::filesystem::path& temporary) {
    if (!cv::imwrite(temporary.string(), planes, {cv::IMWRITE_TIFF_COMPRESSION, kTiffLzw})) {
      throw InputError(temporary, "cannot be written");
    }
  });
}

}  // namespace burin
