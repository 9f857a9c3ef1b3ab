#include "core/refine/remeshing.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/mesh/edge_lengths.h"

namespace burin {
namespace {

// By vertex: the lowest one of its connected part; itself where it has no facet.
std::vector<int> FirstOfPart(const TriangleMesh& mesh) {
  std::vector<int> first(mesh.vertices.size());
  std::iota(first.begin(), first.end(), 0);
  for (const std::vector<int>& facets : ConnectedComponents(mesh)) {
    int lowest = static_cast<int>(mesh.vertices.size());
    for (const int f : facets) lowest = std::min(lowest, mesh.faces[f].minCoeff());
    for (const int f : facets) {
      for (const int v : mesh.faces[f]) first[v] = lowest;
    }
  }
  return first;
}

}  // namespace

std::vector<double> WantedEdges(const TriangleMesh& mesh, const std::vector<Camera>& cameras,
                                const std::vector<ViewDomain>& domains,
                                const RemeshingOptions& options) {
  std::vector<std::vector<char>> visible(mesh.faces.size(), std::vector<char>(cameras.size(), 0));
  for (size_t v = 0; v < cameras.size(); ++v) {
    for (const int f : domains[v].facet) visible[f][v] = 1;
  }
  EdgeLengthOptions lengths;
  lengths.chord_px = options.chord_px;
  lengths.min_px = std::min(options.min_edge_px, options.max_edge_px);
  lengths.max_px = options.max_edge_px;
  std::vector<double> widths = PixelWidths(mesh, cameras, &visible);
  // Where no view sees anything: the normalised world's.
  if (!(widths[0] > 0)) widths.assign(widths.size(), 1);
  return EdgeLengths(mesh, widths, lengths);
}

bool StretchToFit(const TriangleMesh& mesh, int max_faces, std::vector<double>* edge_length) {
  double facets = 0;
  for (const Eigen::Vector3i& face : mesh.faces) {
    const Eigen::Vector3d& a = mesh.vertices[face[0]];
    const double area = 0.5 * (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a).norm();
    double length = 0;
    for (const int v : face) length += (*edge_length)[v] / 3;
    facets += area / (0.25 * std::sqrt(3.0) * length * length);
  }
  const double most = 0.9 * max_faces;
  if (facets <= most) return false;
  for (double& length : *edge_length) length *= std::sqrt(facets / most);
  return true;
}

void RemeshState(const TriangleMesh& mesh, const MeshOrder& order,
                 const std::vector<double>& edge_length, const RemeshOptions& options,
                 RefinementState* state) {
  Remeshed made = Remesh(mesh, edge_length, options);
  std::vector<Eigen::Vector3d> input_position;
  std::vector<char> was_supported;
  const std::vector<int> first = state->part.empty() ? FirstOfPart(state->mesh) : state->part;
  state->part.clear();
  for (const RemeshedVertex& on : made.on) {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    int nearest = 0;
    for (int k = 0; k < 3; ++k) {
      position += on.weights[k] * state->input_position[order.vertex[mesh.faces[on.facet][k]]];
      if (on.weights[k] > on.weights[nearest]) nearest = k;
    }
    input_position.push_back(position);
    const int from = order.vertex[mesh.faces[on.facet][nearest]];
    was_supported.push_back(state->was_supported[from]);
    state->part.push_back(first[from]);
  }
  if (state->remesh_start.mesh.vertices.empty()) {
    state->remesh_start = {std::move(state->mesh), std::move(state->input_position),
                           std::move(state->was_supported)};
  }
  state->mesh = std::move(made.mesh);
  state->input_position = std::move(input_position);
  state->was_supported = std::move(was_supported);
  state->order = OrderAlongCurve(state->mesh);
}

void UndoRemeshing(RefinementState* state) {
  state->mesh = std::move(state->remesh_start.mesh);
  state->input_position = std::move(state->remesh_start.input_position);
  state->was_supported = std::move(state->remesh_start.was_supported);
  state->remesh_start = {};
  state->part.clear();
  state->order = OrderAlongCurve(state->mesh);
}

}  // namespace burin
