// Curvature between vertices and cameras: the blocks of H_vc that are not zero.
//
// Of every vertex one block for each camera whose pose moves what the vertex' facets look like: `rows` unknowns of the
// vertex (one along its normal, or its coordinates) times six of the camera's motion (core/scene/camera_pose.h).
// Nothing couples a vertex to the other cameras, so the size goes with what is seen and not with vertices times views.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

class CameraCoupling {
 public:
  static constexpr int kMotion = 6;

  int rows = 1;
  Adjacency cameras;  // of each vertex, ascending

  // Zeros for all blocks, in double or single precision.
  void Clear(bool in_double) {
    in_double_ = in_double;
    doubles_.assign(in_double ? Numbers() : 0, 0.0);
    floats_.assign(in_double ? 0 : Numbers(), 0.0F);
  }
  // The place of a vertex' block, which must exist.
  int Place(int vertex, int camera) const {
    return static_cast<int>(std::lower_bound(cameras.Begin(vertex), cameras.End(vertex), camera) -
                            cameras.index.data());
  }
  // Adds a block, row-major.
  template <typename T>
  void Add(int place, const T* block) {
    const size_t first = First(place);
    for (int e = 0; e < rows * kMotion; ++e) {
      if (in_double_) {
        doubles_[first + e] += block[e];
      } else {
        floats_[first + e] += static_cast<float>(block[e]);
      }
    }
  }
  // visit(values): all blocks, one after the other, in float or double.
  template <typename Visit>
  void ForBlocks(const Visit& visit) const {
    if (in_double_) {
      visit(doubles_.data());
    } else {
      visit(floats_.data());
    }
  }
  // rows x 6
  Eigen::Matrix<double, Eigen::Dynamic, kMotion, Eigen::RowMajor, 3, kMotion> Block(
      int place) const {
    Eigen::Matrix<double, Eigen::Dynamic, kMotion, Eigen::RowMajor, 3, kMotion> block(rows,
                                                                                      kMotion);
    const size_t first = First(place);
    for (int e = 0; e < rows * kMotion; ++e) {
      block.data()[e] = in_double_ ? doubles_[first + e] : floats_[first + e];
    }
    return block;
  }

 private:
  size_t First(int place) const { return static_cast<size_t>(place) * rows * kMotion; }
  size_t Numbers() const { return cameras.index.size() * rows * kMotion; }

  bool in_double_ = false;
  std::vector<double> doubles_;
  std::vector<float> floats_;
};

}  // namespace burin
