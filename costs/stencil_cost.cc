#include "costs/stencil_cost.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <utility>

namespace burin {
namespace {

// Neighbours that a vertex is averaged over: on a boundary, the boundary ones.
std::vector<int> SmoothingNeighbors(int v, const Adjacency& neighbors,
                                    const std::vector<char>& boundary) {
  std::vector<int> ring(neighbors.Begin(v), neighbors.End(v));
  if (boundary[v]) {
    ring.erase(std::remove_if(ring.begin(), ring.end(), [&](int n) { return !boundary[n]; }),
               ring.end());
  }
  return ring;
}

double Cotangent(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double sine = a.cross(b).norm();
  return sine > 0 ? a.dot(b) / sine : 0;
}

}  // namespace

Stencil UmbrellaStencil(int v, const Adjacency& neighbors, const std::vector<char>& boundary) {
  const std::vector<int> ring = SmoothingNeighbors(v, neighbors, boundary);
  Stencil stencil;
  if (ring.empty()) return stencil;
  stencil.vertex.push_back(v);
  stencil.coefficient.push_back(-1.0);
  for (int n : ring) {
    stencil.vertex.push_back(n);
    stencil.coefficient.push_back(1.0 / static_cast<double>(ring.size()));
  }
  return stencil;
}

Stencil BiLaplacianStencil(int v, const Adjacency& neighbors, const std::vector<char>& boundary) {
  std::map<int, double> sum;  // ordered, so that the stencil does not depend on hashing
  const Stencil outer = UmbrellaStencil(v, neighbors, boundary);
  for (size_t k = 0; k < outer.vertex.size(); ++k) {
    const Stencil inner = UmbrellaStencil(outer.vertex[k], neighbors, boundary);
    for (size_t m = 0; m < inner.vertex.size(); ++m) {
      sum[inner.vertex[m]] += outer.coefficient[k] * inner.coefficient[m];
    }
  }
  Stencil stencil;
  for (const auto& [vertex, coefficient] : sum) {
    stencil.vertex.push_back(vertex);
    stencil.coefficient.push_back(coefficient);
  }
  return stencil;
}

Stencil CotangentStencil(int v, const TriangleMesh& mesh, const Adjacency& neighbors,
                         const Adjacency& faces, const std::vector<char>& boundary) {
  if (boundary[v]) return UmbrellaStencil(v, neighbors, boundary);
  std::map<int, double> weight;
  for (const int* f = faces.Begin(v); f != faces.End(v); ++f) {
    const Eigen::Vector3i& face = mesh.faces[*f];
    const int corner = face[0] == v ? 0 : (face[1] == v ? 1 : 2);
    const int next = face[(corner + 1) % 3];
    const int last = face[(corner + 2) % 3];
    const Eigen::Vector3d& p = mesh.vertices[v];
    const Eigen::Vector3d& a = mesh.vertices[next];
    const Eigen::Vector3d& b = mesh.vertices[last];
    weight[next] += 0.5 * std::max(0.0, Cotangent(p - b, a - b));
    weight[last] += 0.5 * std::max(0.0, Cotangent(p - a, b - a));
  }
  double total = 0;
  for (const auto& entry : weight) total += entry.second;
  if (total <= 0) return UmbrellaStencil(v, neighbors, boundary);
  Stencil stencil;
  stencil.vertex.push_back(v);
  stencil.coefficient.push_back(-1.0);
  for (const auto& [vertex, w] : weight) {
    stencil.vertex.push_back(vertex);
    stencil.coefficient.push_back(w / total);
  }
  return stencil;
}

StencilCost::StencilCost(std::vector<double> coefficients, double scale,
                         const Eigen::Vector3d& target)
    : coefficients_(std::move(coefficients)), offset_(-scale * target) {
  for (double& c : coefficients_) c *= scale;
  set_num_residuals(3);
  mutable_parameter_block_sizes()->assign(coefficients_.size(), 3);
}

bool StencilCost::Evaluate(double const* const* parameters, double* residuals,
                           double** jacobians) const {
  Eigen::Map<Eigen::Vector3d> r(residuals);
  r = offset_;
  for (size_t k = 0; k < coefficients_.size(); ++k) {
    r += coefficients_[k] * Eigen::Map<const Eigen::Vector3d>(parameters[k]);
  }
  if (jacobians == nullptr) return true;
  for (size_t k = 0; k < coefficients_.size(); ++k) {
    if (jacobians[k] == nullptr) continue;
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> jacobian(jacobians[k]);
    jacobian.setZero();
    jacobian.diagonal().setConstant(coefficients_[k]);
  }
  return true;
}

StencilBlocks::StencilBlocks(Adjacency vertices, std::vector<double> coefficients,
                             const std::vector<Eigen::Vector3d>* positions)
    : EnergyBlocks(std::move(vertices)),
      coefficients_(std::move(coefficients)),
      positions_(positions) {}

void StencilBlocks::SetRest(int k, const std::vector<Eigen::Vector3d>& rest) {
  if (offsets_.empty()) offsets_.assign(size(), Eigen::Vector3d::Zero());
  offsets_[k].setZero();
  offsets_[k] = -Sum(k, rest);
}

Eigen::Vector3d StencilBlocks::Sum(int k, const std::vector<Eigen::Vector3d>& positions) const {
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  for (int e = parameters_.start[k]; e < parameters_.start[k + 1]; ++e) {
    r += coefficients_[e] * positions[parameters_.index[e]];
  }
  return r;
}

bool StencilBlocks::Evaluate(int k, const TangentDirections* directions, double* energy,
                             double* gradient, double* curvature) const {
  Eigen::Vector3d r = Sum(k, *positions_);
  if (!offsets_.empty()) r += offsets_[k];
  *energy = 0.5 * r.squaredNorm();
  if (gradient == nullptr) return true;
  // J's columns, one an unknown.
  static thread_local std::vector<Eigen::Vector3d> columns;
  columns.clear();
  const double* coefficient = &coefficients_[parameters_.start[k]];
  for (int p = 0; p < parameters_.Degree(k); ++p) {
    const auto& [plus, count] = directions[p];
    for (int c = 0; c < count; ++c) {
      columns.emplace_back(coefficient[p] *
                           Eigen::Vector3d(plus[c], plus[count + c], plus[2 * count + c]));
    }
  }
  const size_t unknowns = columns.size();
  for (size_t i = 0; i < unknowns; ++i) {
    gradient[i] = columns[i].dot(r);
    if (curvature == nullptr) continue;
    for (size_t j = i; j < unknowns; ++j) {
      curvature[i * unknowns + j] = columns[i].dot(columns[j]);
    }
  }
  return true;
}

CostFunctions StencilBlocks::MakeCostFunctions() const {
  CostFunctions made;
  made.parameters = parameters_;
  made.costs.reserve(size());
  for (int k = 0; k < size(); ++k) {
    made.costs.push_back(std::make_unique<StencilCost>(
        std::vector<double>(coefficients_.begin() + parameters_.start[k],
                            coefficients_.begin() + parameters_.start[k + 1]),
        1.0, offsets_.empty() ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(-offsets_[k])));
  }
  return made;
}

}  // namespace burin
