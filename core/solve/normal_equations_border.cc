// What NormalEquations does for cameras.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/solve/normal_equations.h"

namespace burin {

void NormalEquations::MakeBorder() {
  std::vector<CameraBorder::Column> columns;
  const int first_unknown = blocks_[row_blocks_].first_unknown;
  for (size_t k = row_blocks_; k < blocks_.size(); ++k) {
    const int camera = blocks_[k].parameter - energy_.FirstCamera();
    columns.push_back({camera, &energy_.parameters().cameras[camera],
                       blocks_[k].first_unknown - first_unknown, blocks_[k].tangent_size});
  }
  std::vector<int> first_row(energy_.FirstCamera(), -1);
  for (int v = 0; v < energy_.FirstCamera(); ++v) {
    if (RowBlock(v) >= 0) first_row[v] = blocks_[RowBlock(v)].first_unknown;
  }
  border_.Begin(columns, energy_.CameraCount(), std::move(first_row));
}

// On one thread: there is a block a pair.
void NormalEquations::AddToBorder(const Batch& batch, Wanted wanted, Eigen::VectorXd* gradient) {
  const int first_unknown = blocks_[row_blocks_].first_unknown;
  std::vector<int> unknowns;  // of the border, of each unknown of the block
  for (int of = batch.first; of < batch.first + batch.end - batch.begin; ++of) {
    unknowns.clear();
    for (const int* p = ParametersBegin(batch, of); p != ParametersEnd(batch, of); ++p) {
      const int moving = moving_of_[*p];
      if (moving < row_blocks_) continue;
      for (int u = 0; u < blocks_[moving].tangent_size; ++u) {
        unknowns.push_back(blocks_[moving].first_unknown - first_unknown + u);
      }
    }
    const auto size = static_cast<int>(unknowns.size());
    const double* local = &buffer_[places_[of].first_value];
    for (int i = 0; i < size; ++i) (*gradient)[first_unknown + unknowns[i]] += local[i];
    if (wanted != Wanted::kMatrix) continue;
    local += size;
    for (int i = 0; i < size; ++i) {
      for (int j = i; j < size; ++j) {
        border_.curvature()(unknowns[i], unknowns[j]) += local[i * size + j];
        if (j > i) border_.curvature()(unknowns[j], unknowns[i]) += local[i * size + j];
      }
    }
  }
}

void NormalEquations::FinishBorder() {
  const CameraCoupling* coupling = nullptr;
  for (const RoundEnergy::Part& part : energy_.parts()) {
    if (part.blocks->Coupling() != nullptr) coupling = part.blocks->Coupling();
  }
  std::vector<const double*> plus;
  for (size_t k = row_blocks_; k < blocks_.size(); ++k) {
    plus.push_back(&plus_jacobians_[first_plus_[k]]);
  }
  border_.SetCoupling(coupling, plus);
}

void NormalEquations::Multiply(const Eigen::VectorXd& x, const Eigen::VectorXd& damping,
                               Eigen::VectorXd* y) const {
  if (border_.empty()) {
    matrix_.Multiply(x, damping, y);
    return;
  }
  Eigen::VectorXd of_rows;
  matrix_.Multiply(x.head(matrix_.size), Eigen::VectorXd(), &of_rows);
  y->resize(x.size());
  y->head(matrix_.size) = of_rows;
  border_.Multiply(x, y);
  if (damping.size() > 0) *y += damping.cwiseProduct(x);
}

SymmetricMatrix NormalEquations::WholeMatrix(const std::vector<Eigen::MatrixXd>& of_cameras) const {
  if (border_.empty()) return matrix_;
  Eigen::MatrixXd change = Eigen::MatrixXd::Zero(border_.unknowns(), border_.unknowns());
  for (size_t k = 0; k < of_cameras.size(); ++k) {
    const int first = border_.columns()[k].first;
    change.block(first, first, of_cameras[k].rows(), of_cameras[k].cols()) = of_cameras[k];
  }
  struct Entry {
    int column;
    double value;
  };
  std::vector<std::vector<Entry>> beside(matrix_.size);  // what the rows of A have of C
  std::vector<std::vector<Entry>> below(border_.unknowns());
  border_.ForCoupling([&](int row, int unknown, const Eigen::MatrixXd& block) {
    const Eigen::MatrixXd own = block * change.block(unknown, unknown, block.cols(), block.cols());
    for (int i = 0; i < own.rows(); ++i) {
      for (int j = 0; j < own.cols(); ++j) {
        beside[row + i].push_back({matrix_.size + unknown + j, own(i, j)});
        below[unknown + j].push_back({row + i, own(i, j)});
      }
    }
  });
  const Eigen::MatrixXd corner = change.transpose() * border_.curvature() * change;
  SymmetricMatrix whole;
  whole.size = unknowns_;
  whole.start.push_back(0);
  const auto add = [&](int column, double value) {
    whole.column.push_back(column);
    whole.value.push_back(value);
  };
  for (int i = 0; i < unknowns_; ++i) {
    const int u = i - matrix_.size;  // of the border
    if (u < 0) {
      whole.diagonal.push_back(whole.start.back() + matrix_.diagonal[i] - matrix_.start[i]);
      for (int64_t k = matrix_.start[i]; k < matrix_.start[i + 1]; ++k) {
        add(matrix_.column[k], matrix_.value[k]);
      }
      for (const Entry& entry : beside[i]) add(entry.column, entry.value);
    } else {
      for (const Entry& entry : below[u]) add(entry.column, entry.value);
      whole.diagonal.push_back(static_cast<int64_t>(whole.column.size()) + u);
      for (int j = 0; j < border_.unknowns(); ++j) add(matrix_.size + j, corner(u, j));
    }
    whole.start.push_back(static_cast<int64_t>(whole.column.size()));
  }
  return whole;
}

Eigen::VectorXd NormalEquations::Diagonal() const {
  if (border_.empty()) return matrix_.Diagonal();
  Eigen::VectorXd diagonal(unknowns_);
  diagonal << matrix_.Diagonal(), border_.curvature().diagonal();
  return diagonal;
}

}  // namespace burin
