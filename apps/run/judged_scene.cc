#include "apps/run/judged_scene.h"

#include <algorithm>
#include <utility>

#include "apps/run/turned_axes.h"
#include "core/cameras/refined_scene.h"
#include "core/scene/doubts.h"
#include "core/support/error.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"

namespace burin {
namespace {

// New index of every view, -1 for one that is left out.
std::vector<int> IndexWithout(const Scene& scene, const std::vector<std::string>& names) {
  std::vector<int> index;
  int next = 0;
  for (const View& view : scene.views) {
    const bool out = std::find(names.begin(), names.end(), view.name) != names.end();
    index.push_back(out ? -1 : next++);
  }
  return index;
}

std::vector<CameraPair> Renamed(const std::vector<CameraPair>& pairs,
                                const std::vector<int>& index) {
  std::vector<CameraPair> renamed;
  for (const CameraPair& pair : pairs) {
    if (index[pair.reference] < 0 || index[pair.second] < 0) continue;
    renamed.push_back({index[pair.reference], index[pair.second]});
  }
  return renamed;
}

// A file names the pairs of all views: those of the others are used as they are.
PairSelection SelectionWithout(const PairSelection& selection, const std::vector<int>& index) {
  PairSelection without = selection;
  without.pairs = Renamed(selection.pairs, index);
  without.initial_pairs = without.pairs;
  without.held_back = Renamed(selection.held_back, index);
  without.matching = Renamed(selection.matching, index);
  if (without.pairs.empty()) {
    throw InputError("no camera pair: every pair of pairs.file has a view that does not fit");
  }
  return without;
}

// By which rotation the mesh would fit, as the end of a sentence.
std::string TurnedHint(const Scene& scene, const TriangleMesh& mesh, const PairsOptions& options) {
  const std::string turned = TurnedAxes(scene, mesh, options);
  return turned.empty() ? "" : "; " + turned;
}

PairSelection SelectOrExplain(const Scene& scene, const TriangleMesh& mesh,
                              const PairsOptions& options) {
  try {
    return SelectPairs(scene, mesh, options);
  } catch (const InputError& error) {
    std::string reason = error.what() + TurnedHint(scene, mesh, options);
    for (const std::string& doubt : DoubtsAbout(scene)) reason += "; " + doubt;
    throw InputError(reason);
  }
}

SceneVerdict Judge(const Scene& scene, const TriangleMesh& mesh, const PairsOptions& options,
                   const std::vector<CameraPair>& pairs, double* seconds) {
  const Stopwatch watch;
  SceneVerdict verdict = JudgeScene(scene, mesh, pairs);
  *seconds = watch.Seconds();
  if (verdict.verdict == Verdict::kWrong) verdict.reason += TurnedHint(scene, mesh, options);
  return verdict;
}

}  // namespace

SceneVerdict SelectAndJudge(const Scene& scene, const TriangleMesh& mesh,
                            const PairsOptions& options, PairSelection* selection,
                            double* seconds) {
  *selection = SelectOrExplain(scene, mesh, options);
  return Judge(scene, mesh, options, selection->pairs, seconds);
}

JudgedScene SelectWithout(const Scene& scene, const TriangleMesh& mesh,
                          const PipelineOptions& options, std::vector<std::string> left_out) {
  JudgedScene judged;
  judged.left_out = std::move(left_out);
  if (judged.left_out.empty()) {
    judged.selection = SelectPairs(scene, mesh, options.pairs);
    return judged;
  }
  const std::vector<int> index = IndexWithout(scene, judged.left_out);
  judged.without = WithoutViews(scene, index);
  judged.selection = options.pairs.method == PairsMethod::kFile
                         ? SelectionWithout(SelectPairs(scene, mesh, options.pairs), index)
                         : SelectPairs(*judged.without, mesh, options.pairs);
  return judged;
}

JudgedScene JudgeAndSelect(const Scene& scene, const TriangleMesh& mesh,
                           const PipelineOptions& options) {
  const ThreadScope threads(options.threads);
  const VerdictOptions& wanted = options.verdict;
  JudgedScene judged;
  judged.lines = DoubtsAbout(scene);
  const bool judge = wanted.action != VerdictAction::kOff;
  judged.selection =
      judge ? SelectOrExplain(scene, mesh, options.pairs) : SelectPairs(scene, mesh, options.pairs);
  const auto refine_cameras = [&](const Scene& of) {
    if (!options.refinement.cameras.ByTracks()) return;
    const CameraUnknowns refine = options.refinement.cameras.refine;
    judged.by_tracks = RefineByTracks(of, mesh, judged.selection.ForTracks(), RuleOf(refine),
                                      IntrinsicsOf(refine));
  };
  refine_cameras(scene);
  if (!judge) return judged;
  judged.judged = true;
  const bool moved = judged.by_tracks.has_value() && judged.by_tracks->Kept();
  judged.verdict =
      Judge(moved ? WithRefinedCameras(judged.by_tracks->SeenOr(scene), judged.by_tracks->cameras)
                  : scene,
            mesh, options.pairs, judged.selection.pairs, &judged.seconds);
  if (judged.verdict.verdict == Verdict::kWrong) {
    judged.stop = wanted.action == VerdictAction::kStop;
    if (judged.stop && moved) judged.by_tracks->HandBack(scene, "the input is handed back");
    if (!judged.stop) judged.lines.push_back("this cannot be right: " + judged.verdict.reason);
    return judged;
  }
  if (judged.verdict.verdict == Verdict::kCannotTell) {
    judged.lines.push_back("cannot tell whether cameras, photographs and mesh fit: " +
                           judged.verdict.reason);
  }
  const bool leave_out = wanted.misfit == ViewMisfit::kLeaveOut;
  for (const int view : judged.verdict.misfits) {
    const std::string& name = scene.views[view].name;
    if (leave_out) judged.left_out.push_back(name);
    if (wanted.misfit != ViewMisfit::kKeep) {
      judged.lines.push_back(name + " does not fit the other views" +
                             (leave_out ? ", left out (scene.misfit)" : ""));
    }
  }
  if (judged.verdict.misfits.empty() && judged.verdict.verdict == Verdict::kDoubtful) {
    judged.lines.push_back("doubtful: " + judged.verdict.reason);
  }
  if (judged.left_out.empty()) return judged;
  JudgedScene without = SelectWithout(scene, mesh, options, judged.left_out);
  judged.without = std::move(without.without);
  judged.selection = std::move(without.selection);
  refine_cameras(*judged.without);
  return judged;
}

}  // namespace burin
