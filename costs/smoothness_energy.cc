#include "costs/smoothness_energy.h"

#include <cmath>

#include "core/support/parallel.h"
#include "costs/stencil_cost.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 512;

class SmoothnessRound : public TermRound {
 public:
  SmoothnessRound(const SmoothnessOptions& options, const RoundContext& context)
      : options_(options), context_(context) {}
  void AddResiduals(ceres::Problem* problem, RoundParameters* parameters) override;
  void SupportIsKnown() override;

 private:
  Stencil MakeStencil(int v) const;
  const SmoothnessOptions options_;
  const RoundContext& context_;
  std::vector<Stencil> stencils_;    // by vertex; empty once the support is known
  std::vector<StencilCost*> costs_;  // by vertex, null where there is none; owned by the problem
};

Stencil SmoothnessRound::MakeStencil(int v) const {
  if (options_.type == SmoothnessType::kBilaplacian) {
    return BiLaplacianStencil(v, context_.neighbors, context_.boundary);
  }
  if (options_.type == SmoothnessType::kCotangent) {
    return CotangentStencil(v, *context_.mesh, context_.neighbors, context_.faces,
                            context_.boundary);
  }
  return UmbrellaStencil(v, context_.neighbors, context_.boundary);
}

void SmoothnessRound::AddResiduals(ceres::Problem* problem, RoundParameters* parameters) {
  if (options_.type == SmoothnessType::kNone || options_.weight == 0) return;
  std::vector<Eigen::Vector3d>& vertices = parameters->vertices;
  const auto count = static_cast<int>(vertices.size());
  stencils_.resize(count);
  costs_.assign(count, nullptr);
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      stencils_[v] = MakeStencil(v);
      if (stencils_[v].vertex.empty()) continue;
      double edge_length = 0;
      for (const int* n = context_.neighbors.Begin(v); n != context_.neighbors.End(v); ++n) {
        edge_length += (vertices[*n] - vertices[v]).norm();
      }
      edge_length /= context_.neighbors.Degree(v);
      if (!(edge_length > 0)) continue;
      costs_[v] =
          new StencilCost(stencils_[v].coefficient, std::sqrt(options_.weight) / edge_length);
    }
  });
  std::vector<double*> blocks;
  for (int v = 0; v < count; ++v) {
    if (costs_[v] == nullptr) continue;
    blocks.clear();
    for (int vertex : stencils_[v].vertex) blocks.push_back(vertices[vertex].data());
    problem->AddResidualBlock(costs_[v], nullptr, blocks);
  }
}

void SmoothnessRound::SupportIsKnown() {
  for (size_t v = 0; v < costs_.size(); ++v) {
    if (costs_[v] == nullptr || context_.keeps_shape[v] == 0) continue;
    costs_[v]->SetTarget(Apply(stencils_[v], context_.mesh->vertices));
  }
  stencils_ = {};
  costs_ = {};
}

}  // namespace

void SmoothnessOptions::Describe(OptionSet* set) {
  set->Add("smooth.type", &type, "Laplacian of the smoothness residuals");
  set->Add(
      "smooth.weight", &weight,
      "Weight of the squared Laplacian in mean edge lengths, against E_photo summed over pixels", 0,
      1e9);
}

std::unique_ptr<TermRound> SmoothnessEnergy::Freeze(const RoundContext& context) {
  return std::make_unique<SmoothnessRound>(options_, context);
}

}  // namespace burin
