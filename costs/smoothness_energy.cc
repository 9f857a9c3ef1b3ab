#include "costs/smoothness_energy.h"

#include <cmath>

namespace burin {

void SmoothnessOptions::Describe(OptionSet* set) {
  set->Add("smooth.type", &type, "Laplacian of the smoothness residuals",
           {"umbrella", "bilaplacian", "cotangent", "none"});
  set->Add(
      "smooth.weight", &weight,
      "Weight of the squared Laplacian in mean edge lengths, against E_photo summed over pixels", 0,
      1e9);
  set->Add(
      "smooth.hidden", &hidden,
      "Vertices that a pair saw in an earlier round and none sees now: smoothed like seen ones, "
      "or keep their shape as those never seen do",
      {"relax", "keep"});
}

Stencil SmoothnessEnergy::MakeStencil(int v) const {
  if (options_.type == "bilaplacian") {
    return BiLaplacianStencil(v, context_->neighbors, context_->boundary);
  }
  if (options_.type == "cotangent") {
    return CotangentStencil(v, *context_->mesh, context_->neighbors, context_->faces,
                            context_->boundary);
  }
  return UmbrellaStencil(v, context_->neighbors, context_->boundary);
}

bool SmoothnessEnergy::KeepsShape(size_t v) const {
  if (options_.hidden == "relax") return context_->was_supported[v] == 0;
  return context_->supported[v] == 0;
}

void SmoothnessEnergy::AddResiduals(ceres::Problem* problem,
                                    std::vector<Eigen::Vector3d>* vertices) {
  if (options_.type == "none" || options_.weight == 0) return;
  std::vector<double*> blocks;
  for (size_t v = 0; v < vertices->size(); ++v) {
    const Stencil stencil = MakeStencil(static_cast<int>(v));
    if (stencil.vertex.empty()) continue;
    double edge_length = 0;
    for (const int* n = context_->neighbors.Begin(v); n != context_->neighbors.End(v); ++n) {
      edge_length += ((*vertices)[*n] - (*vertices)[v]).norm();
    }
    edge_length /= context_->neighbors.Degree(static_cast<int>(v));
    if (!(edge_length > 0)) continue;
    const Eigen::Vector3d target =
        KeepsShape(v) ? Apply(stencil, *vertices) : Eigen::Vector3d::Zero().eval();
    blocks.clear();
    for (int vertex : stencil.vertex) blocks.push_back((*vertices)[vertex].data());
    problem->AddResidualBlock(
        new StencilCost(stencil.coefficient, std::sqrt(options_.weight) / edge_length, target),
        nullptr, blocks);
  }
}

}  // namespace burin
