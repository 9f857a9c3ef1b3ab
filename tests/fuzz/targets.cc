#include "tests/fuzz/targets.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>

#include "apps/checkpoint.h"
#include "apps/pipeline.h"
#include "core/config.h"
#include "core/error.h"
#include "core/formats/colmap.h"
#include "core/formats/scene_loader.h"
#include "core/mesh_io.h"
#include "core/truth.h"
#include "selection/pair_file.h"

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
                                              {"points", Points},
                                              {"colmap_binary", ColmapBinary},
                                              {"colmap_text", ColmapText},
                                              {"toml", Toml},
                                              {"pairs", Pairs},
                                              {"checkpoint", CheckpointFile},
                                              {"state", State}};
  return targets;
}

}  // namespace burin::fuzz
