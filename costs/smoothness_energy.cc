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
    const Eigen::Vector3d target = context_->was_supported[v] != 0 ? Eigen::Vector3d::Zero().eval()
                                                                   : Apply(stencil, *vertices);
    blocks.clear();
    for (int vertex : stencil.vertex) blocks.push_back((*vertices)[vertex].data());
    problem->AddResidualBlock(
        new StencilCost(stencil.coefficient, std::sqrt(options_.weight) / edge_length, target),
        nullptr, blocks);
  }
}

}  // namespace burin
