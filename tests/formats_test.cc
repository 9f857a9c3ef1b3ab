// Every reader gives the cameras that the files were made of. Points reproject to where the format's own
// formula, written down here, has them, and photographs come out undistorted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "core/scene/formats/openmvs.h"
#include "core/scene/formats/scene_loader.h"
#include "tests/given_scene.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Formats : public GivenScene {
 protected:
  static std::string ErrorOf(const fs::path& path) { return LoadError(path); }
};

std::string Digits(double value) {
  std::ostringstream text;
  text << std::setprecision(17) << value;
  return text.str();
}

template <typename Derived>
std::string Text(const Eigen::MatrixBase<Derived>& matrix, const char* between_rows = "\n") {
  std::string text;
  for (int r = 0; r < matrix.rows(); ++r) {
    for (int c = 0; c < matrix.cols(); ++c)
      text += Digits(matrix(r, c)) + (c + 1 < matrix.cols() ? " " : "");
    text += between_rows;
  }
  return text;
}

// `first` is where the format has the centre of the first pixel.
Eigen::Matrix3d Intrinsics(const Camera& camera, double first) {
  Eigen::Matrix3d k;
  k << camera.fx, 0, camera.cx - 0.5 + first, 0, camera.fy, camera.cy - 0.5 + first, 0, 0, 1;
  return k;
}

TEST_F(Formats, Strecha) {
  for (int v = 0; v < 2; ++v) {
    const Camera& c = CameraAt(v);
    WriteFile("cameras/view" + std::to_string(v) + ".png.camera",
              Text(Intrinsics(c, 0)) + "0 0 0\n" + Text(c.rotation.transpose()) +
                  Text(c.Center().transpose()) + "6 4\n");
  }
  EXPECT_EQ(FormatOf(Folder() / "cameras"), "Strecha");
  ExpectScene(LoadScene({Folder() / "cameras", {}, {}}), false);
  ExpectScene(LoadScene({Folder() / "cameras", Images(), {}}), false);
  // Half the size: the camera goes with it.
  fs::create_directories(Folder() / "half");
  for (const char* name : {"view0.png", "view1.png"}) {
    cv::imwrite((Folder() / "half" / name).string(), cv::Mat(2, 3, CV_8UC1, cv::Scalar(9)));
  }
  const Scene half = LoadScene({Folder() / "cameras", Folder() / "half", {}});
  EXPECT_EQ(half.views[0].camera.width, 3);
  EXPECT_NEAR(half.views[0].camera.cx, 0.5 * CameraAt(0).cx, 1e-9);
  EXPECT_THAT(ErrorOf(Images()), HasSubstr("is no scene that burin knows"));
}

// What editors and other programs make of text files.
TEST_F(Formats, TextAsFoundInTheWild) {
  for (int v = 0; v < 2; ++v) {
    const Camera& c = CameraAt(v);
    std::string text = "\xEF\xBB\xBF" + Text(Intrinsics(c, 0)) + "+0 1e-330 0.0\n\n" +
                       Text(c.rotation.transpose()) + Text(c.Center().transpose()) + "6 4\n\n";
    for (size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) {
      text.replace(at, 1, "\r\n");
    }
    WriteFile("cameras/view" + std::to_string(v) + ".png.camera", text);
  }
  ExpectScene(LoadScene({Folder() / "cameras", {}, {}}), false);
  WriteFile("cameras/view0.png.camera", "+-1 0 0\n");
  EXPECT_THAT(ErrorOf(Folder() / "cameras"), HasSubstr("K: '+-1' is not a number"));
  WriteFile("cameras/view0.png.camera", "1e999 0 0\n");
  EXPECT_THAT(ErrorOf(Folder() / "cameras"), HasSubstr("K: '1e999' is not a number"));
}

TEST_F(Formats, StrechaProjectionMatrices) {
  for (int v = 0; v < 2; ++v) {
    const Camera& c = CameraAt(v);
    Eigen::Matrix<double, 3, 4> pose;
    pose << c.rotation, c.translation;
    // Any scale and sign is the same camera.
    WriteFile("cameras/view" + std::to_string(v) + ".png.P",
              Text((v == 0 ? 3.0 : -0.25) * Intrinsics(c, 0) * pose));
  }
  ExpectScene(LoadScene({Folder() / "cameras", {}, {}}), false);
  WriteFile("cameras/view0.png.P", "1 0 0 0\n0 1 0 0\n0 1 0 0\n");
  EXPECT_THAT(ErrorOf(Folder() / "cameras"),
              HasSubstr("view0.png.P: P: projection matrix is singular"));
  WriteFile("cameras/view0.png.P", "1 0 0 0\n0 1 0\n0 1 0 0\n");
  EXPECT_THAT(ErrorOf(Folder() / "cameras"), HasSubstr("view0.png.P: line 2: P: is missing"));
}

TEST_F(Formats, Middlebury) {
  std::string text = "2\n";
  for (int v = 0; v < 2; ++v) {
    const Camera& c = CameraAt(v);
    text += scene_.views[v].name + " " + Text(Intrinsics(c, 0), " ") + Text(c.rotation, " ") +
            Text(c.translation.transpose(), "\n");
  }
  WriteFile("images/tiny_par.txt", text);
  EXPECT_EQ(FormatOf(Images()), "Middlebury");
  ExpectScene(LoadScene({Images(), {}, {}}), false);
  ExpectScene(LoadScene({Images() / "tiny_par.txt", {}, {}}), false);
  WriteFile("images/tiny_par.txt", "3" + text.substr(1));
  EXPECT_THAT(ErrorOf(Images()), HasSubstr("tiny_par.txt: number of images = 3, but 2 follow"));
  WriteFile("images/tiny_par.txt", text.substr(0, text.size() / 2));
  EXPECT_THAT(ErrorOf(Images()), HasSubstr("tiny_par.txt: line 3: K: is missing"));
}

TEST_F(Formats, Dtu) {
  for (int v = 0; v < 2; ++v) {
    const Camera& c = CameraAt(v);
    const std::string number = "00" + std::to_string(v + 1);
    Eigen::Matrix<double, 3, 4> pose;
    pose << c.rotation, c.translation;
    WriteFile("cal/pos_" + number + ".txt", Text(Intrinsics(c, 0) * pose));
    scene_.views[v].name = "rect_" + number + "_max.png";
    cv::imwrite((Images() / scene_.views[v].name).string(), scene_.views[v].gray);
    cv::imwrite((Images() / ("rect_" + number + "_3_r5000.png")).string(), scene_.views[0].gray);
    cv::imwrite((Images() / ("rect_10" + number + "_max.png")).string(), scene_.views[0].gray);
  }
  EXPECT_EQ(FormatOf(Folder() / "cal"), "DTU");
  ExpectScene(LoadScene({Folder() / "cal", {}, {}}), false);
  fs::remove(Images() / "rect_002_max.png");
  fs::remove(Images() / "rect_002_3_r5000.png");
  EXPECT_THAT(ErrorOf(Folder() / "cal"),
              HasSubstr("pos_002.txt: no photograph has the number 002"));
}

TEST_F(Formats, MvsNet) {
  for (int v = 0; v < 2; ++v) {
    const Camera& c = CameraAt(v);
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    pose.topLeftCorner<3, 3>() = c.rotation;
    pose.topRightCorner<3, 1>() = c.translation;
    scene_.views[v].name = "0000000" + std::to_string(v) + (v == 0 ? ".png" : ".PNG");
    cv::imwrite((Images() / scene_.views[v].name).string(), scene_.views[v].gray);
    WriteFile("cams/0000000" + std::to_string(v) + "_cam.txt",
              "extrinsic\n" + Text(pose) + "\nintrinsic\n" + Text(Intrinsics(c, 0.5)) +
                  "\n425.0 2.5 192 933.8\n");
  }
  EXPECT_EQ(FormatOf(Folder()), "MVSNet");
  ExpectScene(LoadScene({Folder(), {}, {}}), false);
  ExpectScene(LoadScene({Folder() / "cams", {}, {}}), false);
  WriteFile("cams/00000001_cam.txt", "extrinsic\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 2\n");
  EXPECT_THAT(ErrorOf(Folder()), HasSubstr("00000001_cam.txt: line 5: extrinsic: its last row"));
}

// Bundler's and VisualSFM's cameras have one focal length and the principal point in the middle.
void MakeCentred(Scene* scene) {
  for (View& view : scene->views) {
    view.camera.fy = view.camera.fx;
    view.camera.cx = 3;
    view.camera.cy = 2;
  }
}

TEST_F(Formats, Bundler) {
  MakeCentred(&scene_);
  std::string text = "# Bundle file v0.3\n3 3\n";
  for (const int v : {0, -1, 1}) {
    if (v < 0) {
      text += "0 0 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n";
      continue;
    }
    const Camera& c = CameraAt(v);
    const Eigen::Matrix3d turn = Eigen::Vector3d(1, -1, -1).asDiagonal();
    text += Digits(c.fx) + " 0 0\n" + Text(turn * c.rotation) +
            Text((turn * c.translation).transpose());
  }
  for (const ScenePoint& point : scene_.points) {
    text += Text(point.position.transpose()) + "200 100 9\n2 0 17 -0.5 1.5 2 4 0 0\n";
  }
  WriteFile("bundle/bundle.out", text);
  WriteFile("list.txt", "images/view0.png\nimages/lost.png\n./images/view1.png 0 5\n");
  EXPECT_EQ(FormatOf(Folder()), "Bundler");
  fs::create_directories(Folder() / "my images");
  for (const char* name : {"view0.png", "view1.png"}) {
    fs::copy(Images() / name, Folder() / "my images" / name);
  }
  WriteFile("list.txt", "my images\\view0.png\nlost.png\nmy images/view1.png 0 5.5e3\n");
  EXPECT_EQ(LoadScene({Folder(), {}, {}}).views[0].name, "my images/view0.png");
  WriteFile("list.txt", "images/view0.png\nimages/lost.png\n./images/view1.png 0 5\n");
  for (View& view : scene_.views) view.name = "images/" + view.name;
  ExpectScene(LoadScene({Folder(), {}, {}}), true);
  ExpectScene(LoadScene({Folder() / "bundle/bundle.out", Images(), {}}), true);
  WriteFile("list.txt", "images/view0.png\n");
  EXPECT_THAT(ErrorOf(Folder()), HasSubstr("has 1 names, but bundle.out has 3 cameras"));
  WriteFile("list.txt", "images/view0.png\nimages/lost.png\n./images/view1.png 0 5\n");
  WriteFile("bundle/bundle.out", text.substr(0, text.size() - 8));
  EXPECT_THAT(ErrorOf(Folder()), HasSubstr("bundle.out: line 26: view: "));
}

// A point seen through Bundler's lens, by its own formula, lands where the undistorted photograph has it:
// a bright pixel of the photograph there is bright in the scene's image at the pinhole's projection.
TEST_F(Formats, BundlersLens) {
  MakeCentred(&scene_);
  constexpr int kWidth = 80;
  constexpr int kHeight = 60;
  const double f = 60;
  const double k1 = 0.2;
  const double k2 = -0.1;
  const Eigen::Vector3d point(0.35, 0.25, -1);  // in Bundler's camera frame: y up, looking along -z
  const Eigen::Vector2d p = -point.head<2>() / point.z();
  const double r2 = p.squaredNorm();
  const Eigen::Vector2d at = f * (1 + k1 * r2 + k2 * r2 * r2) * p;
  cv::Mat photograph(kHeight, kWidth, CV_8UC1);
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      const double x = col + 0.5 - kWidth / 2.0 - at.x();
      const double y = -(row + 0.5 - kHeight / 2.0) - at.y();
      photograph.at<uchar>(row, col) =
          cv::saturate_cast<uchar>(250 * std::exp(-(x * x + y * y) / 8));
    }
  }
  std::string text = "# Bundle file v0.3\n2 0\n";
  for (int v = 0; v < 2; ++v) {
    cv::imwrite((Images() / scene_.views[v].name).string(), photograph);
    text += "60 0.2 -0.1\n1 0 0\n0 1 0\n0 0 1\n" + std::to_string(v) + " 0 0\n";
  }
  WriteFile("bundle.out", text);
  WriteFile("list.txt", "images/view0.png\nimages/view1.png\n");
  const Scene scene = LoadScene({Folder(), {}, {}});
  const Eigen::Vector2d seen =
      scene.views[0].camera.Project(point);  // the world is Bundler's frame
  cv::Mat1f gray;
  scene.views[0].gray.convertTo(gray, CV_32F);
  double sum = 0;
  Eigen::Vector2d centroid(0, 0);
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      sum += gray(row, col);
      centroid += gray(row, col) * Eigen::Vector2d(col + 0.5, row + 0.5);
    }
  }
  EXPECT_LT((centroid / sum - seen).norm(), 0.05);
  EXPECT_GT((at - f * p).norm(), 0.8);  // the lens matters
}

TEST_F(Formats, Nvm) {
  MakeCentred(&scene_);
  const auto text = [&](const std::string& header) {
    std::string nvm = header + "\n\n2\n";
    for (int v = 0; v < 2; ++v) {
      const Camera& c = CameraAt(v);
      const Eigen::Quaterniond q(c.rotation);
      nvm += "images/" + scene_.views[v].name + "\t" + Digits(c.fx) + " " + Digits(q.w()) + " " +
             Digits(q.x()) + " " + Digits(q.y()) + " " + Digits(q.z()) + " " +
             Text(c.Center().transpose(), " ") + "0 0\n";
    }
    nvm += "\n3\n";
    for (const ScenePoint& point : scene_.points) {
      nvm += Text(point.position.transpose(), " ") + "1 2 3 2 0 5 -0.5 1 1 6 0.25 0.5 \n";
    }
    return nvm + "\n0\n";
  };
  WriteFile("tiny.nvm", text("NVM_V3 "));
  EXPECT_EQ(FormatOf(Folder() / "tiny.nvm"), "NVM");
  const Scene original = scene_;
  for (View& view : scene_.views) view.name = "images/" + view.name;
  ExpectScene(LoadScene({Folder() / "tiny.nvm", {}, {}}), true);
  scene_ = original;
  WriteFile("tiny.nvm", text("NVM_V3 FixedK 5 2.5 5.25 1.25 0"));
  const Scene fixed = LoadScene({Folder() / "tiny.nvm", {}, {}});
  EXPECT_EQ(fixed.views[1].camera.fy, 5.25);
  EXPECT_EQ(fixed.views[1].camera.cx, 3);
  EXPECT_EQ(fixed.views[1].camera.cy, 1.75);
  WriteFile("tiny.nvm", text("NVM_V2"));
  EXPECT_THAT(ErrorOf(Folder() / "tiny.nvm"),
              HasSubstr("tiny.nvm: line 1: header: must be NVM_V3"));
}

nlohmann::json OpenMvgScene(const Scene& scene) {
  nlohmann::json root = {{"sfm_data_version", "0.3"}, {"root_path", "images"}};
  for (uint32_t v = 0; v < scene.views.size(); ++v) {
    const Camera& c = scene.views[v].camera;
    root["views"].push_back({{"key", 10 + v},
                             {"value",
                              {{"polymorphic_id", 1073741824},
                               {"ptr_wrapper",
                                {{"id", 2147483649U + v},
                                 {"data",
                                  {{"local_path", ""},
                                   {"filename", scene.views[v].name},
                                   {"width", 6},
                                   {"height", 4},
                                   {"id_view", 10 + v},
                                   {"id_intrinsic", v},
                                   {"id_pose", v}}}}}}}});
    nlohmann::json type = {{"polymorphic_id", v == 0 ? 2147483649U : 1U}};
    if (v == 0) type["polymorphic_name"] = "pinhole";
    type["ptr_wrapper"] = {{"id", 2147483650U},
                           {"data",
                            {{"width", 6},
                             {"height", 4},
                             {"focal_length", c.fx},
                             {"principal_point", {c.cx - 0.5, c.cy - 0.5}}}}};
    root["intrinsics"].push_back({{"key", v}, {"value", type}});
    nlohmann::json rotation;
    for (int r = 0; r < 3; ++r) {
      rotation.push_back({c.rotation(r, 0), c.rotation(r, 1), c.rotation(r, 2)});
    }
    const Eigen::Vector3d center = c.Center();
    root["extrinsics"].push_back(
        {{"key", v},
         {"value", {{"rotation", rotation}, {"center", {center.x(), center.y(), center.z()}}}}});
  }
  for (size_t p = 0; p < scene.points.size(); ++p) {
    const Eigen::Vector3d& x = scene.points[p].position;
    root["structure"].push_back(
        {{"key", p},
         {"value",
          {{"X", {x.x(), x.y(), x.z()}},
           {"observations",
            {{{"key", 10}, {"value", {{"id_feat", 3}, {"x", {1, 2}}}}},
             {{"key", 11}, {"value", {{"id_feat", 4}, {"x", {1, 2}}}}}}}}}});
  }
  return root;
}

TEST_F(Formats, OpenMvg) {
  for (View& view : scene_.views) view.camera.fy = view.camera.fx;
  nlohmann::json root = OpenMvgScene(scene_);
  WriteFile("sfm_data.json", root.dump());
  EXPECT_EQ(FormatOf(Folder() / "sfm_data.json"), "openMVG");
  ExpectScene(LoadScene({Folder() / "sfm_data.json", {}, {}}), true);
  root["intrinsics"][0]["value"]["polymorphic_name"] = "pinhole_brown_t2";
  for (int v = 0; v < 2; ++v) {
    root["intrinsics"][v]["value"]["ptr_wrapper"]["data"]["disto_t2"] = {0.1, 0.2, 0.3, 0.4, 0.5};
  }
  WriteFile("sfm_data.json", root.dump());
  const PosedScene lens = ReadScene({Folder() / "sfm_data.json", {}, {}});
  EXPECT_EQ(lens.images[1].lens.brown, (std::array<double, 5>{0.1, 0.2, 0.4, 0.5, 0.3}));
  nlohmann::json& width = root["intrinsics"][0]["value"]["ptr_wrapper"]["data"]["width"];
  for (const nlohmann::json& wrong : {nlohmann::json(4294967302), nlohmann::json(6.5)}) {
    width = wrong;  // not 6
    WriteFile("sfm_data.json", root.dump());
    EXPECT_THAT(ErrorOf(Folder() / "sfm_data.json"), HasSubstr("is not a whole number in range"));
  }
  width = 6;
  root["intrinsics"][0]["value"]["polymorphic_name"] = "fisheye";
  WriteFile("sfm_data.json", root.dump());
  EXPECT_THAT(ErrorOf(Folder() / "sfm_data.json"),
              HasSubstr("intrinsics of type 'fisheye' are not"));
  root["views"][0]["value"].erase("ptr_wrapper");
  WriteFile("sfm_data.json", root.dump());
  EXPECT_THAT(ErrorOf(Folder() / "sfm_data.json"), HasSubstr("is not as openMVG writes it"));
  WriteFile("sfm_data.json", "{\"a\": \n]");
  EXPECT_THAT(ErrorOf(Folder() / "sfm_data.json"), HasSubstr("byte 8: not valid JSON"));
}

TEST_F(Formats, OpenMvsRoundTrip) {
  const fs::path path = Folder() / "tiny.mvs";
  WriteOpenMvs(scene_, path);
  EXPECT_EQ(FormatOf(path), "OpenMVS");
  ExpectScene(LoadScene({path, {}, {}}), true, 1e-6);
  ExpectScene(LoadScene({path, Images(), {}}), true, 1e-6);
  const std::string bytes = ReadFileBytes(path);
  // What is read of it ends with the points; every shorter file is refused.
  for (size_t size = 0; size < bytes.size() - 5 * 8 - 16 * 8 - 15 * 8; ++size) {
    WriteBytes(path, bytes.substr(0, size));
    EXPECT_THAT(ErrorOf(path), HasSubstr("tiny.mvs: ")) << size;
  }
  // A camera for a photograph turned by a quarter.
  std::string turned = bytes;
  const size_t width_at = 12 + 8 + (8 + 5) + 8 + (8 + 7) + 8;
  std::swap(turned[width_at], turned[width_at + 4]);
  WriteBytes(path, turned);
  EXPECT_THAT(ErrorOf(path), HasSubstr("image size: is 6 x 4 but its camera is 4 x 6"));
  // A count larger than the file.
  std::string huge = bytes;
  huge[12 + 7] = 0x7f;
  WriteBytes(path, huge);
  EXPECT_THAT(ErrorOf(path), HasSubstr("platforms: 91"));
  WriteBytes(path, std::string("MVS\0", 4) + bytes.substr(4));
  EXPECT_THAT(ErrorOf(path), HasSubstr("is an OpenMVS project"));
}

// K divided by the larger side, a camera turned and moved on its platform.
TEST_F(Formats, OpenMvsNormalisedCamerasOnAPlatform) {
  const fs::path path = Folder() / "tiny.mvs";
  Scene turned = scene_;
  WriteOpenMvs(turned, path);
  std::string bytes = ReadFileBytes(path);
  const Eigen::Matrix3d mount =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.2, 1, -0.5).normalized()).matrix();
  const Eigen::Vector3d offset(0.1, -0.2, 0.3);
  const size_t first_camera = 12 + 8 + (8 + 5) + 8;
  const size_t camera_bytes = (8 + 7) + 8 + 8 + 21 * 8;
  const size_t first_pose = first_camera + 2 * camera_bytes + 8;
  const auto put = [&](size_t at, double value) {
    std::memcpy(bytes.data() + at, &value, sizeof(value));
  };
  for (int v = 0; v < 2; ++v) {
    const size_t size = first_camera + v * camera_bytes + 8 + 7 + 8;
    std::memset(bytes.data() + size, 0, 8);
    const Eigen::Matrix3d k = Intrinsics(CameraAt(v), 0);
    for (int n = 0; n < 9; ++n) {
      put(size + 8 + 8 * n, n < 6 ? k(n / 3, n % 3) / 6 : k(n / 3, n % 3));
      put(size + 8 + 72 + 8 * n, mount(n / 3, n % 3));
    }
    for (int n = 0; n < 3; ++n) put(size + 8 + 144 + 8 * n, offset[n]);
    // R = mount R_p, C = C_p + R_p^T offset.
    const Eigen::Matrix3d platform = mount.transpose() * CameraAt(v).rotation;
    const Eigen::Vector3d center = CameraAt(v).Center() - platform.transpose() * offset;
    for (int n = 0; n < 9; ++n) put(first_pose + 96 * v + 8 * n, platform(n / 3, n % 3));
    for (int n = 0; n < 3; ++n) put(first_pose + 96 * v + 72 + 8 * n, center[n]);
  }
  WriteBytes(path, bytes);
  ExpectScene(LoadScene({path, {}, {}}), true, 1e-6);
}

// Real files; skipped where they are not.
fs::path SharedData(const std::string& name) {
  const char* folder = std::getenv("BURIN_SHARED_DATA");
  return folder == nullptr ? fs::path() : fs::path(folder) / name;
}

// Nearly all points lie in the pictures that observe them (undistortion cuts some off).
void ExpectSceneLoads(const std::string& name, size_t views, size_t points) {
  const fs::path path = SharedData(name);
  if (path.empty() || !fs::exists(path)) GTEST_SKIP() << "BURIN_SHARED_DATA has no " << name;
  const Scene scene = LoadScene({path, {}, {}});
  EXPECT_EQ(scene.views.size(), views);
  EXPECT_EQ(scene.points.size(), points);
  size_t inside = 0;
  size_t all = 0;
  for (const ScenePoint& point : scene.points) {
    for (const int v : point.views) {
      EXPECT_GT(scene.views[v].camera.Depth(point.position), 0);
      const Eigen::Vector2d at = scene.views[v].camera.Project(point.position);
      ++all;
      if (scene.views[v].camera.Contains(at)) ++inside;
    }
  }
  EXPECT_GE(static_cast<double>(inside), 0.97 * static_cast<double>(all));
}

TEST(RealFormats, OpenMvs) { ExpectSceneLoads("openmvs-small/scene.mvs", 4, 2663); }
TEST(RealFormats, Temple) { ExpectSceneLoads("temple-sparse-ring", 16, 0); }
TEST(RealFormats, Dino) { ExpectSceneLoads("dino-sparse-ring", 16, 0); }

// The same photographs as COLMAP and as Strecha have them.
TEST(RealFormats, FountainAsStrechaIsFountainAsColmap) {
  const fs::path fountain = SharedData("fountain-p11");
  if (fountain.empty() || !fs::exists(fountain)) {
    GTEST_SKIP() << "BURIN_SHARED_DATA has no fountain-p11";
  }
  const Scene colmap = LoadScene({fountain / "full", {}, {}});
  const Scene strecha = LoadScene({fountain / "strecha-cameras", fountain / "full/images", {}});
  ASSERT_EQ(strecha.views.size(), colmap.views.size());
  double worst = 0;
  for (const ScenePoint& point : colmap.points) {
    for (const int v : point.views) {
      worst = std::max(worst, (strecha.views[v].camera.Project(point.position) -
                               colmap.views[v].camera.Project(point.position))
                                  .norm());
    }
  }
  RecordProperty("worst_px", std::to_string(worst));
  EXPECT_LT(worst, 0.01);
}

}  // namespace
}  // namespace burin
