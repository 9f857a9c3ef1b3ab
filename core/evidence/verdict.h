// Whether cameras, photographs and mesh fit each other, before anything is refined.
//
// Right cameras put a window's best match on the epipolar line, whatever the mesh is like; a mesh that fits
// makes photographs agree at the place predicted. From the matches of core/evidence/window_matches.h:
//
//   E     share of windows whose best match is within 1 px of the epipolar line, chance removed:
//         (share - 3/17) / (1 - 3/17). 0 for photographs that have nothing to do with the cameras.
//   A     probability that ZNCC at the place predicted is above that at a place 15 to 60 px away (the
//         area under the ROC curve). 0.5 for a mesh that has nothing to do with the photographs.
//   px    1.4826 median |across| / sqrt 2 over clear matches, in pixels of the photographs: the noise of
//         a camera, were both alike.
//
// A view does not fit when its E, the mean over its pairs, is below 0.4 of the median over the views by two
// standard errors. The worst is taken out and the others are judged again without it, until none is; one that
// has bad pairs with others of them only is kept. When those that are left have an E below 0.4, nothing stands
// out and none is named. The figures of the scene are those of the views that fit.
//
//   cannot tell   fewer than 30 windows
//   wrong         E < 0.33 and A < 0.75: cameras or photographs; or A < 0.6: the mesh
//   doubtful      px >= 0.5, or views that do not fit
//   good          else
//
// Sparse points add to it, where structure from motion's measurements of them are known
// (core/scene/track_errors.h). A view whose median error is above 16 px or 1 % of its longer side does not
// fit either, unless its own E is 0.33 or more, or the rest would have an E below 0.4. When that is so for
// most views, none is named, and cameras and points are not of one reconstruction: wrong where E and A
// cannot tell, doubtful where they are good.
//
// Where more than half of the views have a photograph that another view has too, it is wrong in any case.
// What is wrong is looked at again in images of at most 256 px, where the search reaches further. A < 0.6
// but not there: doubtful, for the mesh is far from the surface, but not too far. E < 0.33 but not there,
// and px below 0.35 pixels of theirs: it is the mesh.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/evidence/window_matches.h"
#include "core/scene/track_errors.h"
#include "core/support/choices.h"

namespace burin {

enum class Verdict { kGood, kDoubtful, kWrong, kCannotTell };
inline Choices<Verdict> ChoicesOf(Verdict) {
  return {{Verdict::kGood, "good"},
          {Verdict::kDoubtful, "doubtful"},
          {Verdict::kWrong, "wrong"},
          {Verdict::kCannotTell, "cannot tell"}};
}

// NaN where there are too few windows for a figure.
struct Evidence {
  int windows = 0;
  double on_line = std::numeric_limits<double>::quiet_NaN();   // E
  double at_place = std::numeric_limits<double>::quiet_NaN();  // A
  double noise_px = std::numeric_limits<double>::quiet_NaN();  // px
};

struct ViewEvidence {
  Evidence evidence;    // of windows in pairs with this view, in either role
  bool misfit = false;  // the view does not fit the others
};

struct SceneVerdict {
  Verdict verdict = Verdict::kCannotTell;
  std::string reason;  // one line: what is wrong, or why nothing can be told; empty for good
  Evidence evidence;   // of pairs without a misfit
  int pairs = 0;       // that have windows
  std::vector<ViewEvidence> views;
  std::vector<int> misfits;  // worst first, then those by their tracks
  TrackErrors tracks;
  std::vector<WindowMatch> matches;  // of all pairs
};

// The verdict on given matches.
SceneVerdict JudgeMatches(const Scene& scene, std::vector<WindowMatch> matches);

// MatchWindows and JudgeMatches. The same for any number of threads.
SceneVerdict JudgeScene(const Scene& scene, const TriangleMesh& mesh,
                        const std::vector<CameraPair>& pairs);

}  // namespace burin
