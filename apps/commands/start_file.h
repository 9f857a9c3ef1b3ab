// Makes a mesh to start from and writes it, with what is known of how it was made beside it.
#pragma once

#include <filesystem>
#include <string>

#include "apps/run/scene_arguments.h"
#include "apps/run/stop_signals.h"
#include "core/mesh/mesh_check.h"
#include "reconstruct/start_options.h"

namespace burin {

struct StartFileRequest {
  SceneSource source;
  StartOptions options;
  std::filesystem::path target;  // NAME.ply; NAME.json beside it
  std::filesystem::path depths;  // folder where depth maps are kept; empty: nowhere
  std::string command_line;
};

// Tells on standard error what it does. Throws InputError where the scene gives no mesh.
MeshReport WriteStartMesh(const StartFileRequest& request, const StopSignals& signals);

// For a run without a mesh: folder/init.ply. Depth maps are in folder/depths until it is written, so that a run that
// is interrupted and begun again goes on from them.
std::string MakeInitMesh(const SceneArguments& source, MaskMeaning masks_mean,
                         const std::filesystem::path& folder, const StopSignals& signals);

}  // namespace burin
