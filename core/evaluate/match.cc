#include "core/evaluate/match.h"

#include <cmath>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kPointGrain = 1024;

}  // namespace

MatchSide::MatchSide(const TriangleMesh& mesh) : mesh_(std::make_unique<MeshDistance>(mesh)) {}

MatchSide::MatchSide(const Truth& truth) {
  if (truth.IsMesh()) {
    mesh_ = std::make_unique<MeshDistance>(truth.mesh);
  } else {
    cloud_ = &truth.cloud;
    tree_ = std::make_unique<CloudDistance>(truth.cloud.points);
  }
}

Match MatchSide::Find(const Eigen::Vector3d& query, double max_distance) const {
  Match match;
  if (mesh_ != nullptr) {
    const SurfacePoint nearest = mesh_->Find(query, max_distance);
    match.found = nearest.face >= 0;
    match.point = nearest.point;
    match.normal = nearest.face_normal;
    match.signed_distance = nearest.SignedDistance(query);
    match.distance = nearest.distance;
    return match;
  }
  const int index = tree_->Find(query, max_distance, &match.distance);
  match.found = index >= 0;
  if (!match.found) return match;
  match.point = cloud_->points[index];
  match.signed_distance = match.distance;
  if (!cloud_->normals.empty() && cloud_->normals[index].norm() > 0) {
    match.normal = cloud_->normals[index].normalized();
    match.signed_distance = match.normal.dot(query - match.point);
  }
  return match;
}

MatchDistances MeasureDistances(const std::vector<Eigen::Vector3d>& points,
                                const Similarity& motion, const MatchSide& side,
                                double max_distance, const std::vector<Eigen::Vector3d>* normals) {
  MatchDistances distances;
  if (normals != nullptr) distances.cosine.assign(points.size(), 0);
  distances.point.assign(points.size(), -1);
  distances.plane.assign(points.size(), -1);
  ParallelFor(static_cast<int>(points.size()), kPointGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const Eigen::Vector3d point = motion * points[k];
      const Match match = side.Find(point, max_distance);
      if (!match.found) continue;
      distances.point[k] = match.distance;
      distances.plane[k] =
          match.normal.isZero(0) ? match.distance : std::abs(match.normal.dot(point - match.point));
      if (normals != nullptr)
        distances.cosine[k] = match.normal.dot(motion.rotation * (*normals)[k]);
    }
  });
  return distances;
}

}  // namespace burin
