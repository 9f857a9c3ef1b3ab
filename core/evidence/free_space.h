// Facets that stand in free space: photographs look through them.
//
// A facet has votes against it and for it, over all views:
//
//  - A textured window of a view, where the view's ray meets the facet and a front side far behind it. It
//    votes against the facet when two partners of the view agree with it through the plane behind (their
//    ZNCC, the second best of them, above .75) and not through the facet's (.25 less): a true occluder's own
//    pixels do not. Windows at the rim of what is in front do not count. It votes for the facet when they agree through the facet.
//  - A sparse point that a view measured. It votes against a facet that the ray to it meets well in front of
//    it, and for one that it lies on.
//
// Where at least four votes within 60 px of a vote against a facet are against what is there, and four times as
// many as for it, the facet is the seed of a patch. It grows over neighbours that nothing speaks for and behind
// which views see something far away. Such a patch is in free space when at least six votes are against it, and
// at most a quarter as many for it. Where it is most of a part of the mesh and nothing speaks for the rest, the
// rest goes with it.
//
// Cost: four ZNCC at 13 places a window and hypothesis, some 300 windows a view.
#pragma once

#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"

namespace burin {

struct FreeSpacePatch {
  std::vector<int> facets;  // ascending
  int votes_against = 0;
  int votes_for = 0;
};

// What patches hide of a view.
struct HiddenView {
  std::string view;  // its name
  double share = 0;  // of its pixels
};

struct FreeSpace {
  std::vector<FreeSpacePatch> patches;  // by their first facets
  std::vector<char> facet;              // by facet of the mesh: in a patch
  std::vector<HiddenView> hidden;       // views with a share, the largest first
};

// `pairs`: as selected; the first four partners of each view are asked.
FreeSpace FindFreeSpace(const Scene& scene, const TriangleMesh& mesh,
                        const std::vector<CameraPair>& pairs);

}  // namespace burin
