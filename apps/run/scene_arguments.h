// The scene as a user names it: what to read, and where its photographs and masks are. Every command that
// takes a scene uses it, and so does a checkpoint.
#pragma once

#include <string>

#include "core/scene/formats/scene_loader.h"

namespace burin {

struct SceneArguments {
  std::string scene;
  std::string images;
  std::string masks;
  ViewFilter filter = {};

  SceneSource Source(MaskMeaning masks_mean = MaskMeaning::kIgnore) const {
    return {scene, images, masks, masks_mean, filter};
  }
  // As on a command line: "SCENE --images DIR --masks DIR --views PATTERNS --skip-views PATTERNS".
  std::string Text() const;
  // With paths that hold from any folder.
  SceneArguments Absolute() const;
};

}  // namespace burin
