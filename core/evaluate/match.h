// Matches of points on the other side of a comparison, a mesh or a cloud: steps 3 and 4 of the protocol
// in core/evaluate/evaluation.h.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/evaluate/truth.h"
#include "core/mesh/alignment.h"
#include "core/mesh/closest_point.h"
#include "core/mesh/mesh.h"

namespace burin {

// A point's match on one side of the comparison.
struct Match {
  bool found = false;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit; zero when the side has none
  double distance = 0;                               // |a - b|
  double signed_distance = 0;                        // by the normal; unsigned without one
};

// Nearest points of a mesh or a cloud, behind one call.
class MatchSide {
 public:
  explicit MatchSide(const TriangleMesh& mesh);
  explicit MatchSide(const Truth& truth);  // refers to its cloud

  Match Find(const Eigen::Vector3d& query, double max_distance) const;

 private:
  std::unique_ptr<MeshDistance> mesh_;
  const PointCloud* cloud_ = nullptr;
  std::unique_ptr<CloudDistance> tree_;
};

// Of each point, its two distances to its match; negative when it has none. Where the match has no
// normal, that to the plane is that to the point.
struct MatchDistances {
  std::vector<double> point;
  std::vector<double> plane;
  std::vector<double> cosine;  // between the normals of point and match, 0 where one has none
};

// Of the points after `motion`. `normals`, of the points before it, may be null: then there are no cosines.
MatchDistances MeasureDistances(const std::vector<Eigen::Vector3d>& points,
                                const Similarity& motion, const MatchSide& side,
                                double max_distance,
                                const std::vector<Eigen::Vector3d>* normals = nullptr);

}  // namespace burin
