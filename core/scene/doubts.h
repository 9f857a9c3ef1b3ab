// What looks wrong about a scene without being impossible: whatever format it came from, a line each, to be said
// when it has been read.
#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace burin {

// Scene::notes. Principal points farther than .1 of a side from its middle (cropped pictures have such; K of a picture of
// another size, or none, too), and fx / fy outside [.8, 1.25]: the first view by name, and how many more. Sparse
// points that do not reproject (core/scene/track_errors.h): the worst views by name, with their px.
std::vector<std::string> DoubtsAbout(const Scene& scene);

// "a.png 40 px, b.png 20 px and 3 more", of TrackErrors::off.
std::string TrackErrorText(const Scene& scene);

}  // namespace burin
