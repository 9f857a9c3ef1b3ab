// Nearest points: on the surface of a triangle mesh, exact, and among the points of a cloud. Both
// answer the same for any number of threads.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

// The nearest point of a mesh.
struct SurfacePoint {
  int face = -1;  // -1: nothing within the distance asked for
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d face_normal = Eigen::Vector3d::Zero();  // unit; zero for a face without area
  // Unit pseudonormal at `point`: of the face inside it, the mean of the two faces on an edge,
  // angle-weighted at a vertex (Baerentzen and Aanaes, "Signed distance computation using the angle
  // weighted pseudonormal", 2005), so that its side is right there too. Zero where faces have no
  // area or cancel.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double distance = std::numeric_limits<double>::infinity();  // world units, >= 0
  // +distance on the side the normal points to, -distance on the other.
  double SignedDistance(const Eigen::Vector3d& query) const {
    return (query - point).dot(normal) < 0 ? -distance : distance;
  }
};

// Closest points of a mesh: candidates from Embree's hierarchy, distances in double. Among equally
// near faces the one with the lowest index counts. Keeps its own copy of the mesh. Faces without
// area count as segments or points; vertices without faces do not count.
class MeshDistance {
 public:
  explicit MeshDistance(const TriangleMesh& mesh);
  ~MeshDistance();
  MeshDistance(MeshDistance&&) noexcept;

  // The nearest point of the surface, or face = -1 when there is none within max_distance.
  SurfacePoint Find(const Eigen::Vector3d& query,
                    double max_distance = std::numeric_limits<double>::infinity()) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

// Nearest points of a cloud in a k-d tree. Keeps its own copy of the points.
class CloudDistance {
 public:
  explicit CloudDistance(std::vector<Eigen::Vector3d> points);
  ~CloudDistance();
  CloudDistance(CloudDistance&&) noexcept;

  // Index of the nearest point, or -1 when there is none within max_distance. *distance (may be
  // null) is set only when there is one.
  int Find(const Eigen::Vector3d& query, double max_distance, double* distance = nullptr) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace burin
