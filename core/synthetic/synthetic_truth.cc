// Writes the parts of a synthetic scene that a COLMAP workspace has no place for.
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/mesh/point_cloud_io.h"
#include "core/scene/formats/colmap.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"
#include "core/support/json_file.h"
#include "core/synthetic/synthetic.h"

namespace burin {
namespace {

void WriteDepth(const std::filesystem::path& path, const cv::Mat1f& depth) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".tiff", depth, bytes)) throw InputError(path, "cannot be encoded");
  WriteTextAtomically(path, std::string(bytes.begin(), bytes.end()));
}

}  // namespace

void WriteSyntheticTruth(const SyntheticScene& synthetic, const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) throw InputError(folder, "no such folder");
  const std::filesystem::path depth_folder = folder / "depth";
  std::filesystem::create_directories(depth_folder, error);
  if (error) throw InputError(depth_folder, "cannot be made: " + error.message());

  WritePointCloud(folder / "truth_points.ply", {synthetic.truth_points, synthetic.truth_normals});
  for (size_t v = 0; v < synthetic.depth.size(); ++v) {
    std::filesystem::path name = synthetic.scene.views[v].name;
    WriteDepth(depth_folder / name.replace_extension(".tiff"), synthetic.depth[v]);
  }

  Scene exact = synthetic.scene;
  for (size_t v = 0; v < exact.views.size(); ++v) exact.views[v].camera = synthetic.true_cameras[v];
  WriteColmapModel(exact, folder / "true_cameras", /*binary=*/false);

  SyntheticOptions options = synthetic.options;
  OptionSet set;
  options.Describe(&set);
  nlohmann::ordered_json json;
  for (const Option& option : set.options()) {
    option.Visit([&](const auto& value) { json["options"][option.name] = value; });
  }
  json["footprint"] = synthetic.footprint;
  json["footprint_unit"] = "world units per pixel at the scene's centre";
  json["depth_unit"] = "world units along the camera's z axis at pixel centres, 0 = no surface";
  json["truth_point_count"] = synthetic.truth_points.size();
  WriteTextAtomically(folder / "synth.json", JsonText(json));
}

}  // namespace burin
