#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>

#include "apps/commands.h"
#include "apps/option_binding.h"
#include "core/error.h"
#include "core/evaluation.h"
#include "core/evaluation_report.h"
#include "core/mesh_io.h"
#include "core/options.h"
#include "core/point_cloud_io.h"

namespace burin {
namespace {

// A PLY file whose header announces no faces.
bool IsPointCloudFile(const std::filesystem::path& path) {
  if (path.extension() != ".ply" && path.extension() != ".PLY") return false;
  std::ifstream file(path, std::ios::binary);
  std::string line;
  for (int i = 0; i < 1000 && std::getline(file, line); ++i) {
    std::istringstream words(line.substr(0, 200));
    std::string first;
    std::string second;
    long long count = 0;
    words >> first >> second >> count;
    if (first == "element" && second == "face") return count == 0;
    if (first == "end_header") return true;
  }
  return false;  // the mesh reader says what is wrong with it
}

Truth ReadTruth(const std::filesystem::path& path) {
  Truth truth;
  if (IsPointCloudFile(path)) {
    truth.cloud = ReadPointCloud(path);
  } else {
    truth.mesh = ReadMesh(path);
  }
  return truth;
}

struct EvaluateCommand {
  EvaluationOptions options;
  OptionSet set;
  std::string mesh;
  std::string truth;
  bool json = false;

  void Run() const {
    options.Thresholds();  // a bad --tau is reported before large files are read
    const TriangleMesh measured = ReadMesh(mesh);
    const Evaluation evaluation = EvaluateMesh(measured, ReadTruth(truth), options);
    if (json) {
      std::cout << ToJson(evaluation).dump(2) << "\n";
    } else {
      std::cout << EvaluationReport(evaluation);
    }
  }
};

}  // namespace

void AddEvaluateCommand(CLI::App* program) {
  CLI::App* app = program->add_subcommand("evaluate", "score a mesh against ground truth");
  const auto command = std::make_shared<EvaluateCommand>();
  command->options.Describe(&command->set);
  app->add_option("--mesh", command->mesh, "PLY, OBJ or OFF")
      ->option_text("FILE (required)")
      ->required();
  app->add_option("--truth", command->truth, "mesh, or PLY point cloud, best with normals")
      ->option_text("FILE (required)")
      ->required();
  app->add_flag("--json", command->json, "print JSON");
  BindOptions(&command->set, app);
  app->callback([command] { command->Run(); });
}

}  // namespace burin
