#include <algorithm>

#include "core/mesh/remesh_steps.h"

namespace burin {
namespace {

using OpenMesh::EdgeHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

// Beside a longer edge that is too long: that one comes first. Where it must stay whole, splitting others would go
// on for ever.
bool IsBesideLonger(const RemeshState& state, EdgeHandle edge) {
  const OpenMesh::TriConnectivity& mesh = state.half_edges();
  for (int side = 0; side < 2; ++side) {
    const HalfedgeHandle h = mesh.halfedge_handle(edge, side);
    if (mesh.is_boundary(h)) continue;
    const HalfedgeHandle next = mesh.next_halfedge_handle(h);
    for (const HalfedgeHandle other : {next, mesh.next_halfedge_handle(next)}) {
      if (state.Length(other) > state.Length(h) &&
          state.LengthRatio(mesh.edge_handle(other)) > kTooLong) {
        return true;
      }
    }
  }
  return false;
}

// Both facets at the edge have the same corners: halves of it would have two edges in common.
bool IsFolded(const RemeshState& state, EdgeHandle edge) {
  const OpenMesh::TriConnectivity& mesh = state.half_edges();
  if (mesh.is_boundary(edge)) return false;
  const VertexHandle c = state.Opposite(mesh.halfedge_handle(edge, 0));
  const VertexHandle d = state.Opposite(mesh.halfedge_handle(edge, 1));
  return c == d || (state[c].fixed >= 0 && state[c].fixed == state[d].fixed);
}

}  // namespace

void SortQueue(EdgeQueue* queue) {
  std::sort(queue->begin(), queue->end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second.idx() < b.second.idx();
  });
}

int SplitLongEdges(RemeshState* state) {
  OpenMesh::TriConnectivity& mesh = state->half_edges();
  int count = 0;
  for (;;) {
    EdgeQueue queue;
    for (int e = 0; e < static_cast<int>(mesh.n_edges()); ++e) {
      const EdgeHandle edge(e);
      if (!state->IsAlive(edge) || state->LengthRatio(edge) <= kTooLong || state->IsFixed(edge)) {
        continue;
      }
      queue.emplace_back(-state->Length(mesh.halfedge_handle(edge, 0)), edge);
    }
    SortQueue(&queue);
    int done = 0;
    for (const auto& [key, edge] : queue) {
      if (IsBesideLonger(*state, edge) || IsFolded(*state, edge)) continue;
      const HalfedgeHandle h = mesh.halfedge_handle(edge, 0);
      const RemeshVertex& from = (*state)[state->From(h)];
      const RemeshVertex& to = (*state)[state->To(h)];
      RemeshVertex near = from.fixed < 0 ? from : to;
      near.fixed = -1;
      if (!mesh.is_boundary(edge)) near.border = -1;
      const RemeshVertex middle = state->At(0.5 * (from.position + to.position), near);
      mesh.split(edge, state->Add(middle));
      ++done;
    }
    if (done == 0) return count;
    count += done;
  }
}

}  // namespace burin
