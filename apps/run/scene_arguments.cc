#include "apps/run/scene_arguments.h"

#include <filesystem>

namespace burin {
namespace {

std::string AbsoluteOrEmpty(const std::string& path) {
  return path.empty() ? path : std::filesystem::absolute(path).string();
}

}  // namespace

std::string SceneArguments::Text() const {
  return scene + (images.empty() ? "" : " --images " + images) +
         (masks.empty() ? "" : " --masks " + masks) +
         (filter.views.empty() ? "" : " --views " + filter.views) +
         (filter.skip.empty() ? "" : " --skip-views " + filter.skip);
}

SceneArguments SceneArguments::Absolute() const {
  return {AbsoluteOrEmpty(scene), AbsoluteOrEmpty(images), AbsoluteOrEmpty(masks), filter};
}

}  // namespace burin
