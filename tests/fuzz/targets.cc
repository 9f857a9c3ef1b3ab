#include "tests/fuzz/targets.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>

#include "apps/run/checkpoint.h"
#include "apps/run/pipeline.h"
#include "core/evaluate/truth.h"
#include "core/image/gray_image.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/formats/colmap.h"
#include "core/scene/formats/scene_loader.h"
#include "core/support/config.h"
#include "core/support/error.h"
#include "selection/pair_file.h"
#include "tests/test_scene.h"

namespace burin::fuzz {
namespace {

// A folder of this process, removed when it ends.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "burin fuzz XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) std::abort();
    path_ = pattern;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::filesystem::path Write(const std::string& name, const std::string& bytes) const {
    const std::filesystem::path path = path_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

const Folder& Files() {
  static const Folder folder;
  return folder;
}

void ReadMeshAs(const std::string& name, const std::string& bytes) {
  try {
    ReadMesh(Files().Write(name, bytes));
  } catch (const InputError&) {
  }
}

void Ply(const std::string& bytes) { ReadMeshAs("mesh.ply", bytes); }
void Obj(const std::string& bytes) { ReadMeshAs("mesh.obj", bytes); }
void Off(const std::string& bytes) { ReadMeshAs("mesh.off", bytes); }
void Stl(const std::string& bytes) { ReadMeshAs("mesh.stl", bytes); }

Scene TinyScene() {
  Scene scene;
  for (const LevelView& level : test::RandomViews(64, 48)) {
    View& view = scene.views.emplace_back();
    view.name = std::to_string(scene.views.size()) + ".png";
    view.camera = level.camera;
    level.image.convertTo(view.gray, CV_8U);
  }
  return scene;
}

// What reading lets pass goes through pairs, visibility, kernels, solver, guard and subdivision.
void Refinement(const std::string& bytes) {
  constexpr size_t kMostFaces = 2000;
  static const Scene scene = TinyScene();
  PipelineOptions options;
  options.threads = 1;
  options.refinement.level.count = 2;
  options.refinement.level.min_side_px = 20;
  options.refinement.level.max_facet_px = 40;
  options.refinement.solver.max_iterations = 2;
  PairSelection all;
  all.pairs = test::AllPairs();
  PipelineParts parts;
  parts.selection = &all;
  try {
    const TriangleMesh mesh = ReadMesh(Files().Write("mesh.ply", bytes));
    if (mesh.faces.size() > kMostFaces) return;
    RunPipeline(scene, mesh, options, parts);
    SelectPairs(scene, mesh, options.pairs);
  } catch (const InputError&) {
  }
}

void Points(const std::string& bytes) {
  try {
    ReadTruth(Files().Write("truth.ply", bytes));
  } catch (const InputError&) {
  }
}

// The three files of a model in one: each ends at a line "%%%%".
void Colmap(const std::string& bytes, const std::string& extension) {
  constexpr char kSeparator[] = "\n%%%%\n";
  constexpr size_t kLength = sizeof(kSeparator) - 1;
  size_t begin = 0;
  for (const char* name : {"cameras", "images", "points3D"}) {
    const size_t end = std::min(bytes.find(kSeparator, begin), bytes.size());
    Files().Write("sparse/" + (name + extension), bytes.substr(begin, end - begin));
    begin = std::min(bytes.size(), end + kLength);
  }
  std::filesystem::create_directories(Files().path() / "images");
  for (const std::string other : {".bin", ".txt"}) {
    if (other == extension) continue;
    for (const std::string name : {"cameras", "images", "points3D"}) {
      std::filesystem::remove(Files().path() / "sparse" / (name + other));
    }
  }
  try {
    LoadScene({Files().path(), {}, {}}, /*with_images=*/false);
  } catch (const InputError&) {
  }
}

void ColmapBinary(const std::string& bytes) { Colmap(bytes, ".bin"); }
void ColmapText(const std::string& bytes) { Colmap(bytes, ".txt"); }

// A scene in one file, beside the photographs a.png and b.png.
void SceneAs(const std::string& name, const std::string& bytes) {
  static const bool written = [] {
    const cv::Mat photograph(6, 8, CV_8UC1, cv::Scalar(90));
    for (const char* image : {"a.png", "b.png", "00000000.png", "00000001.png"}) {
      WriteGrayImage(photograph, Files().Write("scene/readme", "").parent_path() / image);
    }
    return true;
  }();
  (void)written;
  try {
    LoadScene({Files().Write("scene/" + name, bytes), {}, {}});
  } catch (const InputError&) {
  }
}

void Mvs(const std::string& bytes) { SceneAs("scene.mvs", bytes); }
void Nvm(const std::string& bytes) { SceneAs("scene.nvm", bytes); }
void OpenMvg(const std::string& bytes) { SceneAs("sfm_data.json", bytes); }
void Transforms(const std::string& bytes) { SceneAs("transforms.json", bytes); }
// The reconstruction and its tracks in one: it ends at a line "%%%%".
void OpenSfm(const std::string& bytes) {
  const size_t end = std::min(bytes.find("\n%%%%\n"), bytes.size());
  Files().Write("scene/tracks.csv", bytes.substr(std::min(bytes.size(), end + 6)));
  SceneAs("reconstruction.json", bytes.substr(0, end));
}
void Meshroom(const std::string& bytes) { SceneAs("cameras.sfm", bytes); }
void Metashape(const std::string& bytes) { SceneAs("cameras.xml", bytes); }
void Middlebury(const std::string& bytes) { SceneAs("tiny_par.txt", bytes); }

void Bundler(const std::string& bytes) {
  Files().Write("scene/list.txt", "a.png\nb.png\n");
  SceneAs("bundle.out", bytes);
}

// Cameras of the scene's four photographs.
void ArraysAs(const std::string& name, const std::string& bytes) {
  SceneAs("readme", "");
  try {
    LoadScene({Files().Write("arrays/" + name, bytes), Files().path() / "scene", {}});
  } catch (const InputError&) {
  }
}

void Llff(const std::string& bytes) { ArraysAs("poses_bounds.npy", bytes); }
void Neus(const std::string& bytes) { ArraysAs("cameras_sphere.npz", bytes); }

// One camera of two is what is fuzzed.
void CameraFiles(const std::string& ending, const std::string& good, const std::string& names,
                 const std::string& bytes) {
  const std::string folder = "cameras" + ending;
  SceneAs("readme", "");
  Files().Write(folder + "/" + names.substr(0, names.size() / 2) + ending, good);
  try {
    LoadScene(
        {Files().Write(folder + "/" + names.substr(names.size() / 2) + ending, bytes).parent_path(),
         Files().path() / "scene",
         {}});
  } catch (const InputError&) {
  }
}

void Strecha(const std::string& bytes) {
  CameraFiles(".camera", "5 0 4\n0 5 3\n0 0 1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 0\n8 6\n",
              "a.pngb.png", bytes);
}

void Projection(const std::string& bytes) {
  CameraFiles(".P", "5 0 4 0\n0 5 3 0\n0 0 1 0\n", "a.pngb.png", bytes);
}

void MvsNetCamera(const std::string& bytes) {
  CameraFiles("_cam.txt",
              "extrinsic\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n\nintrinsic\n5 0 4\n0 5 3\n0 0 1\n",
              "0000000000000001", bytes);
}

void Toml(const std::string& bytes) {
  PipelineOptions options;
  OptionSet set;
  options.Describe(&set);
  try {
    ParseConfig(bytes, "run.toml", &set);
  } catch (const InputError&) {
  }
}

void Pairs(const std::string& bytes) {
  static const Scene scene = [] {
    Scene three;
    for (const char* name : {"a.png", "b.png", "c.png"}) three.views.emplace_back().name = name;
    return three;
  }();
  try {
    ReadPairFile(Files().Write("pairs.json", bytes), scene);
  } catch (const InputError&) {
  }
}

void CheckpointFile(const std::string& bytes) {
  try {
    ReadCheckpoint(Files().Write("checkpoint.cbor", bytes));
  } catch (const InputError&) {
  }
}

// What a checkpoint's hash keeps from being reached.
void State(const std::string& bytes) {
  try {
    StateFromBytes({bytes.begin(), bytes.end()});
  } catch (const std::exception&) {  // as ReadCheckpoint does
  }
}

}  // namespace

const std::vector<Target>& Targets() {
  static const std::vector<Target> targets = {{"ply", Ply},
                                              {"obj", Obj},
                                              {"off", Off},
                                              {"stl", Stl},
                                              {"refinement", Refinement},
                                              {"points", Points},
                                              {"colmap_binary", ColmapBinary},
                                              {"colmap_text", ColmapText},
                                              {"mvs", Mvs},
                                              {"nvm", Nvm},
                                              {"openmvg", OpenMvg},
                                              {"transforms", Transforms},
                                              {"meshroom", Meshroom},
                                              {"metashape", Metashape},
                                              {"opensfm", OpenSfm},
                                              {"middlebury", Middlebury},
                                              {"bundler", Bundler},
                                              {"llff", Llff},
                                              {"neus", Neus},
                                              {"strecha", Strecha},
                                              {"projection", Projection},
                                              {"mvsnet", MvsNetCamera},
                                              {"toml", Toml},
                                              {"pairs", Pairs},
                                              {"checkpoint", CheckpointFile},
                                              {"state", State}};
  return targets;
}

}  // namespace burin::fuzz
