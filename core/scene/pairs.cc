#include "core/scene/pairs.h"

#include <set>
#include <utility>

#include "core/scene/scene.h"

namespace burin {

std::string PairsFault(const std::vector<CameraPair>& pairs, const Scene& scene) {
  const int view_count = static_cast<int>(scene.views.size());
  std::set<std::pair<int, int>> present;
  for (const auto& [reference, second] : pairs) {
    const std::string element = "pairs[" + std::to_string(present.size()) + "]";
    for (const int view : {reference, second}) {
      if (view < 0 || view >= view_count) {
        return element + ": there is no view " + std::to_string(view);
      }
    }
    const std::string names =
        element + " = " + scene.views[reference].name + ", " + scene.views[second].name;
    if (reference == second) return names + ": one view twice";
    if (!present.emplace(reference, second).second) return names + ": appears twice";
  }
  return "";
}

}  // namespace burin
