// What is done about the verdict on a scene (core/evidence/verdict.h) before it is refined: views that do
// not fit are left out, and what cannot be right is not refined.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/run/pipeline.h"
#include "core/cameras/track_step.h"
#include "core/evidence/verdict.h"
#include "core/mesh/mesh.h"
#include "core/scene/scene.h"
#include "selection/pair_selection.h"

namespace burin {

struct JudgedScene {
  // Without the views that are left out, where there are some; pixels are shared with the one given.
  std::optional<Scene> without;
  PairSelection selection;  // of the scene that is used
  // Of the scene that is used; none with cameras.refine none. It keeps no cameras where `stop`.
  std::optional<TrackStep> by_tracks;
  // On the scene given, with its indices of views; through refined cameras where they are kept.
  SceneVerdict verdict;
  std::vector<std::string> left_out;  // names
  std::vector<std::string> lines;     // to be said: DoubtsAbout, then what the verdict is
  bool judged = false;                // verdict.action is not off
  bool stop = false;                  // it cannot be right, and verdict.action is stop
  double seconds = 0;                 // of the verdict alone

  const Scene& Used(const Scene& given) const { return without.has_value() ? *without : given; }
};

// Selects pairs, refines the cameras by tracks where that is asked for, judges scene and mesh, and leaves out views. Throws as SelectPairs does.
JudgedScene JudgeAndSelect(const Scene& scene, const TriangleMesh& mesh,
                           const PipelineOptions& options);

// SelectPairs and JudgeScene. What is wrong with the mesh, or that no pair sees it, comes with the rotation by
// which it would fit (apps/run/turned_axes.h).
SceneVerdict SelectAndJudge(const Scene& scene, const TriangleMesh& mesh,
                            const PairsOptions& options, PairSelection* selection, double* seconds);

// JudgeAndSelect without judging, the views of these names left out.
JudgedScene SelectWithout(const Scene& scene, const TriangleMesh& mesh,
                          const PipelineOptions& options, std::vector<std::string> left_out);

}  // namespace burin
