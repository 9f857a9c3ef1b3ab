// Finds the masks of photographs in a folder of them, by the names that programs give them.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/scene/formats/posed_images.h"

namespace burin {

// Of the photograph folder/stem.ext, the first of these that is there, without regard to case and spelling:
// folder/stem.ext.png, and for each format of pictures folder/stem.EXT, folder/stem_mask.EXT, folder/stem.mask.EXT and
// folder/mask_stem.EXT; then the same without the folder, where one photograph alone has that name.
class MaskFiles {
 public:
  // Throws InputError unless `folder` is one.
  MaskFiles(const std::filesystem::path& folder, const std::vector<PosedImage>& images);

  // Of images[i]; empty where it has none. Never the photograph itself.
  const std::filesystem::path& Of(size_t i) const { return of_image_[i]; }

  // How many images have one, how the first that is missing would be called, and files that are none's: a line, or nothing
  // when all have one and no file is left. Throws InputError when no image has one.
  std::string Note(const std::vector<PosedImage>& images) const;

 private:
  std::filesystem::path folder_;
  std::map<std::string, std::filesystem::path>
      files_;  // by SpellingKey of the path below the folder
  std::vector<std::filesystem::path> of_image_;
};

// Notes how many views of a scene that has been read have a mask or transparent pixels, and what share of all pixels these
// leave.
void NoteMasks(Scene* scene);

}  // namespace burin
