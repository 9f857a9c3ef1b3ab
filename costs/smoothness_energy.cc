#include "costs/smoothness_energy.h"

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/support/parallel.h"
#include "costs/stencil_cost.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 512;

class SmoothnessRound : public TermRound {
 public:
  SmoothnessRound(const SmoothnessOptions& options, const RoundContext& context)
      : options_(options), context_(context) {}
  void AddBlocks(RoundEnergy* energy) override;
  void SupportIsKnown() override;

 private:
  Stencil MakeStencil(int v) const;
  const SmoothnessOptions options_;
  const RoundContext& context_;
  std::vector<int> vertex_;          // of each block
  StencilBlocks* blocks_ = nullptr;  // owned by the round's energy
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

void SmoothnessRound::AddBlocks(RoundEnergy* energy) {
  if (options_.type == SmoothnessType::kNone || options_.weight == 0) return;
  const std::vector<Eigen::Vector3d>& vertices = energy->parameters().vertices;
  const auto count = static_cast<int>(vertices.size());
  std::vector<Stencil> stencils(count);
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      double edge_length = 0;
      for (const int* n = context_.neighbors.Begin(v); n != context_.neighbors.End(v); ++n) {
        edge_length += (vertices[*n] - vertices[v]).norm();
      }
      edge_length /= context_.neighbors.Degree(v);
      if (!(edge_length > 0)) continue;
      stencils[v] = MakeStencil(v);
      for (double& c : stencils[v].coefficient) c *= std::sqrt(options_.weight) / edge_length;
    }
  });
  Adjacency adjacency;
  adjacency.start.push_back(0);
  std::vector<double> coefficients;
  for (int v = 0; v < count; ++v) {
    if (stencils[v].vertex.empty()) continue;
    vertex_.push_back(v);
    adjacency.index.insert(adjacency.index.end(), stencils[v].vertex.begin(),
                           stencils[v].vertex.end());
    adjacency.start.push_back(static_cast<int>(adjacency.index.size()));
    coefficients.insert(coefficients.end(), stencils[v].coefficient.begin(),
                        stencils[v].coefficient.end());
  }
  adjacency.index.shrink_to_fit();
  coefficients.shrink_to_fit();
  auto blocks =
      std::make_unique<StencilBlocks>(std::move(adjacency), std::move(coefficients), &vertices);
  blocks_ = blocks.get();
  energy->Add(std::move(blocks));
}

void SmoothnessRound::SupportIsKnown() {
  for (size_t k = 0; k < vertex_.size(); ++k) {
    const int v = vertex_[k];
    if (context_.keeps_shape[v] == 0) continue;
    const bool since_level = context_.level_start != nullptr && context_.free[v] != 0;
    blocks_->SetRest(static_cast<int>(k),
                     since_level ? *context_.level_start : context_.mesh->vertices);
  }
  vertex_ = {};
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
