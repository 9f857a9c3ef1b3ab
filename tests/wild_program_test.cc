// The program on what people really bring: what it says, and its exit code.
#include <Eigen/Geometry>
#include <iomanip>
#include <nlohmann/json.hpp>

#include "tests/program_test.h"

namespace burin {
namespace {

using testing::HasSubstr;

class Wild : public ProgramTest {};

TEST_F(Wild, AScoreOfNothingIsNoScore) {
  const std::string square = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
  const std::string far =
      "OFF\n4 2 0\n100 100 100\n1100 100 100\n1100 1100 100\n100 1100 100\n3 0 1 2\n3 0 2 3\n";
  const std::vector<std::string> evaluate = {"evaluate",
                                             "--mesh",
                                             Write("metres.off", square),
                                             "--truth",
                                             Write("millimetres.off", far),
                                             "--sample_count",
                                             "1000",
                                             "--unit",
                                             "1",
                                             "--json"};
  const Outcome outcome = Run(evaluate);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("nothing matched"));
  EXPECT_THAT(
      outcome.err,
      HasSubstr("mesh 1 x 1 x 0 around 0.5 0.5 0, truth 1000 x 1000 x 0 around 600 600 100"));
  const nlohmann::json json = nlohmann::json::parse(outcome.out);
  EXPECT_TRUE(json["accuracy"]["rmse"].is_null());
  EXPECT_EQ(json["accuracy"]["matched"], 0);
}

// What OpenMVS has in single precision, far from the origin.
TEST_F(Wild, SinglePrecisionFarFromTheOriginIsSaid) {
  ASSERT_EQ(Run({"synth", "--output", In("s"), "--text", "--synth.width", "64", "--synth.height",
                 "48", "--synth.views", "3", "--synth.point_count", "50"})
                .exit_code,
            0);
  EXPECT_EQ(Run({"convert", In("s"), In("near.mvs")}).err, "");
  // Moved by (0, 5e6, 0): t - R (0, 5e6, 0).
  std::istringstream lines(ReadAll(In("s/sparse/images.txt")));
  std::string moved;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    double id = 0, w = 0, x = 0, y = 0, z = 0;
    Eigen::Vector3d t;
    std::string rest;
    if (line.find(".png") == std::string::npos) {
      moved += line + "\n";
      continue;
    }
    words >> id >> w >> x >> y >> z >> t.x() >> t.y() >> t.z();
    std::getline(words, rest);
    const Eigen::Quaterniond q(w, x, y, z);
    t -= q.normalized() * Eigen::Vector3d(0, 5e6, 0);
    std::ostringstream text;
    text << std::setprecision(17) << id << " " << w << " " << x << " " << y << " " << z << " "
         << t.x() << " " << t.y() << " " << t.z() << rest << "\n";
    moved += text.str();
  }
  Write("s/sparse/images.txt", moved);
  std::istringstream points(ReadAll(In("s/sparse/points3D.txt")));
  std::string moved_points;
  for (std::string line; std::getline(points, line);) {
    std::istringstream words(line);
    std::string id, x, rest;
    double y = 0;
    if (line[0] == '#') continue;
    words >> id >> x >> y;
    std::getline(words, rest);
    std::ostringstream text;
    text << std::setprecision(17) << id << " " << x << " " << y + 5e6 << rest << "\n";
    moved_points += text.str();
  }
  Write("s/sparse/points3D.txt", moved_points);
  const Outcome outcome = Run({"convert", In("s"), In("far.mvs")});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err,
              HasSubstr("far.mvs: OpenMVS has points and meshes in single precision: at "
                        "5e+06 single precision has steps of 0.5 units, "));
}

}  // namespace
}  // namespace burin
