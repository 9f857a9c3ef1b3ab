#include "costs/camera_pair_blocks.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "costs/pair_rows.h"

namespace burin {
namespace {

Adjacency CamerasOfPairs(const RoundContext& context, int first_camera) {
  Adjacency cameras;
  cameras.start.push_back(0);
  for (size_t i = 0; i < context.domains->size(); ++i) {
    for (const int second : (*context.domains)[i].seconds) {
      cameras.index.push_back(first_camera + static_cast<int>(i));
      cameras.index.push_back(first_camera + second);
      cameras.start.push_back(static_cast<int>(cameras.index.size()));
    }
  }
  return cameras;
}

// What is not finite is refused: Ceres then tries a shorter step.
bool AllFinite(const double* residuals, int count) {
  double sum = 0;
  for (int r = 0; r < count; ++r) sum += residuals[r];
  return std::isfinite(sum);
}

// Of a vertex and both cameras of a pair.
class VertexInPairCost : public ceres::CostFunction {
 public:
  // `normal`: the direction in which the vertex moves; null where it moves freely.
  VertexInPairCost(std::shared_ptr<const PairRows> rows, int pair, int place,
                   const Eigen::Vector3d* normal)
      : rows_(std::move(rows)), pair_(pair), place_(place), normal_(normal) {
    set_num_residuals(rows_->rows());
    *mutable_parameter_block_sizes() = {3, CameraPose::kSize, CameraPose::kSize};
  }
  bool Evaluate(double const* const* /*parameters*/, double* residuals,
                double** jacobians) const override {
    double* by[3] = {nullptr, nullptr, nullptr};
    if (jacobians != nullptr) std::copy(jacobians, jacobians + 3, by);
    double along = 0;
    double* by_unknowns = by[0] != nullptr && normal_ != nullptr ? &along : by[0];
    rows_->OfVertex(pair_, place_, residuals, by_unknowns, by[1], by[2]);
    if (by[0] != nullptr && normal_ != nullptr) {
      Eigen::Map<Eigen::Vector3d>(by[0], 3) = along * *normal_;
    }
    return AllFinite(residuals, num_residuals());
  }

 private:
  const std::shared_ptr<const PairRows> rows_;
  const int pair_;
  const int place_;
  const Eigen::Vector3d* const normal_;
};

// Of both cameras of a pair.
class PairCost : public ceres::CostFunction {
 public:
  PairCost(std::shared_ptr<const PairRows> rows, int pair) : rows_(std::move(rows)), pair_(pair) {
    set_num_residuals(PairRows::kPairResiduals);
    *mutable_parameter_block_sizes() = {CameraPose::kSize, CameraPose::kSize};
  }
  bool Evaluate(double const* const* /*parameters*/, double* residuals,
                double** jacobians) const override {
    rows_->OfPair(pair_, residuals, jacobians != nullptr ? jacobians[0] : nullptr,
                  jacobians != nullptr ? jacobians[1] : nullptr);
    return AllFinite(residuals, num_residuals());
  }

 private:
  const std::shared_ptr<const PairRows> rows_;
  const int pair_;
};

}  // namespace

CameraPairBlocks::CameraPairBlocks(PhotometricRound* round, int first_camera)
    : EnergyBlocks(CamerasOfPairs(round->context(), first_camera)), round_(round) {}

bool CameraPairBlocks::Evaluate(int k, const TangentDirections* directions, double* energy,
                                double* gradient, double* curvature) const {
  *energy = 0;
  // Derivatives are made at every point (PhotometricRound).
  const CameraSums::Pair& pair = round_->camera_sums().pairs[k];
  if (!pair.gradient.allFinite() || !pair.curvature.allFinite()) return false;
  if (gradient == nullptr) return true;
  const int count = directions[0].columns + directions[1].columns;
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(12, count);
  int column = 0;
  for (int part = 0; part < 2; ++part) {
    const int columns = directions[part].columns;
    if (columns == 0) continue;
    const CameraPose& pose = round_->poses()[part == 0 ? pair.first : pair.second];
    motions.block(6 * part, column, 6, columns) = MotionsOf(pose, directions[part].plus, columns);
    column += columns;
  }
  Eigen::Map<Eigen::VectorXd>(gradient, count) = motions.transpose() * pair.gradient;
  if (curvature == nullptr) return true;
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      curvature, count, count) = motions.transpose() * pair.curvature * motions;
  return true;
}

CostFunctions CameraPairBlocks::MakeCostFunctions() const {
  const std::shared_ptr<const PairRows> rows = round_->MakePairRows();
  const RoundContext& context = round_->context();
  const Adjacency& vertices = rows->vertices();
  CostFunctions made;
  std::vector<int>& parameters = made.parameters.index;
  made.parameters.start.push_back(0);
  made.costs.reserve(vertices.index.size() + size());
  parameters.reserve(3 * vertices.index.size() + 2 * size());
  for (int pair = 0; pair < size(); ++pair) {
    const int* cameras = parameters_.Begin(pair);
    for (int place = vertices.start[pair]; place < vertices.start[pair + 1]; ++place) {
      const int vertex = vertices.index[place];
      const Eigen::Vector3d* normal =
          context.motion == Motion::kNormal ? &context.normals[vertex] : nullptr;
      made.costs.push_back(std::make_unique<VertexInPairCost>(rows, pair, place, normal));
      parameters.insert(parameters.end(), {vertex, cameras[0], cameras[1]});
      made.parameters.start.push_back(static_cast<int>(parameters.size()));
    }
    made.costs.push_back(std::make_unique<PairCost>(rows, pair));
    parameters.insert(parameters.end(), {cameras[0], cameras[1]});
    made.parameters.start.push_back(static_cast<int>(parameters.size()));
  }
  return made;
}

}  // namespace burin
