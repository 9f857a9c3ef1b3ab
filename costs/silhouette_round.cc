#include "costs/silhouette_round.h"

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "core/support/parallel.h"
#include "core/support/stopwatch.h"

namespace burin {

void SilhouetteRound::FreezeContours() {
  const Stopwatch watch;
  const EdgeFacets edges(*context_.mesh, context_.neighbors, context_.faces);
  for (size_t v = 0; v < context_.views->size(); ++v) {
    const LevelView& view = (*context_.views)[v];
    if (view.at.takes_part && !view.object.empty()) view_.push_back(static_cast<int>(v));
  }
  const auto count = static_cast<int>(view_.size());
  std::vector<std::optional<SilhouetteView>> made(count);
  ParallelFor(count, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      made[i].emplace((*context_.views)[view_[i]], *context_.mesh, edges, context_.level);
    }
  });
  for (std::optional<SilhouetteView>& view : made) views_.push_back(*std::move(view));
  thin_.assign(context_.normals.size(), 0);
  for (const SilhouetteView& view : views_) {
    for (const SilhouetteView::Rim& rim : view.rims()) {
      if (rim.thin) thin_[rim.a] = thin_[rim.b] = 1;
    }
  }
  const std::vector<char> none(thin_.size(), 0);
  ParallelFor(count, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) views_[i].Compare(context_.finest_level ? none : thin_);
  });
  std::vector<int> block_of_edge(edges.size(), -1);
  for (const SilhouetteView& view : views_) {
    for (const SilhouetteView::Rim& rim : view.rims()) block_of_edge[rim.edge] = 0;
  }
  edges_.start.push_back(0);
  for (int e = 0; e < edges.size(); ++e) {
    if (block_of_edge[e] < 0) continue;
    block_of_edge[e] = static_cast<int>(edges_.start.size()) - 1;
    edges_.index.push_back(edges.a(e));
    edges_.index.push_back(edges.b(e));
    edges_.start.push_back(static_cast<int>(edges_.index.size()));
  }
  for (const SilhouetteView& view : views_) {
    std::vector<int>& blocks = block_of_rim_.emplace_back();
    for (const SilhouetteView::Rim& rim : view.rims()) blocks.push_back(block_of_edge[rim.edge]);
  }
  freeze_seconds_ = watch.Seconds();
}

void SilhouetteRound::AddBlocks(RoundEnergy* energy) {
  vertices_ = &energy->parameters().vertices;
  FreezeContours();
  energy->Add(std::make_unique<SilhouetteBlocks>(edges_, &systems_));
  AddMembrane(energy);
}

void SilhouetteRound::AddMembrane(RoundEnergy* energy) {
  if (options_.membrane == 0) return;
  std::vector<char> outlined(context_.normals.size(), 0);
  for (const int v : edges_.index) outlined[v] = 1;
  Adjacency edges;
  edges.start.push_back(0);
  for (int v = 0; v < static_cast<int>(outlined.size()); ++v) {
    for (const int* n = context_.neighbors.Begin(v); n != context_.neighbors.End(v); ++n) {
      if (*n < v || (outlined[v] == 0 && outlined[*n] == 0)) continue;
      edges.index.push_back(v);
      edges.index.push_back(*n);
      edges.start.push_back(static_cast<int>(edges.index.size()));
    }
  }
  auto membrane = std::make_unique<MembraneBlocks>(
      std::move(edges), options_.membrane, std::ldexp(1.0, context_.level),
      context_.level_start != nullptr ? *context_.level_start : *vertices_, vertices_);
  membrane_ = membrane.get();
  energy->Add(std::move(membrane));
}

void SilhouetteRound::MarkOutlined(std::vector<char>* outlined, std::vector<char>* thin) {
  for (const int v : edges_.index) {
    (*outlined)[v] = 1;
    (*thin)[v] |= thin_[v];
  }
}

void SilhouetteRound::SupportIsKnown() {
  if (membrane_ == nullptr) return;
  for (int k = 0; k < membrane_->size(); ++k) {
    const int* v = membrane_->parameters().Begin(k);
    if (context_.free[v[0]] == 0 && context_.free[v[1]] == 0) membrane_->SetIdle(k);
  }
}

void SilhouetteRound::PrepareForEvaluation(bool /*evaluate_jacobians*/,
                                           bool /*new_evaluation_point*/) {
  if (positions_ == *vertices_) return;
  const Stopwatch watch;
  positions_ = *vertices_;
  const auto count = static_cast<int>(views_.size());
  std::vector<std::vector<RimSums>> sums(count);
  std::vector<double> rest(count);
  ParallelFor(count, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) rest[i] = views_[i].Evaluate(positions_, &sums[i]);
  });
  systems_.assign(edges_.start.size() - 1, EdgeSystem());
  for (int i = 0; i < count; ++i) {
    const SilhouetteView& view = views_[i];
    const Camera& camera = view.camera();
    for (size_t r = 0; r < view.rims().size(); ++r) {
      const SilhouetteView::Rim& rim = view.rims()[r];
      const RimSums& sum = sums[i][r];
      EdgeSystem& system = systems_[block_of_rim_[i][r]];
      const auto direction = [&](int v) -> Eigen::Vector3d {
        const Eigen::Vector3d seen = camera.rotation * positions_[v] + camera.translation;
        return camera.ProjectByPoint(seen).transpose() * rim.outward;
      };
      const Eigen::Vector3d a = direction(rim.a);
      const Eigen::Vector3d b = direction(rim.b);
      const double weight = options_.weight;
      system.energy += weight * sum.energy;
      system.gradient.head<3>() += weight * sum.slope[0] * a;
      system.gradient.tail<3>() += weight * sum.slope[1] * b;
      system.curvature.topLeftCorner<3, 3>() += weight * sum.curvature[0] * a * a.transpose();
      const Eigen::Matrix3d mixed = weight * sum.curvature[1] * a * b.transpose();
      system.curvature.topRightCorner<3, 3>() += mixed;
      system.curvature.bottomLeftCorner<3, 3>() += mixed.transpose();
      system.curvature.bottomRightCorner<3, 3>() += weight * sum.curvature[2] * b * b.transpose();
    }
    if (!systems_.empty()) systems_[0].energy += options_.weight * rest[i];
  }
  ++evaluations_;
  evaluation_seconds_ += watch.Seconds();
}

nlohmann::json SilhouetteRound::Report() const {
  nlohmann::json views = nlohmann::json::array();
  for (size_t i = 0; i < views_.size(); ++i) {
    const SilhouetteView::Fit& fit = views_[i].fit();
    views.push_back({{"view", view_[i]},
                     {"contour_px", fit.contour_px},
                     {"signed_px", fit.signed_px},
                     {"unmatched", fit.unmatched},
                     {"intersection_share", fit.intersection_share}});
  }
  return {{"evaluations", evaluations_},
          {"freeze_seconds", freeze_seconds_},
          {"evaluation_seconds", evaluation_seconds_},
          {"views", views}};
}

}  // namespace burin
