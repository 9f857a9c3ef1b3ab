// Depth maps on disk, so that a run that was interrupted, or one with other options of the surface, does not match
// photographs again. The name of a file tells what its depths were made of: one made of anything else is never found.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/scene/scene.h"
#include "reconstruct/stereo_depth.h"

namespace burin {

class DepthFiles {
 public:
  // In a folder that exists; an empty path keeps nothing.
  explicit DepthFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // False where there is no such file, or it cannot be read.
  bool Read(int view, std::uint64_t key, FusedDepth* depth) const;
  void Write(int view, std::uint64_t key, const FusedDepth& depth) const;

 private:
  std::filesystem::path PathOf(int view, std::uint64_t key) const;

  std::filesystem::path folder_;
};

// Of pixels, masks and cameras of the view and its partners, of the sparse points that it sees, and of `least`
// (FusePairs).
std::uint64_t DepthKey(const Scene& scene, int view, const std::vector<int>& partners,
                       const std::vector<Eigen::Vector3d>& points, int least);

}  // namespace burin
