// The verdict on a scene (core/evidence/verdict.h) as JSON and as text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/run/mesh_parts.h"
#include "core/evidence/verdict.h"
#include "core/scene/scene.h"

namespace burin {

// A run that cannot be right: the command line turns it into one line on standard error and an exit code
// of its own.
class CannotBeRight : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// `verdict` of summary.json. Figures that are not known are null.
nlohmann::ordered_json VerdictJson(const SceneVerdict& verdict, const Scene& scene,
                                   const std::vector<std::string>& left_out);

// What `burin check --json` prints: the verdict, no view left out, and the mesh's parts.
nlohmann::ordered_json CheckJson(const SceneVerdict& verdict, const Scene& scene,
                                 const MeshParts& parts);

// What `burin check` prints: a line for the scene and a table of the views.
std::string VerdictText(const SceneVerdict& verdict, const Scene& scene);

}  // namespace burin
