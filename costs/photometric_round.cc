#include "costs/photometric_round.h"

#include <glog/logging.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "core/solve/symmetric_matrix.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"
#include "costs/camera_pair_blocks.h"
#include "costs/facet_blocks.h"
#include "costs/pair_rows.h"

namespace burin {
namespace {

constexpr int kFacetGrain = 512;

}  // namespace

PhotometricRound::PhotometricRound(const PhotometricOptions& options, bool hold_back_squares,
                                   ViewEvaluation* view_evaluation, const RoundContext& context)
    : options_(options),
      hold_back_squares_(hold_back_squares),
      view_evaluation_(view_evaluation),
      context_(context) {}

void PhotometricRound::FinishFreeze() {
  if (frozen_) return;
  windows_ = FreezeWindows(context_, options_, hold_back_squares_);
  frozen_ = true;
}

void PhotometricRound::AddBlocks(RoundEnergy* energy) {
  parameters_ = &energy->parameters();
  auto blocks = std::make_unique<FacetBlocks>(this);
  blocks_ = blocks.get();
  energy->Add(std::move(blocks));
  if (parameters_->cameras.empty()) return;
  CHECK_EQ(parameters_->cameras.size(), context_.views->size());
  energy->Add(std::make_unique<CameraPairBlocks>(this, energy->FirstCamera()));
}

void PhotometricRound::MarkSupported(const std::vector<Eigen::Vector3d>& vertices,
                                     std::vector<char>* supported) {
  const std::vector<CameraPose> none;
  Evaluate(vertices, parameters_ != nullptr ? parameters_->cameras : none, /*derivatives=*/true);
  for (size_t f = 0; f < context_.mesh->faces.size(); ++f) {
    // Every tap has a share of its window's cost (costs/patch_cost.h), 1 - z > 0.
    if (output_.sums.Cost(3 * f) + output_.sums.Cost(3 * f + 1) + output_.sums.Cost(3 * f + 2) <=
        0) {
      continue;
    }
    for (const int v : context_.mesh->faces[f]) (*supported)[v] = 1;
  }
}

void PhotometricRound::PrepareForEvaluation(bool /*evaluate_jacobians*/,
                                            bool /*new_evaluation_point*/) {
  Evaluate(parameters_->vertices, parameters_->cameras, /*derivatives=*/true);
  if (const std::shared_ptr<PairRows> rows = pair_rows_.lock(); rows != nullptr) {
    if (rows_factored_at_ == evaluations_) return;
    rows->Factor(camera_sums_, energy_, poses_);
    rows_factored_at_ = evaluations_;
    return;
  }
  blocks_->FactorForCeres();
}

void PhotometricRound::SetPoint(const std::vector<Eigen::Vector3d>& vertices,
                                const std::vector<CameraPose>& poses) {
  CHECK(poses.empty() || poses.size() == context_.views->size());
  positions_ = vertices;
  poses_ = poses;
  cameras_.clear();
  for (const LevelView& view : *context_.views) cameras_.push_back(view.camera);
  for (size_t i = 0; i < poses.size(); ++i) SetPose(poses[i], &cameras_[i]);
}

void PhotometricRound::EvaluateSample(const PairSample& sample, bool squares_only,
                                      bool derivatives) {
  output_.windows = 0;
  const size_t face_count = context_.mesh->faces.size();
  output_.sums.Resize(3 * face_count, options_.double_precision);
  normals_.resize(face_count);
  ParallelFor(static_cast<int>(face_count), kFacetGrain, [&](int begin, int end) {
    output_.sums.Clear(3 * static_cast<size_t>(begin), 3 * static_cast<size_t>(end));
    for (int f = begin; f < end; ++f) {
      const Eigen::Vector3i& face = context_.mesh->faces[f];
      normals_[f] = (positions_[face[1]] - positions_[face[0]])
                        .cross(positions_[face[2]] - positions_[face[0]]);
    }
  });
  ViewEvaluation::Input input;
  input.context = &context_;
  input.windows = &windows_;
  input.sample = &sample;
  input.squares_only = squares_only;
  for (size_t i = 0; i < sample.partners.size(); ++i) {
    view_evaluation_->Add(input, static_cast<int>(i), {&positions_, &cameras_}, derivatives,
                          &output_);
  }
}

std::shared_ptr<PairRows> PhotometricRound::MakePairRows() {
  FinishFreeze();
  if (camera_sums_.first_pair.empty()) camera_sums_.MakePattern(context_, windows_.used);
  auto rows = std::make_shared<PairRows>(context_, windows_.used, camera_sums_);
  pair_rows_ = rows;
  Forget();  // the next evaluation fills them
  return rows;
}

double PhotometricRound::Evaluate(const std::vector<Eigen::Vector3d>& vertices,
                                  const std::vector<CameraPose>& poses, bool derivatives) {
  const bool same = have_energy_ && positions_ == vertices && poses_ == poses;
  if (same && (have_derivatives_ || !derivatives)) return energy_;
  FinishFreeze();
  const Stopwatch watch;
  SetPoint(vertices, poses);
  const std::shared_ptr<PairRows> rows = pair_rows_.lock();
  if (derivatives && !poses.empty()) {
    if (camera_sums_.first_pair.empty()) camera_sums_.MakePattern(context_, windows_.used);
    camera_sums_.Clear(options_.double_precision);
    output_.cameras = &camera_sums_;
    if (rows != nullptr) rows->Clear();
    output_.pair_rows = rows.get();
  }
  EvaluateSample(windows_.used, /*squares_only=*/false, derivatives);
  output_.cameras = nullptr;
  output_.pair_rows = nullptr;
  energy_ = ChunkedSum(static_cast<int>(output_.sums.size()), [&](int begin, int end) {
    double part = 0;
    for (int k = begin; k < end; ++k) part += output_.sums.Cost(k);
    return part;
  });
  have_energy_ = true;
  have_derivatives_ = derivatives;
  ++evaluations_;
  seconds_ += watch.Seconds();
  return energy_;
}

void PhotometricRound::Score(const std::vector<Eigen::Vector3d>& vertices, Windows windows,
                             bool derivatives, const std::vector<CameraPose>& poses) {
  FinishFreeze();
  const int64_t windows_before = output_.windows;
  SetPoint(vertices, poses);
  if (windows == Windows::kUsed) {
    EvaluateSample(windows_.used, /*squares_only=*/false, derivatives);
  } else {
    EvaluateSample(windows_.held_back, hold_back_squares_, derivatives);
  }
  output_.windows = windows_before;
  Forget();
}

std::vector<FacetScore> PhotometricRound::FacetScores(const std::vector<Eigen::Vector3d>& vertices,
                                                      Windows windows, bool derivatives,
                                                      const std::vector<CameraPose>& poses) {
  std::vector<FacetScore> scores(context_.mesh->faces.size());
  output_.scores = &scores;
  Score(vertices, windows, derivatives, poses);
  output_.scores = nullptr;
  return scores;
}

std::vector<CellScore> PhotometricRound::CellScores(const std::vector<Eigen::Vector3d>& vertices,
                                                    Windows windows) {
  std::vector<CellScore> scores;
  output_.cell_scores = &scores;
  Score(vertices, windows, /*derivatives=*/false, {});
  output_.cell_scores = nullptr;
  return scores;
}

void PhotometricRound::Forget() {
  have_energy_ = false;
  have_derivatives_ = false;
}

nlohmann::json PhotometricRound::Report() const {
  int64_t masked = 0;
  for (const WindowMasks& masks : windows_.masks) masked += static_cast<int64_t>(masks.size());
  const auto all = static_cast<double>(std::max<int64_t>(1, windows_.reference_pixels));
  return {{"evaluations", evaluations_},
          {"valid_windows", output_.windows},
          {"masked_window_share", static_cast<double>(masked) / all},
          {"mask_seconds", windows_.mask_seconds},
          {"evaluation_seconds", seconds_}};
}

const WindowMasks& PhotometricRound::masks(int view) {
  FinishFreeze();
  return windows_.masks[view];
}

}  // namespace burin
