// Where a refinement is and what it did so far: all that one started later needs to go on from the
// end of a round and come to the same bytes. Also the figures of every round, which are part of it.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/mesh_order.h"
#include "core/refine/crossing_guard.h"
#include "core/refine/local_guard.h"
#include "core/scene/camera.h"
#include "core/scene/undistort.h"
#include "core/solve/solver_strategy.h"

namespace burin {

struct RoundSummary {
  int round = 0;
  SolveSummary solve;
  nlohmann::json energy_initial;  // by term
  nlohmann::json energy_final;
  int64_t windows_initial = 0;  // of which the energies are sums
  int64_t windows_final = 0;
  nlohmann::json terms;     // EnergyTerm::RoundReport by term
  int64_t pair_pixels = 0;  // sum of |Omega_ij|
  int supported_vertices = 0;
  int relaxed_vertices = 0;  // by core/refine/hidden_folds.h, after the solve
  int carried_vertices = 0;  // by core/refine/carry.h, after the solve
  double camera_px =
      0;  // by which cameras moved (core/refine/camera_rounds.h); 0: they did not take part
  LocalGuardReport guard;
  CrossingReport crossings;  // zero with guard.crossings off
  double visibility_seconds = 0;
  double build_seconds = 0;
  double solve_seconds = 0;
};

template <typename T>
struct BeforeAndAfter {
  T before = T();
  T after = T();
};

struct LevelSummary {
  int level = 0;
  int width = 0;  // of the view that names it (core/scene/pyramid.h)
  int height = 0;
  int views = 0;              // that take part
  int views_halved_less = 0;  // of those: less than `level` times
  int vertices = 0;
  int faces = 0;
  bool reached_bound = true;  // of SubdivisionReport
  double subdivide_seconds = 0;
  double image_seconds = 0;
  nlohmann::json held_back;  // what the guard found; null when it did not look
  // The surface was cut anew before its rounds (core/refine/remeshing.h), from so many facets; 0: not.
  int remeshed_faces = 0;
  double remesh_seconds = 0;
  bool left_out = false;    // no vertex is supported on it: nothing was moved
  bool undone = false;      // all of the mesh was set back to the level's start
  int undone_vertices = 0;  // that had moved and were set back
  // Zero with guard.crossings off.
  BeforeAndAfter<int> crossing_facets;  // that cross another one (core/mesh/crossings.h)
  BeforeAndAfter<double>
      back_faces;            // share of the pixels that see the mesh (core/visibility/back_faces.h)
  bool interrupted = false;  // the run was stopped in the last of the rounds below
  std::vector<RoundSummary> rounds;

  // The sum of CrossingReport::taken_back.
  int TakenBack() const;
};

struct RefinementSummary {
  double footprint = 0;  // world units per normalised unit
  // Of the scene's views, caller's world: as the refinement began, and as they are now.
  std::vector<Camera> first_cameras;
  std::vector<Camera> cameras;
  // What the photographs were undistorted by when the intrinsics of `first_cameras` were refined; empty: as the scene has them.
  std::vector<Lens> lenses;
  std::vector<LevelSummary> levels;
  double seconds = 0;
};

// What a level changes of a state, as it was before round 0: what undoing the level brings back. By vertex
// of the mesh that the level works on.
struct LevelStart {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<char> was_supported;
  std::vector<Camera> cameras;
};

// A mesh that was cut anew, as it was before.
struct RemeshStart {
  TriangleMesh mesh;
  std::vector<Eigen::Vector3d> input_position;
  std::vector<char> was_supported;
};

// Which facets the rounds of a level are on. Those of the finest that surface.rounds takes for remeshing are on a surface that is
// cut anew; where the guard undoes that, on one cut finer; where it undoes that too, on the facets as they were.
enum class LevelStage { kGiven, kCutAnew, kCutFiner, kAsTheyWere };

struct RefinementState {
  int level = 0;  // of the pyramid, the one in work
  LevelStage stage = LevelStage::kGiven;
  bool CutsAnew() const { return stage == LevelStage::kCutAnew || stage == LevelStage::kCutFiner; }
  int round = 0;      // on it, the next to run; 0: the level's preparations are to be made
  TriangleMesh mesh;  // normalised world; input vertices first, then new ones as made
  std::vector<Eigen::Vector3d> input_position;  // of mesh.vertices, on the surface of the input
  LevelStart level_start;
  // By vertex of a mesh that was cut anew: the first of the input's vertices in its connected part; else empty, the input's
  // vertices being the first ones.
  std::vector<int> part;
  RemeshStart remesh_start;         // of a remeshed level
  MeshOrder order;                  // that the level works in; empty when round is 0
  std::vector<char> was_supported;  // by vertex of `mesh`: some pair has seen a facet of it
  RefinementSummary summary;
};

// The state as CBOR (RFC 8949): exact, and a tenth of the size of text.
std::vector<uint8_t> StateBytes(const RefinementState& state);

// Throws std::runtime_error, naming what does not fit, for bytes that are not a state.
RefinementState StateFromBytes(const std::vector<uint8_t>& bytes);

}  // namespace burin
