#include "apps/scene_arguments.h"

#include <filesystem>

namespace burin {
namespace {

std::string AbsoluteOrEmpty(const std::string& path) {
  return path.empty() ? path : std::filesystem::absolute(path).string();
}

}  // namespace

std::string SceneArguments::Text() const {
  return scene + (images.empty() ? "" : " --images " + images) +
         (masks.empty() ? "" : " --masks " + masks);
}

SceneArguments SceneArguments::Absolute() const {
  return {AbsoluteOrEmpty(scene), AbsoluteOrEmpty(images), AbsoluteOrEmpty(masks)};
}

std::vector<CLI::Option*> SceneArguments::AddTo(CLI::App* app, bool photographs) {
  std::vector<CLI::Option*> options;
  options.push_back(
      app->add_option("scene", scene,
                      "COLMAP workspace, NAME.mvs, sfm_data.json, NAME.nvm, bundle.out, "
                      "or a folder of camera files (docs/formats.md)")
          ->option_text("SCENE (required)"));
  options.push_back(app->add_option("--images", images,
                                    "folder of the photographs, where it is not the scene's own")
                        ->option_text("DIR"));
  if (photographs) {
    options.push_back(
        app->add_option(
               "--masks", masks,
               "folder of image masks, NAME.png for image NAME: pixels that are zero in them "
               "are not used")
            ->option_text("DIR"));
  }
  return options;
}

}  // namespace burin
