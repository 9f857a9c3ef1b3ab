// Scenes from and to COLMAP workspaces: a folder with images/ and a sparse model in sparse/ or
// sparse/0/, as text or binary files.
#pragma once

#include <filesystem>

#include "core/scene.h"

namespace burin {

// Reads a workspace.
//  - The model is taken from sparse/ before sparse/0/, and binary before text, as COLMAP does.
//  - Views are in ascending order of image name and points in ascending order of id, whatever the
//    order in the files.
//  - PINHOLE and SIMPLE_PINHOLE cameras are taken as they are; images of SIMPLE_RADIAL, RADIAL and
//    OPENCV cameras are undistorted (core/undistort.h) to a pinhole camera of the same size, focal
//    lengths and principal point.
//  - Points seen by fewer than two views are dropped.
//  - Without `with_images` the photographs are not opened and View::gray stays empty.
//  - `masks` is a folder of image masks named as COLMAP does: for images/NAME the mask NAME.png, of
//    its size, zero where the photograph is not to be used. Images without one are used whole; it is
//    an error when no image has one.
// Throws InputError, one line naming file, element and field, for anything missing, truncated,
// malformed, inconsistent or unsupported.
Scene LoadColmapScene(const std::filesystem::path& workspace, bool with_images = true,
                      const std::filesystem::path& masks = {});

// Writes images/ (8-bit, PNG or JPEG by the extension of each view's name) and sparse/ with one
// PINHOLE camera per view and the projections of the points as observations; folders are made.
// Ids are 1 + the index in the scene. The same scene gives the same bytes. Files of a model in the
// other format in sparse/ are removed, so that nobody reads the old one.
// Throws InputError for what cannot be stored (view names that repeat, leave the folder or have
// another extension; images missing or of another size than the camera; tracks naming no view;
// points without a projection) and for files that cannot be written.
void WriteColmapScene(const Scene& scene, const std::filesystem::path& workspace, bool binary);

}  // namespace burin
