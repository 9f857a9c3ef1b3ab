#include "core/scene/formats/scene_loader.h"

#include <system_error>

#include "core/scene/formats/bundler.h"
#include "core/scene/formats/colmap.h"
#include "core/scene/formats/llff.h"
#include "core/scene/formats/meshroom.h"
#include "core/scene/formats/metashape.h"
#include "core/scene/formats/middlebury.h"
#include "core/scene/formats/mvsnet.h"
#include "core/scene/formats/neus.h"
#include "core/scene/formats/nvm.h"
#include "core/scene/formats/openmvg.h"
#include "core/scene/formats/openmvs.h"
#include "core/scene/formats/opensfm.h"
#include "core/scene/formats/photograph_checks.h"
#include "core/scene/formats/strecha.h"
#include "core/scene/formats/transforms.h"
#include "core/scene/formats/view_names.h"
#include "core/scene/near_depth.h"
#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

struct Format {
  const char* name;
  const char* what;  // is recognised
  bool (*recognises)(const fs::path& path);
  PosedScene (*read)(const fs::path& path, const fs::path& images);
};

// The first that recognises a path reads it.
constexpr Format kFormats[] = {
    {"COLMAP", "a folder with sparse/, or a model", IsColmap, ReadColmap},
    {"OpenMVS", "NAME.mvs", IsOpenMvs, ReadOpenMvs},
    {"Transforms", "NAME.json of nerfstudio, instant-ngp or Blender, or a folder with one",
     IsTransforms, ReadTransforms},
    {"OpenSfM", "reconstruction.json of OpenSfM or OpenDroneMap, or a folder with one", IsOpenSfm,
     ReadOpenSfm},
    {"Meshroom", "NAME.sfm, or a folder with cameras.sfm", IsMeshroom, ReadMeshroom},
    {"Metashape", "cameras.xml, or a folder with it", IsMetashape, ReadMetashape},
    {"openMVG", "sfm_data.json", IsOpenMvg, ReadOpenMvg},
    {"NVM", "NAME.nvm", IsNvm, ReadNvm},
    {"Bundler", "NAME.out, or a folder with bundle.out", IsBundler, ReadBundler},
    {"Middlebury", "NAME_par.txt, or a folder with one", IsMiddlebury, ReadMiddlebury},
    {"NeuS", "a folder with cameras_sphere.npz or cameras.npz", IsNeus, ReadNeus},
    {"LLFF", "a folder with poses_bounds.npy", IsLlff, ReadLlff},
    {"Strecha", "a folder with NAME.camera or NAME.P", IsStrecha, ReadStrecha},
    {"DTU", "a folder with pos_NNN.txt", IsDtu, ReadDtu},
    {"MVSNet", "a folder with NNNNNNNN_cam.txt, or with cams/ that has", IsMvsNet, ReadMvsNet},
};

const Format& Recognised(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw InputError(path, "no such file or folder");
  for (const Format& format : kFormats) {
    if (format.recognises(path)) return format;
  }
  std::string known;
  for (const Format& format : kFormats) {
    known += std::string(known.empty() ? "" : "; ") + format.name + " (" + format.what + ")";
  }
  throw InputError(path, "is no scene that burin knows: " + known);
}

}  // namespace

PosedScene ReadScene(const SceneSource& source) {
  PosedScene posed = Recognised(source.path).read(source.path, source.images);
  SettleNames(&posed);
  LeaveOutViews(source.filter, &posed);
  FindSpellings(&posed);
  CheckOneViewAPhotograph(posed);
  ScaleToPhotographs(&posed);
  return posed;
}

Scene LoadScene(const SceneSource& source, bool with_images) {
  Scene scene = MakeScene(ReadScene(source), with_images, source.masks, source.masks_mean);
  SetNearDepths(&scene);
  return scene;
}

std::string FormatOf(const fs::path& path) { return Recognised(path).name; }

fs::path MeshBeside(const fs::path& path) {
  if (path.extension() != ".mvs") return {};
  const fs::path mesh = path.parent_path() / (path.stem().string() + "_mesh.ply");
  std::error_code error;
  return fs::exists(mesh, error) ? mesh : fs::path();
}

}  // namespace burin
