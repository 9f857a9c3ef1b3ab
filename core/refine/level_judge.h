// Decides after every level of a refinement whether it made the mesh worse; the costs know how
// (costs/held_back.h).
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pairs.h"
#include "core/solve/energy_term.h"

namespace burin {

struct LevelVerdict {
  // By vertex: goes back to where the level found it. With LevelFacets::kOther the same for all.
  std::vector<char> undo;
  nlohmann::json report;
};

// Whether a level ends with the facets that it begins with.
enum class LevelFacets { kSame, kOther };

class LevelJudge {
 public:
  virtual ~LevelJudge() = default;
  // Pairs that no round solves with; a level's first and last round have their regions in
  // RoundContext::held_back.
  virtual const std::vector<CameraPair>& HeldBackPairs() const = 0;
  // A level begins with the mesh of `first`, its first round; `facets` as the level before it has them where they are
  // LevelFacets::kOther, which ended with `report` (null: not judged).
  virtual void BeginLevel(const RoundContext& first, const TermRounds& terms, LevelFacets facets,
                          const nlohmann::json& report) = 0;
  // The level has come from that mesh to `after`, with `last`, its last round; when the run was stopped,
  // with the round in work or with one frozen at `after`.
  virtual LevelVerdict EndLevel(const RoundContext& last, const TermRounds& terms,
                                const TriangleMesh& after) = 0;
};

}  // namespace burin
