// Which part of an image a mesh covers, and where it ends: the occluding contour.
//
// Along a line y = const of the image the number of facets over a point changes where the line crosses an edge, by
//
//   jump(a, b) = -w sign(y_b - y_a),   w = sum of +-1 over the edge's facets,
//
// + for those that go from a to b and turn the image's way, or both not. An edge between a facet on its left and one
// on its right has w = 0; what remains are the rims: edges whose facets project to one side of them. So rims alone say
// where the number is above zero, whichever way facets face and whether the mesh is closed.
//
// Points are in pixels of the camera's image (core/scene/camera.h).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

// The edges of a mesh with their facets.
class EdgeFacets {
 public:
  struct Facet {
    int face;
    int direction;  // 1: goes from a to b; -1: from b to a
  };
  // `neighbors`, `faces`: of the mesh.
  EdgeFacets(const TriangleMesh& mesh, const Adjacency& neighbors, const Adjacency& faces);

  int size() const { return static_cast<int>(a_.size()); }
  int a(int edge) const { return a_[edge]; }
  int b(int edge) const { return b_[edge]; }
  const Facet* Begin(int edge) const { return facets_.data() + start_[edge]; }
  const Facet* End(int edge) const { return facets_.data() + start_[edge + 1]; }

 private:
  std::vector<int> a_, b_;  // a < b
  std::vector<int> start_;
  std::vector<Facet> facets_;
};

class MeshCover {
 public:
  // An edge whose facets project to one side.
  struct Rim {
    int edge;                 // of the EdgeFacets
    Eigen::Vector2d a, b;     // image points of its vertices
    Eigen::Vector2d outward;  // unit, away from its facets
  };
  // A piece of the contour.
  struct Sample {
    int rim;
    double along;           // 0 at a, 1 at b
    double length;          // pixels of the contour that it stands for
    Eigen::Vector2d point;  // (1 - along) a + along b
  };

  // `rows`: lines y = const for each pixel. Facets that reach nearer than the camera's near depth are not there.
  MeshCover(const TriangleMesh& mesh, const EdgeFacets& edges, const Camera& camera, int rows);

  const std::vector<Rim>& rims() const { return rims_; }
  int rows() const { return rows_; }
  // On the line nearest to the point.
  bool Covers(const Eigen::Vector2d& point) const;
  // The share of each pixel of `region` that is covered, 0 to 1.
  cv::Mat1f Share(const cv::Rect& region) const;
  // Whether the mesh covers less than `width` pixels inwards of a point of its contour; looked at every half pixel.
  bool IsThin(const Sample& sample, double width) const;
  // Pieces of at most `length` pixels of the rims, without those that the mesh covers `outwards` pixels beyond them and
  // those within a pixel of the image's border.
  std::vector<Sample> Contour(double length, double outwards) const;

 private:
  struct Span {
    float begin, end;
  };
  void FindRims(const TriangleMesh& mesh, const EdgeFacets& edges, const Camera& camera,
                std::vector<int>* weights);
  void FillRows(const std::vector<int>& weights);

  const int width_, height_, rows_;
  std::vector<Rim> rims_;
  std::vector<int64_t> row_start_;  // height_ * rows_ + 1
  std::vector<Span> spans_;         // covered, of each row ascending
};

}  // namespace burin
