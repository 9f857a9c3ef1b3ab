// Reads and writes COLMAP workspaces: a folder with images/ and a sparse model in sparse/ or sparse/0/,
// as text or binary files; reads models without a workspace too.
#pragma once

#include <filesystem>
#include <vector>

#include "core/scene/formats/posed_images.h"
#include "core/scene/scene.h"

namespace burin {

// Whether `path` is a workspace, which has sparse/, or a model's folder, which has cameras and images, as text or
// binary files.
bool IsColmap(const std::filesystem::path& path);

// The names of the files of every model that a workspace may have, there or not.
std::vector<std::filesystem::path> ColmapModelFiles(const std::filesystem::path& workspace);

// Reads a workspace or a model; `images` = images/ of the workspace when empty, and images/ in the model's folder
// or in one of the two above it.
//  - The model is taken from sparse/ before sparse/0/, and binary before text, as COLMAP does.
//  - Points are in ascending order of id, whatever the order in the files.
//  - PINHOLE and SIMPLE_PINHOLE cameras are taken as they are; SIMPLE_RADIAL, RADIAL and OPENCV cameras
//    have a lens (core/scene/undistort.h).
// Throws InputError, one line naming file, element and field, for anything missing, truncated,
// malformed, inconsistent or unsupported.
PosedScene ReadColmap(const std::filesystem::path& workspace, const std::filesystem::path& images);

// Writes sparse/ alone, with one PINHOLE camera per view; the projections of the points are their
// observations, whose colours are View::gray's (0 where that is empty). Ids are 1 + the index in the
// scene. The same scene gives the same bytes. Files of a model in the other format in sparse/ are
// removed, so that nobody reads the old one. Throws InputError for what cannot be stored: tracks naming
// no view; points without a projection.
void WriteColmapModel(const Scene& scene, const std::filesystem::path& workspace, bool binary);

// The same as text, of the photographs as they were before they were undistorted: their camera models and lenses,
// and the measurements in them. False, and WriteColmapModel's, where a lens has no model that burin reads.
bool WritePhotographedModel(const Scene& scene, const std::filesystem::path& workspace);

// WriteColmapModel with the images (8-bit, PNG or JPEG by the extension of each view's name) in images/; folders
// are made. Throws InputError also for view names that repeat, leave the folder or have another
// extension, for images missing or of another size than the camera, and for files that cannot be
// written.
void WriteColmapScene(const Scene& scene, const std::filesystem::path& workspace, bool binary);

}  // namespace burin
