#include "core/synthetic/synthetic_shapes.h"

// OpenMesh copies default-constructed vectors, which GCC 12 reports where it inlines them.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModAspectRatioT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/mesh/openmesh_silence.h"
#include "core/support/counter_random.h"

namespace burin {
namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
  FaceAttributes(OpenMesh::Attributes::Normal | OpenMesh::Attributes::Status);
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  HalfedgeAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::PrevHalfedge);
};
using HalfedgeMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

int CellCount(double length, double edge) {
  return std::max(2, static_cast<int>(std::ceil(length / edge)));
}

// Splits a quad given counter-clockwise; `flip` chooses the other diagonal.
void AddQuad(int a, int b, int c, int d, bool flip, TriangleMesh* mesh) {
  if (flip) {
    mesh->faces.emplace_back(a, b, d);
    mesh->faces.emplace_back(b, c, d);
  } else {
    mesh->faces.emplace_back(a, b, c);
    mesh->faces.emplace_back(a, c, d);
  }
}

// Point and outward normal of the body that belong to a point on the box around it.
std::pair<Eigen::Vector3d, Eigen::Vector3d> OnBody(const BodyShape& shape,
                                                   const Eigen::Vector3d& on_box) {
  if (shape.ellipsoid) {
    const Eigen::Vector3d direction = on_box.cwiseQuotient(shape.half_extent).normalized();
    return {direction.cwiseProduct(shape.half_extent),
            direction.cwiseQuotient(shape.half_extent).normalized()};
  }
  // With sharp edges the normal of an edge point is still wanted: a tiny rounding gives one.
  const double radius = std::max(shape.rounding, 1e-6 * shape.half_extent.minCoeff());
  const Eigen::Vector3d inner_extent = (shape.half_extent.array() - radius).max(0).matrix();
  const Eigen::Vector3d inner = on_box.cwiseMax(-inner_extent).cwiseMin(inner_extent);
  const Eigen::Vector3d normal = (on_box - inner).normalized();
  return {inner + radius * normal, normal};
}

void TaubinStep(const Adjacency& neighbors, const std::vector<char>& fixed, double factor,
                std::vector<Eigen::Vector3d>* vertices) {
  std::vector<Eigen::Vector3d> moved = *vertices;
  for (size_t v = 0; v < moved.size(); ++v) {
    const int vertex = static_cast<int>(v);
    if (fixed[v] != 0 || neighbors.Degree(vertex) == 0) continue;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const int* n = neighbors.Begin(vertex); n != neighbors.End(vertex); ++n) {
      mean += (*vertices)[*n];
    }
    mean /= neighbors.Degree(vertex);
    moved[v] += factor * (mean - (*vertices)[v]);
  }
  *vertices = std::move(moved);
}

HalfedgeMesh ToHalfedges(const TriangleMesh& mesh) {
  HalfedgeMesh halfedges;
  const OpenMeshSilence silence;  // add_face prints a line for every face it refuses
  std::vector<OpenMesh::VertexHandle> handles;
  handles.reserve(mesh.vertices.size());
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    handles.push_back(halfedges.add_vertex({vertex.x(), vertex.y(), vertex.z()}));
  }
  for (const Eigen::Vector3i& face : mesh.faces) {
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) continue;
    halfedges.add_face(handles[face[0]], handles[face[1]], handles[face[2]]);
  }
  halfedges.delete_isolated_vertices();
  halfedges.garbage_collection();
  return halfedges;
}

TriangleMesh FromHalfedges(const HalfedgeMesh& halfedges) {
  TriangleMesh mesh;
  for (const auto vertex : halfedges.vertices()) {
    const auto& point = halfedges.point(vertex);
    mesh.vertices.emplace_back(point[0], point[1], point[2]);
  }
  for (const auto face : halfedges.faces()) {
    Eigen::Vector3i indices;
    int corner = 0;
    for (const auto vertex : halfedges.fv_range(face)) indices[corner++] = vertex.idx();
    mesh.faces.push_back(indices);
  }
  return mesh;
}

}  // namespace

TriangleMesh HeightFieldMesh(double half_width, double half_height, double edge,
                             const std::function<double(double, double)>& height) {
  const int cols = CellCount(2 * half_width, edge);
  const int rows = CellCount(2 * half_height, edge);
  TriangleMesh mesh;
  for (int r = 0; r <= rows; ++r) {
    for (int c = 0; c <= cols; ++c) {
      const double x = half_width * (2.0 * c / cols - 1);
      const double y = half_height * (2.0 * r / rows - 1);
      mesh.vertices.emplace_back(x, y, height(x, y));
    }
  }
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      const int corner = r * (cols + 1) + c;
      // Diagonals alternate so that the coarse surface has no preferred direction.
      AddQuad(corner, corner + 1, corner + cols + 2, corner + cols + 1, (r + c) % 2 == 0, &mesh);
    }
  }
  return mesh;
}

TriangleMesh BodyMesh(const BodyShape& shape, double edge,
                      const std::function<double(const Eigen::Vector3d&)>& offset) {
  std::array<int, 3> cells;
  for (int axis = 0; axis < 3; ++axis) cells[axis] = CellCount(2 * shape.half_extent[axis], edge);
  TriangleMesh mesh;
  // Vertices of the box grid are numbered when first met; the sides share those on their rims.
  const size_t stride_y = static_cast<size_t>(cells[0]) + 1;
  const size_t stride_z = stride_y * (static_cast<size_t>(cells[1]) + 1);
  std::vector<int> number(stride_z * (static_cast<size_t>(cells[2]) + 1), -1);
  const auto vertex = [&](const std::array<int, 3>& at) {
    int& id = number[at[0] + at[1] * stride_y + at[2] * stride_z];
    if (id < 0) {
      Eigen::Vector3d on_box;
      for (int axis = 0; axis < 3; ++axis) {
        on_box[axis] = shape.half_extent[axis] * (2.0 * at[axis] / cells[axis] - 1);
      }
      const auto [point, normal] = OnBody(shape, on_box);
      id = static_cast<int>(mesh.vertices.size());
      mesh.vertices.emplace_back(point + offset(point) * normal);
    }
    return id;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (const bool upper : {false, true}) {
      for (int a = 0; a < cells[u]; ++a) {
        for (int b = 0; b < cells[v]; ++b) {
          const auto corner = [&](int da, int db) {
            std::array<int, 3> at;
            at[axis] = upper ? cells[axis] : 0;
            at[u] = a + da;
            at[v] = b + db;
            return vertex(at);
          };
          const bool flip = (a + b) % 2 == 0;
          if (upper) {
            AddQuad(corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1), flip, &mesh);
          } else {
            AddQuad(corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0), flip, &mesh);
          }
        }
      }
    }
  }
  return mesh;
}

void AppendMesh(const TriangleMesh& part, const Eigen::Matrix3d& rotation,
                const Eigen::Vector3d& translation, TriangleMesh* mesh) {
  const int first = static_cast<int>(mesh->vertices.size());
  for (const Eigen::Vector3d& vertex : part.vertices) {
    mesh->vertices.emplace_back(rotation * vertex + translation);
  }
  for (const Eigen::Vector3i& face : part.faces) {
    mesh->faces.emplace_back(face.array() + first);
  }
}

TriangleMesh CoarsenedMesh(const TriangleMesh& mesh, double edge, int smoothing_steps) {
  double area = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    area += FaceAreaNormal(mesh, static_cast<int>(f)).norm() / 2;
  }
  const double face_area = std::sqrt(3.0) / 4 * edge * edge;
  const auto target = static_cast<size_t>(std::clamp(area / face_area, 4.0, 1e9));

  HalfedgeMesh halfedges = ToHalfedges(mesh);
  halfedges.update_normals();
  using Decimater = OpenMesh::Decimater::DecimaterT<HalfedgeMesh>;
  Decimater decimater(halfedges);
  OpenMesh::Decimater::ModQuadricT<HalfedgeMesh>::Handle quadric;
  decimater.add(quadric);
  decimater.module(quadric).unset_max_err();  // as a priority, not a limit
  OpenMesh::Decimater::ModNormalFlippingT<HalfedgeMesh>::Handle flipping;
  decimater.add(flipping);
  decimater.module(flipping).set_max_normal_deviation(60);
  OpenMesh::Decimater::ModAspectRatioT<HalfedgeMesh>::Handle aspect;
  decimater.add(aspect);
  decimater.module(aspect).set_aspect_ratio(6);
  if (halfedges.n_faces() > target && decimater.initialize()) {
    decimater.decimate_to_faces(0, target);
    halfedges.delete_isolated_vertices();
    halfedges.garbage_collection();
  }

  TriangleMesh coarse = FromHalfedges(halfedges);
  const Adjacency neighbors = VertexNeighbors(coarse, VertexFaces(coarse));
  const std::vector<char> boundary = BoundaryVertices(coarse, VertexFaces(coarse));
  for (int step = 0; step < smoothing_steps; ++step) {
    TaubinStep(neighbors, boundary, 0.5, &coarse.vertices);
    TaubinStep(neighbors, boundary, -0.53, &coarse.vertices);
  }
  return coarse;
}

void PerturbAlongNormals(std::uint64_t seed, double sigma, TriangleMesh* mesh) {
  const CounterRandom random(seed, 0x696E6974U);
  const std::vector<Eigen::Vector3d> normals = VertexNormals(*mesh, VertexFaces(*mesh));
  for (size_t v = 0; v < normals.size(); ++v) {
    mesh->vertices[v] += sigma * random.Normal(v) * normals[v];
  }
}

}  // namespace burin
