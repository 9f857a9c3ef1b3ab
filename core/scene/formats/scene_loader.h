// Loads scenes in every format that burin reads (kFormats): one loader, which recognises what it is given.
// docs/formats.md says what each reader reads and what it ignores.
#pragma once

#include <filesystem>
#include <string>

#include "core/scene/formats/posed_images.h"
#include "core/scene/formats/view_filter.h"
#include "core/scene/scene.h"

namespace burin {

struct SceneSource {
  std::filesystem::path path;    // a folder or file of one of the formats
  std::filesystem::path images;  // where the photographs are; empty = where the format has them
  std::filesystem::path masks;   // folder of masks NAME.png for photograph NAME; empty = none
  MaskMeaning masks_mean = MaskMeaning::kIgnore;
  ViewFilter filter = {};
};

// Throws InputError, one line naming file and line, byte or field, for what no format fits, and for
// anything missing, truncated, malformed or unsupported.
PosedScene ReadScene(const SceneSource& source);

// The same with its photographs, undistorted; without `with_images` View::gray stays empty.
Scene LoadScene(const SceneSource& source, bool with_images = true);

// "COLMAP", "OpenMVS", ...
std::string FormatOf(const std::filesystem::path& path);

// The mesh that belongs to a scene by its name, for formats that have such: of NAME.mvs, NAME_mesh.ply.
// Empty when there is none.
std::filesystem::path MeshBeside(const std::filesystem::path& path);

}  // namespace burin
