// What every reader of core/scene/formats makes of its files: photographs with the pinhole camera and lens
// that took them, and sparse points. No pixels yet. Here it becomes a Scene.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/scene/mask_options.h"
#include "core/scene/scene.h"
#include "core/scene/undistort.h"

namespace burin {

struct PosedImage {
  std::string name;                  // unique in its scene; a path relative to the images' folder
  std::filesystem::path image_path;  // of the photograph
  std::filesystem::path mask_path;   // zero = pixel not to be used; empty = none is named
  Camera camera;  // burin's conventions (core/scene/camera.h), the photograph's size
  Lens lens;
  std::string camera_name = "its camera";  // in errors
  std::uint64_t image_id = kNoId;          // as in Origin
  std::uint64_t camera_id = kNoId;
  std::string camera_model;
};

struct PosedScene {
  std::filesystem::path file;           // to be named in errors about the cameras
  std::filesystem::path images_folder;  // where there is one: must exist when photographs are read
  std::vector<PosedImage> images;
  std::vector<ScenePoint> points;  // views index `images`
  // Of every point, or empty; views index `images`, and image points are of the photographs, through the
  // lens.
  Tracks tracks;
  std::vector<std::string> notes;  // as in Scene
};

// Views in ascending order of name; points seen by fewer than two views are dropped. Photographs are
// read and undistorted `with_images`, else View::gray stays empty; pixels that the lens takes from outside
// the photograph are zero in View::mask. `masks` is a folder of masks NAME.png for photograph NAME, which
// takes precedence over mask_path. Throws InputError for what is wrong with cameras
// (core/scene/formats/camera_checks.h), lenses that leave less than half of the picture, photographs or masks,
// and for a `masks` folder without any.
// With masks that mean the object there must be one, and View::object is theirs.
Scene MakeScene(const PosedScene& posed, bool with_images, const std::filesystem::path& masks = {},
                MaskMeaning meaning = MaskMeaning::kIgnore);

// The pixels of views that MakeScene made, from their files again, through camera and lens as they are now. Throws InputError
// as MakeScene does.
void ReadPixels(const std::vector<View*>& views);

// Throws InputError for what WritePhotographs would have to refuse: those with a lens need a name that ends
// in .png, .jpg or .jpeg. Unless `overwrite`, also where it would replace a file by another one.
void CheckPhotographTargets(const PosedScene& posed, const std::filesystem::path& folder,
                            bool overwrite);

// `posed` is one whose photographs MakeScene has read, so that nothing broken is passed on.
// Copies the photographs to folder/NAME, but for those that are there already; those with a lens are
// undistorted, in colour, with 8 bits.
void WritePhotographs(const PosedScene& posed, const std::filesystem::path& folder);

[[noreturn]] void ThrowExists(const std::filesystem::path& file);

// Whether both name one file or folder that exists.
bool IsSameFile(const std::filesystem::path& a, const std::filesystem::path& b);

// Width and height of photographs whose format does not say; files are read on all threads.
std::vector<cv::Size> PhotographSizes(const std::vector<std::filesystem::path>& paths);

// folder/name for the first of `folders` that has it ("" is the working folder, as the parent of a
// bare file name is); else throws InputError, naming them.
std::filesystem::path FindPhotograph(const std::string& name,
                                     const std::vector<std::filesystem::path>& folders);

// K [R | t] from a projection matrix with the convention that pixel centres are whole numbers, and the
// image size. Throws InputError about `element` of `file` when it is singular or its axes are not
// square to each other (skew above 2e-5 of the focal length): burin's cameras have none.
Camera CameraOfProjection(const Eigen::Matrix<double, 3, 4>& projection, cv::Size size,
                          const std::filesystem::path& file, const std::string& element);

// The same from K; `pixel_centre` is the coordinate of the first pixel's centre in its convention, 0 or
// 0.5. Pose and size are left to the caller.
Camera CameraOfIntrinsics(const Eigen::Matrix3d& intrinsics, double pixel_centre,
                          const std::filesystem::path& file, const std::string& element);

}  // namespace burin
