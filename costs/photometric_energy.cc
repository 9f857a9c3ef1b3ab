#include "costs/photometric_energy.h"

#include <glog/logging.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/solve/symmetric_matrix.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"
#include "costs/patch_cost.h"

namespace burin {
namespace {

constexpr int kFacetGrain = 512;
constexpr int kPatchGrain = 256;

}  // namespace

PhotometricEnergy::PhotometricEnergy(const PhotometricOptions& options)
    : options_(options), view_evaluation_(ViewEvaluation::Make(options)) {}

PhotometricEnergy::~PhotometricEnergy() = default;

void PhotometricEnergy::BeginLevel(const std::vector<LevelView>& views) {
  views_ = &views;
  view_evaluation_->BeginLevel(views);
}

void PhotometricEnergy::BeginRound(const RoundContext& context) {
  CHECK(context.views == views_);
  context_ = &context;
  round_ = PhotometricRound();
  frozen_ = false;
  Forget();
  patches_.clear();
  evaluations_ = 0;
  seconds_ = 0;
  parameters_ = nullptr;
}

void PhotometricEnergy::Freeze() {
  if (frozen_) return;
  round_ = FreezePhotometricRound(*context_, options_, hold_squares_);
  frozen_ = true;
}

void PhotometricEnergy::AddResiduals(ceres::Problem* problem,
                                     std::vector<Eigen::Vector3d>* vertices) {
  parameters_ = vertices;
  std::vector<int> supported;
  for (size_t v = 0; v < vertices->size(); ++v) {
    if (context_->supported[v] != 0) supported.push_back(static_cast<int>(v));
  }
  patches_.resize(supported.size());
  ParallelFor(static_cast<int>(supported.size()), kPatchGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) patches_[k] = new PatchCost(this, supported[k]);
  });
  std::vector<double*> blocks;
  for (PatchCost* cost : patches_) {
    blocks.clear();
    for (int block : cost->blocks()) blocks.push_back((*vertices)[block].data());
    problem->AddResidualBlock(cost, nullptr, blocks);
  }
}

void PhotometricEnergy::PrepareForEvaluation(bool /*evaluate_jacobians*/,
                                             bool /*new_evaluation_point*/) {
  const int64_t before = evaluations_;
  Evaluate(*parameters_, /*derivatives=*/true);
  if (evaluations_ == before && linearized_) return;
  ParallelFor(static_cast<int>(patches_.size()), kPatchGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) patches_[k]->Linearize();
  });
  linearized_ = true;
}

void PhotometricEnergy::EvaluateSample(const PairSample& sample, bool squares_only,
                                       bool derivatives) {
  output_.windows = 0;
  const size_t face_count = context_->mesh->faces.size();
  output_.sums.resize(3 * face_count);
  normals_.resize(face_count);
  ParallelFor(static_cast<int>(face_count), kFacetGrain, [&](int begin, int end) {
    std::fill(output_.sums.begin() + 3L * begin, output_.sums.begin() + 3L * end, CornerSums());
    for (int f = begin; f < end; ++f) {
      const Eigen::Vector3i& face = context_->mesh->faces[f];
      normals_[f] = (positions_[face[1]] - positions_[face[0]])
                        .cross(positions_[face[2]] - positions_[face[0]]);
    }
  });
  ViewEvaluation::Input input;
  input.context = context_;
  input.round = &round_;
  input.sample = &sample;
  input.squares_only = squares_only;
  for (size_t i = 0; i < sample.partners.size(); ++i) {
    view_evaluation_->Add(input, static_cast<int>(i), positions_, derivatives, &output_);
  }
}

double PhotometricEnergy::Evaluate(const std::vector<Eigen::Vector3d>& vertices, bool derivatives) {
  CHECK(context_ != nullptr);
  const bool same = have_energy_ && positions_ == vertices;
  if (same && (have_derivatives_ || !derivatives)) return energy_;
  Freeze();
  const Stopwatch watch;
  positions_ = vertices;
  EvaluateSample(round_.used, /*squares_only=*/false, derivatives);
  energy_ = ChunkedSum(static_cast<int>(output_.sums.size()), [&](int begin, int end) {
    double part = 0;
    for (int k = begin; k < end; ++k) part += output_.sums[k].cost;
    return part;
  });
  have_energy_ = true;
  have_derivatives_ = derivatives;
  linearized_ = false;
  ++evaluations_;
  seconds_ += watch.Seconds();
  return energy_;
}

void PhotometricEnergy::HoldBackSquares(bool hold) { hold_squares_ = hold; }

std::vector<FacetScore> PhotometricEnergy::FacetScores(const std::vector<Eigen::Vector3d>& vertices,
                                                       Windows windows, bool derivatives) {
  Freeze();
  std::vector<FacetScore> scores(context_->mesh->faces.size());
  const int64_t windows_before = output_.windows;
  positions_ = vertices;
  output_.scores = &scores;
  if (windows == Windows::kUsed) {
    EvaluateSample(round_.used, /*squares_only=*/false, derivatives);
  } else {
    EvaluateSample(round_.held_back, hold_squares_, derivatives);
  }
  output_.scores = nullptr;
  output_.windows = windows_before;
  Forget();
  return scores;
}

int64_t PhotometricEnergy::EvaluationCount() const { return evaluations_; }

void PhotometricEnergy::Forget() {
  have_energy_ = false;
  have_derivatives_ = false;
  linearized_ = false;
}

nlohmann::json PhotometricEnergy::RoundReport() const {
  int64_t masked = 0;
  for (const WindowMasks& masks : round_.masks) masked += static_cast<int64_t>(masks.size());
  const auto all = static_cast<double>(std::max<int64_t>(1, round_.reference_pixels));
  return {{"evaluations", evaluations_},
          {"valid_windows", output_.windows},
          {"masked_window_share", static_cast<double>(masked) / all},
          {"mask_seconds", round_.mask_seconds},
          {"evaluation_seconds", seconds_}};
}

const std::vector<CornerSums>& PhotometricEnergy::corner_sums() const { return output_.sums; }
const std::vector<Eigen::Vector3d>& PhotometricEnergy::facet_normals() const { return normals_; }
const RoundContext& PhotometricEnergy::context() const { return *context_; }
int64_t PhotometricEnergy::valid_windows() const { return output_.windows; }
const WindowMasks& PhotometricEnergy::masks(int view) {
  Freeze();
  return round_.masks[view];
}

}  // namespace burin
