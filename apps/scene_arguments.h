// The scene on the command line: what to read and where its photographs and masks are. The same for
// every command that takes one.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "core/formats/scene_loader.h"

namespace burin {

struct SceneArguments {
  std::string scene;
  std::string images;
  std::string masks;

  SceneSource Source() const { return {scene, images, masks}; }
  // As on a command line: "SCENE --images DIR --masks DIR".
  std::string Text() const;
  // With paths that hold from any folder.
  SceneArguments Absolute() const;

  // Adds SCENE and --images to a command and, for one that looks at photographs, --masks. Returns the
  // options: SCENE first.
  std::vector<CLI::Option*> AddTo(CLI::App* app, bool photographs);
};

}  // namespace burin
