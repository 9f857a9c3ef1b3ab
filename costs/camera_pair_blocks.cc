#include "costs/camera_pair_blocks.h"

#include <Eigen/Core>

#include "core/support/error.h"

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

}  // namespace

CameraPairBlocks::CameraPairBlocks(const PhotometricRound* round, int first_camera)
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
  throw InputError(
      "solver.type: the minimisers of Ceres take no cameras as unknowns; take lm_pcg, "
      "lbfgs_sobolev or lbfgs_h");
}

}  // namespace burin
