#include "core/mesh/closest_point.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <nanoflann.hpp>
#include <tuple>
#include <utility>

#include "core/mesh/embree_mesh.h"
#include "core/mesh/triangle_point.h"

namespace burin {
namespace {

Eigen::Vector3d UnitOrZero(const Eigen::Vector3d& vector) {
  const double length = vector.norm();
  return length > 0 ? Eigen::Vector3d(vector / length) : Eigen::Vector3d::Zero();
}

// Sums of unit face normals weighted by the angle the face has at the vertex, made unit.
std::vector<Eigen::Vector3d> AngleWeightedNormals(
    const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& face_normals) {
  std::vector<Eigen::Vector3d> normals(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d& corner = mesh.vertices[mesh.faces[f][c]];
      const Eigen::Vector3d to_next = mesh.vertices[mesh.faces[f][(c + 1) % 3]] - corner;
      const Eigen::Vector3d to_last = mesh.vertices[mesh.faces[f][(c + 2) % 3]] - corner;
      const double angle = std::atan2(to_next.cross(to_last).norm(), to_next.dot(to_last));
      normals[mesh.faces[f][c]] += angle * face_normals[f];
    }
  }
  for (Eigen::Vector3d& normal : normals) normal = UnitOrZero(normal);
  return normals;
}

// The face across edge (c, c+1) of each face; -1 on a boundary or where more than two faces meet.
std::vector<std::array<int, 3>> FacesAcross(const TriangleMesh& mesh) {
  struct Side {
    int low, high, face, edge;
    bool SameEdge(const Side& other) const { return low == other.low && high == other.high; }
  };
  std::vector<Side> sides;
  sides.reserve(mesh.faces.size() * 3);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const int a = mesh.faces[f][c];
      const int b = mesh.faces[f][(c + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<int>(f), c});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.face, a.edge) < std::tie(b.low, b.high, b.face, b.edge);
  });
  std::vector<std::array<int, 3>> across(mesh.faces.size(), {-1, -1, -1});
  for (size_t begin = 0; begin < sides.size();) {
    size_t end = begin + 1;
    while (end < sides.size() && sides[end].SameEdge(sides[begin])) ++end;
    if (end - begin == 2) {
      across[sides[begin].face][sides[begin].edge] = sides[begin + 1].face;
      across[sides[begin + 1].face][sides[begin + 1].edge] = sides[begin].face;
    }
    begin = end;
  }
  return across;
}

// nanoflann's view of a vector of points.
struct CloudAdaptor {
  std::vector<Eigen::Vector3d> points;
  size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(size_t index, size_t axis) const {
    return points[index][static_cast<int>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

// nanoflann result set for one neighbour within a given distance, so that far queries end early.
struct NearestWithin {
  double squared_distance;
  int index = -1;
  size_t size() const { return index < 0 ? 0 : 1; }
  bool full() const { return true; }
  double worstDist() const { return squared_distance; }  // NOLINT: nanoflann's name
  bool addPoint(double candidate, unsigned candidate_index) {
    if (candidate < squared_distance) {
      squared_distance = candidate;
      index = static_cast<int>(candidate_index);
    }
    return true;
  }
};

using CloudTree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, CloudAdaptor>,
                                        CloudAdaptor, 3, unsigned>;

}  // namespace

struct MeshDistance::Data {
  explicit Data(const TriangleMesh& input) : mesh(input), embree(input) {
    face_normals.resize(mesh.faces.size());
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      face_normals[f] = UnitOrZero(FaceAreaNormal(mesh, static_cast<int>(f)));
    }
    vertex_normals = AngleWeightedNormals(mesh, face_normals);
    across = FacesAcross(mesh);
  }

  Eigen::Vector3d Pseudonormal(int face, const TrianglePoint& point) const {
    switch (point.feature) {
      case TriangleFeature::kFace:
        return face_normals[face];
      case TriangleFeature::kCorner:
        return vertex_normals[mesh.faces[face][point.which]];
      case TriangleFeature::kEdge:
        break;
    }
    const int other = across[face][point.which];
    return other < 0 ? face_normals[face] : UnitOrZero(face_normals[face] + face_normals[other]);
  }

  TriangleMesh mesh;
  EmbreeMesh embree;
  std::vector<Eigen::Vector3d> face_normals;
  std::vector<Eigen::Vector3d> vertex_normals;
  std::vector<std::array<int, 3>> across;
};

namespace {

// State of one query while Embree hands over candidate faces.
struct ClosestSearch {
  const TriangleMesh* mesh;
  Eigen::Vector3d query;
  double slack;                 // added to the radius: Embree's boxes bound rounded vertices
  double max_squared_distance;  // asked for by the caller
  TrianglePoint best;
  int face = -1;
};

bool VisitFace(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<ClosestSearch*>(arguments->userPtr);
  const int face = static_cast<int>(arguments->primID);
  const Eigen::Vector3i& index = search.mesh->faces[face];
  const Eigen::Vector3d corners[3] = {search.mesh->vertices[index[0]],
                                      search.mesh->vertices[index[1]],
                                      search.mesh->vertices[index[2]]};
  const TrianglePoint candidate = ClosestOnTriangle(search.query, corners);
  if (!(candidate.squared_distance <= search.max_squared_distance)) return false;
  const bool nearer = candidate.squared_distance < search.best.squared_distance;
  const bool first_of_equals =
      candidate.squared_distance == search.best.squared_distance && face < search.face;
  if (!nearer && !first_of_equals) return false;
  search.best = candidate;
  search.face = face;
  // Only ever shrinks; the slack keeps faces that tie with the best inside the radius.
  const double radius = std::sqrt(candidate.squared_distance) * (1 + 1e-6) + search.slack;
  if (radius >= arguments->query->radius) return false;
  arguments->query->radius = static_cast<float>(radius);
  return true;
}

}  // namespace

MeshDistance::MeshDistance(const TriangleMesh& mesh) : data_(std::make_unique<Data>(mesh)) {}
MeshDistance::~MeshDistance() = default;
MeshDistance::MeshDistance(MeshDistance&&) noexcept = default;

SurfacePoint MeshDistance::Find(const Eigen::Vector3d& query, double max_distance) const {
  SurfacePoint result;
  if (!query.allFinite()) return result;
  const Eigen::Vector3f local = data_->embree.Local(query);
  // Rounding of the stored vertices and of the query itself.
  const double slack = 4 * (data_->embree.rounding() +
                            local.cast<double>().norm() * std::numeric_limits<float>::epsilon());
  ClosestSearch search{&data_->mesh,    query, slack, max_distance * max_distance,
                       TrianglePoint(), -1};
  RTCPointQuery point_query;
  point_query.x = local.x();
  point_query.y = local.y();
  point_query.z = local.z();
  point_query.time = 0;
  point_query.radius = static_cast<float>(max_distance + slack);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(data_->embree.scene(), &point_query, &context, VisitFace, &search);
  if (search.face < 0) return result;
  result.face = search.face;
  result.point = search.best.point;
  result.face_normal = data_->face_normals[search.face];
  result.normal = data_->Pseudonormal(search.face, search.best);
  result.distance = std::sqrt(search.best.squared_distance);
  return result;
}

struct CloudDistance::Data {
  explicit Data(std::vector<Eigen::Vector3d> points) : cloud{std::move(points)}, tree(3, cloud) {}
  CloudAdaptor cloud;
  CloudTree tree;
};

CloudDistance::CloudDistance(std::vector<Eigen::Vector3d> points)
    : data_(std::make_unique<Data>(std::move(points))) {}
CloudDistance::~CloudDistance() = default;
CloudDistance::CloudDistance(CloudDistance&&) noexcept = default;

int CloudDistance::Find(const Eigen::Vector3d& query, double max_distance, double* distance) const {
  // nanoflann compares with <; the next double keeps a point at max_distance itself.
  NearestWithin nearest{
      std::nextafter(max_distance * max_distance, std::numeric_limits<double>::infinity())};
  data_->tree.findNeighbors(nearest, query.data(), nanoflann::SearchParams());
  if (nearest.index >= 0 && distance != nullptr) *distance = std::sqrt(nearest.squared_distance);
  return nearest.index;
}

}  // namespace burin
