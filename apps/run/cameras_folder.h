// cameras/ in a run's output folder, which holds the COLMAP model of its cameras.
#pragma once

#include <filesystem>
#include <vector>

namespace burin {

// The folder and those in it that hold the model.
std::vector<std::filesystem::path> CamerasFolders(const std::filesystem::path& output);

// Before the work instead of after it: throws InputError where one of them is something else or cannot be written to.
void CheckCamerasFolders(const std::filesystem::path& output);

// Removes the model that an earlier run wrote there, and folders that are empty without it. Other files stay.
// Throws InputError where a file of the model cannot be removed.
void RemoveCameras(const std::filesystem::path& output);

}  // namespace burin
