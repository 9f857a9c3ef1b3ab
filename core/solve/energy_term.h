// What a term of the energy is to the coarse-to-fine loop: something that freezes its discrete
// choices at the start of a round and then adds residual blocks to the round's one ceres::Problem.
// The photometric and smoothness terms are in costs/; a new term derives from EnergyTerm and is
// handed to Refine() beside them.
#pragma once

#include <ceres/evaluation_callback.h>
#include <ceres/problem.h>

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pyramid.h"
#include "core/support/choices.h"
#include "core/visibility/visibility.h"

namespace burin {

// How vertices may move. `kNormal`: along their normal at the round's start, one degree of freedom;
// `kFree`: three.
enum class Motion { kNormal, kFree };
inline Choices<Motion> ChoicesOf(Motion) {
  return {{Motion::kNormal, "normal"}, {Motion::kFree, "free"}};
}

// Everything that is frozen during a solve.
struct RoundContext {
  const std::vector<LevelView>* views = nullptr;
  const std::vector<ViewDomain>* domains = nullptr;  // one per view
  // Per view, pairs that are not refined with but judge the level (core/refine/level_judge.h), in the pixels
  // of `domains`; null in rounds that nothing is judged in.
  const std::vector<ViewPartners>* held_back = nullptr;
  const TriangleMesh* mesh = nullptr;  // positions at the start of the round
  Adjacency neighbors;
  Adjacency faces;
  std::vector<char> boundary;
  std::vector<Eigen::Vector3d> normals;  // unit, or zero where there is none
  std::vector<char> supported;           // some facet of the vertex has a pixel in some Omega_ij
  std::vector<char> was_supported;       // now or in an earlier round
  Motion motion = Motion::kNormal;
  bool first_level = false;  // of the run: the coarsest
};

class EnergyTerm {
 public:
  virtual ~EnergyTerm() = default;
  virtual std::string Name() const = 0;

  // The images of a level are ready; they stay the same until the next call.
  virtual void BeginLevel(const std::vector<LevelView>& views) { (void)views; }

  // Freezes the term for a round. `context` outlives the round.
  virtual void BeginRound(const RoundContext& context) = 0;

  // What of a round's preparations the residual blocks need not wait for. Called after BeginRound,
  // perhaps at the same time as AddResiduals.
  virtual void Freeze() {}

  // Adds residual blocks on vertex positions; the parameter block of vertex v is
  // (*vertices)[v].data(), of size 3. Called once per round, after BeginRound. The cost functions
  // are of this call alone, made by `new`; the problem or its owner deletes them.
  virtual void AddResiduals(ceres::Problem* problem, std::vector<Eigen::Vector3d>* vertices) = 0;

  // Called before the term's residuals are evaluated at new positions; null when not needed.
  virtual ceres::EvaluationCallback* Callback() { return nullptr; }

  // How often the term's data were evaluated since BeginRound; 0 for terms without a callback.
  virtual int64_t EvaluationCount() const { return 0; }

  // Drops what is remembered of the last evaluated positions, so that the next evaluation is a real
  // one wherever it is. For timing solvers from the same start.
  virtual void Forget() {}

  // Figures for summary.json: of the round just solved.
  virtual nlohmann::json RoundReport() const { return nlohmann::json::object(); }
};

}  // namespace burin
