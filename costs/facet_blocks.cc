#include "costs/facet_blocks.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/support/parallel.h"
#include "costs/patch_cost.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 256;
constexpr int kFacetGrain = 1024;

std::vector<int> FacetsOfSeen(const RoundContext& context) {
  std::vector<int> facets;
  for (size_t f = 0; f < context.mesh->faces.size(); ++f) {
    const Eigen::Vector3i& face = context.mesh->faces[f];
    if (context.seen[face[0]] != 0 || context.seen[face[1]] != 0 || context.seen[face[2]] != 0) {
      facets.push_back(static_cast<int>(f));
    }
  }
  return facets;
}

Adjacency VerticesOf(const RoundContext& context, const std::vector<int>& facets) {
  Adjacency vertices;
  vertices.start.push_back(0);
  for (const int f : facets) {
    for (const int v : context.mesh->faces[f]) vertices.index.push_back(v);
    vertices.start.push_back(static_cast<int>(vertices.index.size()));
  }
  vertices.index.shrink_to_fit();
  vertices.start.shrink_to_fit();
  return vertices;
}

// Facets with both vertices; more than 255 of one edge count as 255.
uint8_t FacetsWith(const RoundContext& context, int a, int b) {
  int count = 0;
  for (const int* f = context.faces.Begin(a); f != context.faces.End(a); ++f) {
    const Eigen::Vector3i& face = context.mesh->faces[*f];
    count += face[0] == b || face[1] == b || face[2] == b ? 1 : 0;
  }
  return static_cast<uint8_t>(std::min(count, 255));
}

std::vector<int> SeenVertices(const RoundContext& context) {
  std::vector<int> seen;
  for (size_t v = 0; v < context.seen.size(); ++v) {
    if (context.seen[v] != 0) seen.push_back(static_cast<int>(v));
  }
  return seen;
}

// One unknown of a facet.
struct Unknown {
  int corner;
  double along;  // n . d
  Eigen::Vector3d direction;
};

}  // namespace

FacetBlocks::FacetBlocks(const PhotometricRound* round)
    : FacetBlocks(round, FacetsOfSeen(round->context())) {}

FacetBlocks::FacetBlocks(const PhotometricRound* round, std::vector<int> facets)
    : EnergyBlocks(VerticesOf(round->context(), facets)), round_(round), facet_(std::move(facets)) {
  const RoundContext& context = round->context();
  sharing_.resize(facet_.size());
  ParallelFor(size(), kFacetGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const int* v = parameters_.Begin(k);
      sharing_[k] = {FacetsWith(context, v[0], v[1]), FacetsWith(context, v[1], v[2]),
                     FacetsWith(context, v[2], v[0])};
    }
  });
}

void FacetBlocks::Prepare(bool curvature) {
  if (!curvature || scaled_at_ == round_->EvaluationCount()) return;
  const std::vector<char>& seen = round_->context().seen;
  scales_.resize(seen.size());
  ParallelFor(static_cast<int>(seen.size()), kVertexGrain, [&](int begin, int end) {
    static thread_local PatchSystem system;
    for (int v = begin; v < end; ++v) {
      if (seen[v] == 0) continue;
      system.Make(*round_, v);
      scales_[v] = ScaleOf(system);
    }
  });
  scaled_at_ = round_->EvaluationCount();
}

bool FacetBlocks::Evaluate(int k, const TangentDirections* directions, double* energy,
                           double* gradient, double* curvature) const {
  const RoundContext& context = round_->context();
  const int* vertices = parameters_.Begin(k);
  const size_t first = 3 * static_cast<size_t>(facet_[k]);
  const Eigen::Vector3d& normal = round_->facet_normals()[facet_[k]];
  double share = 0;
  double slope[3] = {0, 0, 0};
  double bend[6] = {0, 0, 0, 0, 0, 0};  // curvature, packed
  double damping[3] = {0, 0, 0};
  double finite = 0;
  for (int c = 0; c < 3; ++c) {
    if (context.seen[vertices[c]] == 0) continue;
    const CornerSums sums = round_->corner_sums()[first + c];
    share += sums.share;
    for (int l = 0; l < 3; ++l) slope[l] += sums.slope[l];
    if (curvature == nullptr) {
      finite += sums.curvature[0] + sums.curvature[3] + sums.curvature[5];
      continue;
    }
    const PatchScale& scale = scales_[vertices[c]];
    for (int e = 0; e < 6; ++e) bend[e] += scale.beta_squared * sums.curvature[e];
    damping[c] += scale.damping / context.faces.Degree(vertices[c]);
    damping[(c + 1) % 3] += scale.damping / sharing_[k][c];
    damping[(c + 2) % 3] += scale.damping / sharing_[k][(c + 2) % 3];
  }
  *energy = std::max(0.0, share);
  finite += share + slope[0] + slope[1] + slope[2] + bend[0] + bend[3] + bend[5] + damping[0] +
            damping[1] + damping[2];
  if (!std::isfinite(finite * normal.squaredNorm())) return false;
  if (gradient == nullptr) return true;

  Unknown unknowns[9];
  int count = 0;
  for (int c = 0; c < 3; ++c) {
    const auto& [plus, columns] = directions[c];
    for (int d = 0; d < columns; ++d) {
      const Eigen::Vector3d direction(plus[d], plus[columns + d], plus[2 * columns + d]);
      unknowns[count++] = {c, normal.dot(direction), direction};
    }
  }
  for (int i = 0; i < count; ++i) {
    const Unknown& row = unknowns[i];
    gradient[i] = slope[row.corner] * row.along;
    if (curvature == nullptr) continue;
    for (int j = i; j < count; ++j) {
      const Unknown& column = unknowns[j];
      double value = bend[CornerSums::Packed(row.corner, column.corner)] * row.along * column.along;
      if (row.corner == column.corner) {
        value += damping[row.corner] * row.direction.dot(column.direction);
      }
      curvature[i * count + j] = value;
    }
  }
  return true;
}

CostFunctions FacetBlocks::MakeCostFunctions() const {
  if (round_->MovesCameras()) return {{}, {{0}, {}}, {}};
  const std::vector<int> seen = SeenVertices(round_->context());
  const auto factors = std::make_shared<std::vector<PatchFactor>>(seen.size());
  factors_ = factors;
  CostFunctions made;
  made.costs.resize(seen.size());
  made.parameters.start.push_back(0);
  std::vector<int> vertices;
  for (size_t p = 0; p < seen.size(); ++p) {
    PatchVertices(round_->context(), seen[p], &vertices);
    made.costs[p] = std::make_unique<PatchCost>(round_, vertices, factors, p);
    made.parameters.index.insert(made.parameters.index.end(), vertices.begin(), vertices.end());
    made.parameters.start.push_back(static_cast<int>(made.parameters.index.size()));
  }
  return made;
}

void FacetBlocks::FactorForCeres() const {
  const std::shared_ptr<std::vector<PatchFactor>> factors = factors_.lock();
  if (factors == nullptr) return;
  const std::vector<int> seen = SeenVertices(round_->context());
  ParallelFor(static_cast<int>(seen.size()), kVertexGrain, [&](int begin, int end) {
    static thread_local PatchSystem system;
    for (int p = begin; p < end; ++p) {
      PatchFactor& factor = (*factors)[p];
      if (factor.at == round_->EvaluationCount()) continue;
      system.Make(*round_, seen[p]);
      Factor(system, &factor);
      factor.at = round_->EvaluationCount();
    }
  });
}

}  // namespace burin
