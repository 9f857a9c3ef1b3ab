// A term of the energy. It lives as long as a refinement; Freeze() makes from it what it is in one round:
// a TermRound, which holds the discrete choices of the round and adds its blocks to the round's one
// RoundEnergy. The photometric and smoothness terms are in costs/; a new term derives from EnergyTerm,
// its round from TermRound, and is handed to Refine() beside them.
#pragma once

#include <ceres/evaluation_callback.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pyramid.h"
#include "core/solve/round_energy.h"
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
  std::vector<char> seen;                // some facet of the vertex has a pixel in some Omega_ij
  // Some term has data about where the vertex is (TermRound::MarkSupported); `seen` until they are asked.
  std::vector<char> supported;
  // Takes part in the solve, supported by outlines (TermRound::MarkOutlined) and not by windows, or thin between outlines:
  // it moves in three directions whatever `motion` is, and keeps the shape that it had as the level began.
  std::vector<char> free;
  // Takes part in the solve (core/refine/support.h). The others are carried along afterwards (core/refine/carry.h).
  std::vector<char> moves;
  // Smoothness acts on its displacement and not on its position: it keeps its shape (core/refine/support.h).
  std::vector<char> keeps_shape;
  Motion motion = Motion::kNormal;
  // Of the mesh's vertices as the level began; null: as the round did.
  const std::vector<Eigen::Vector3d>* level_start = nullptr;
  bool finest_level = true;  // of the run
  int level = 0;             // of the pyramid
  bool first_level = false;  // of the run: none before it moved anything

  bool MovesAlongNormal(int v) const {
    return motion == Motion::kNormal && (free.empty() || free[v] == 0);
  }
  // Of a vertex that moves.
  int Unknowns(int v) const { return MovesAlongNormal(v) ? 1 : 3; }
};

// A term in one round. Whatever it refers to (the term, the context, the parameters) outlives it.
class TermRound {
 public:
  TermRound() = default;
  virtual ~TermRound() = default;
  TermRound(const TermRound&) = delete;
  TermRound& operator=(const TermRound&) = delete;

  // Adds the term's blocks of the energy; of any kind of parameter. Called at most once. A term that knows energy,
  // gradient and curvature of small parts of it adds EnergyBlocks, as costs/facet_blocks.h are; one that has residuals, cost
  // functions of Ceres.
  virtual void AddBlocks(RoundEnergy* energy) = 0;

  // Makes what evaluations need and AddBlocks need not wait for; perhaps called at the same time
  // as that. What a round asks for before it was called, it makes itself.
  virtual void FinishFreeze() {}

  // Sets (*supported)[v] where the term has data about the position of vertex v, at the positions of the
  // round's start. Smoothness has none.
  virtual void MarkSupported(const std::vector<Eigen::Vector3d>& vertices,
                             std::vector<char>* supported) {
    (void)vertices;
    (void)supported;
  }

  // Sets (*outlined)[v] where outlines of the object pass the vertex, and (*thin)[v] where it is thin between them.
  virtual void MarkOutlined(std::vector<char>* outlined, std::vector<char>* thin) {
    (void)outlined;
    (void)thin;
  }

  // Called once after AddBlocks, before the first evaluation by a solver: the context's `supported` and
  // `moves` are final.
  virtual void SupportIsKnown() {}

  // Called before the term's blocks are evaluated at new positions, possibly twice at the same; null
  // when not needed.
  virtual ceres::EvaluationCallback* Callback() { return nullptr; }

  // How often the term's data were evaluated; 0 for terms without a callback.
  virtual int64_t EvaluationCount() const { return 0; }

  // Of how many windows the term's energy was the sum at the last evaluation; 0 for terms that have none.
  virtual int64_t WindowCount() const { return 0; }

  // Drops what is remembered of the last evaluated positions, so that the next evaluation is a real
  // one wherever it is. For timing solvers from the same start.
  virtual void Forget() {}

  // Figures for summary.json.
  virtual nlohmann::json Report() const { return nlohmann::json::object(); }
};

class EnergyTerm {
 public:
  virtual ~EnergyTerm() = default;
  virtual std::string Name() const = 0;

  // The images of a level are ready; they stay the same until the next call.
  virtual void BeginLevel(const std::vector<LevelView>& views) { (void)views; }

  // The term in the round that `context` freezes.
  virtual std::unique_ptr<TermRound> Freeze(const RoundContext& context) = 0;
};

// The terms of a refinement in one round, in the order of the terms.
class TermRounds {
 public:
  TermRounds(const std::vector<EnergyTerm*>& terms, const RoundContext& context);

  struct Entry {
    const EnergyTerm* term;
    std::unique_ptr<TermRound> round;
  };
  std::vector<Entry>::const_iterator begin() const { return entries_.begin(); }
  std::vector<Entry>::const_iterator end() const { return entries_.end(); }

  // The round of one of the terms. CHECKs that it is one of them.
  TermRound& Of(const EnergyTerm* term) const;

 private:
  std::vector<Entry> entries_;
};

}  // namespace burin
