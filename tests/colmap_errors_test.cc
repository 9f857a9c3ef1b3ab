// Everything that can be wrong with a workspace is one line that names file and field.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <opencv2/imgcodecs.hpp>

#include "core/image/gray_image.h"
#include "tests/colmap_testing.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

// A workspace with a text model that loads, for each test to break.
class ColmapErrors : public testing::Test {
 protected:
  ColmapErrors() {
    WriteColmapScene(TinyScene(), folder_.path(), false);
    WriteText("cameras.txt", "1 PINHOLE 6 4 5 5 3 2\n2 RADIAL 6 4 5 3 2 0 0\n");
    WriteText("images.txt",
              "1 1 0 0 0 0 0 9 1 view0.png\n1 1 1\n2 1 0 0 0 1 0 9 2 view1.png\n1 1 1\n");
    WriteText("points3D.txt", "1 0 0 0 9 9 9 0 1 0 2 0\n");
  }

  fs::path Sparse(const std::string& file) const { return folder_.path() / "sparse" / file; }
  fs::path Image(const std::string& file) const { return folder_.path() / "images" / file; }
  void WriteText(const std::string& file, const std::string& text) const {
    WriteBytes(Sparse(file), text);
  }

  // Replaces the first `from` in a model file, and returns the error of loading that.
  std::string ErrorWith(const std::string& file, const std::string& from,
                        const std::string& to) const {
    const std::string original = ReadFileBytes(Sparse(file));
    std::string text = original;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    WriteText(file, text.replace(at, from.size(), to));
    const std::string error = LoadError(folder_.path());
    WriteText(file, original);
    return error;
  }

  TempFolder folder_;
};

TEST_F(ColmapErrors, TheUnbrokenWorkspaceLoads) {
  EXPECT_EQ(LoadError(folder_.path()), "no error");
}

TEST_F(ColmapErrors, CamerasInOnePlace) {
  // Turned on the spot: t = -R c.
  EXPECT_THAT(ErrorWith("images.txt", "2 1 0 0 0 1 0 9 2", "2 0 0 0 1 0 0 9 2"),
              AllOf(HasSubstr("images.txt: all 2 cameras have the same centre")));
  EXPECT_THAT(ErrorWith("images.txt", "2 1 0 0 0 1 0 9 2", "2 0 0 0 0 1 0 9 2"),
              HasSubstr("cannot be normalised to a rotation"));
}

TEST_F(ColmapErrors, MissingFolders) {
  const fs::path nowhere = folder_.path() / "nowhere";
  EXPECT_EQ(LoadError(nowhere), nowhere.string() + ": no such file or folder");
  EXPECT_THAT(LoadError(Sparse("images.txt")),
              StartsWith(Sparse("images.txt").string() + ": is no scene that burin knows: COLMAP"));
  fs::rename(folder_.path() / "sparse", folder_.path() / "s");
  EXPECT_THAT(LoadError(folder_.path()),
              AllOf(StartsWith(folder_.path().string() + ": is no scene"), HasSubstr("sparse/")));
  fs::create_directory(folder_.path() / "sparse");
  EXPECT_THAT(LoadError(folder_.path()), HasSubstr("sparse: no model: cameras, images and"));
  fs::remove(folder_.path() / "sparse");
  fs::rename(folder_.path() / "s", folder_.path() / "sparse");
  fs::rename(folder_.path() / "images", folder_.path() / "i");
  EXPECT_EQ(LoadError(folder_.path()),
            (folder_.path() / "images").string() + ": folder is missing");
}

TEST_F(ColmapErrors, MissingModelFiles) {
  for (const char* file : {"cameras.txt", "images.txt", "points3D.txt"}) {
    fs::rename(Sparse(file), Sparse("away"));
    const bool needed = std::string(file) != "points3D.txt";
    EXPECT_EQ(LoadError(folder_.path()),
              needed ? Sparse(file).string() + ": file is missing" : "no error");
    fs::create_directory(Sparse(file));
    EXPECT_EQ(LoadError(folder_.path()), Sparse(file).string() + ": is not a file");
    fs::remove(Sparse(file));
    fs::rename(Sparse("away"), Sparse(file));
  }
}

TEST_F(ColmapErrors, MalformedTextNamesLineAndField) {
  const std::string cameras = Sparse("cameras.txt").string();
  const std::string images = Sparse("images.txt").string();
  const std::string points = Sparse("points3D.txt").string();
  EXPECT_EQ(ErrorWith("cameras.txt", "6 4 5 5 3 2", "6 4 5 5 3"),
            cameras + ": line 1: PARAMS: is missing");
  EXPECT_EQ(ErrorWith("cameras.txt", "6 4 5 5 3 2", "6 4 5 5 3 2 1"),
            cameras + ": line 1: end of line: '1' follows the last field");
  EXPECT_EQ(ErrorWith("cameras.txt", "2 RADIAL 6", "2 RADIAL 6.5"),
            cameras + ": line 2: WIDTH: '6.5' is not an integer in range");
  EXPECT_EQ(ErrorWith("cameras.txt", "2 RADIAL 6", "2 RADIAL -6"),
            cameras + ": line 2: WIDTH: '-6' is not an integer in range");
  EXPECT_EQ(ErrorWith("images.txt", "1 0 0 0 0 0 9", "1 0 x 0 0 0 9"),
            images + ": line 1: QY: 'x' is not a number");
  EXPECT_EQ(ErrorWith("images.txt", " view1.png", ""), images + ": line 3: NAME: is missing");
  EXPECT_EQ(ErrorWith("images.txt", "1 1 1\n2", "1 1\n2"),
            images + ": line 2: POINTS2D POINT3D_ID: is missing");
  // Lines of observations left out: the next image is taken for one and found not to be.
  EXPECT_THAT(ErrorWith("images.txt", "1 1 1\n2", "2"), StartsWith(images + ": line 2: POINTS2D"));
  EXPECT_EQ(ErrorWith("points3D.txt", "9 9 9 0 1 0", "9 9 256 0 1 0"),
            points + ": line 1: B: '256' is not an integer in range");
  EXPECT_EQ(ErrorWith("points3D.txt", "2 0\n", "2"),
            points + ": line 1: TRACK POINT2D_IDX: is missing");
  EXPECT_EQ(ErrorWith("points3D.txt", "1 0 0 0", "1 0 1e999 0"),
            points + ": line 1: Y: '1e999' is not a number");
}

TEST_F(ColmapErrors, UnsupportedCameraModels) {
  EXPECT_THAT(ErrorWith("cameras.txt", "2 RADIAL 6 4 5 3 2 0 0", "2 OPENCV_FISHEYE 6 4 5"),
              AllOf(StartsWith(Sparse("cameras.txt").string() + ": camera 2: "),
                    HasSubstr("MODEL = OPENCV_FISHEYE: not supported"),
                    HasSubstr("SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV")));
  WriteColmapScene(TinyScene(), folder_.path(), true);
  const std::string cameras = ReadFileBytes(Sparse("cameras.bin"));
  const std::pair<int, std::string> models[] = {{6, "FULL_OPENCV"}, {7, "FOV"}, {99, "number 99"}};
  for (const auto& [number, name] : models) {
    std::string changed = cameras;
    changed[12] = static_cast<char>(number);  // after the count and the first CAMERA_ID
    WriteBytes(Sparse("cameras.bin"), changed);
    EXPECT_THAT(LoadError(folder_.path()), HasSubstr("camera 1: MODEL = " + name + ": not supp"));
  }
}

TEST_F(ColmapErrors, ImpossibleCameras) {
  const auto with = [&](const std::string& line) {
    return ErrorWith("cameras.txt", "1 PINHOLE 6 4 5 5 3 2", line);
  };
  EXPECT_THAT(with("1 PINHOLE 6 4 5 0 3 2"), HasSubstr("camera 1: focal length = 0.000000: must"));
  EXPECT_THAT(with("1 PINHOLE 6 4 -5 5 3 2"), HasSubstr("focal length = -5.000000: must"));
  EXPECT_THAT(with("1 PINHOLE 6 4 inf 5 3 2"), HasSubstr("line 1: PARAMS: 'inf' is not finite"));
  EXPECT_THAT(with("1 PINHOLE 0 4 5 5 3 2"), HasSubstr("camera 1: WIDTH = 0: must be between 1"));
  EXPECT_THAT(with("1 PINHOLE 6 4000000000 5 5 3 2"), HasSubstr("HEIGHT = 4000000000: must be"));
  EXPECT_THAT(with("2 PINHOLE 6 4 5 5 3 2"), HasSubstr("camera 2: CAMERA_ID appears twice"));
}

TEST_F(ColmapErrors, NonFiniteNumbersInBinaryFiles) {
  WriteColmapScene(TinyScene(), folder_.path(), true);
  const auto error_with_nan = [&](const std::string& file, std::size_t at) {
    const std::string original = ReadFileBytes(Sparse(file));
    WriteBytes(Sparse(file), std::string(original).replace(at, 8, 8, '\xff'));
    const std::string error = LoadError(folder_.path());
    WriteBytes(Sparse(file), original);
    return error;
  };
  const std::size_t camera = 8 + 4 + 4 + 8 + 8;  // parameters of the first camera
  EXPECT_THAT(error_with_nan("cameras.bin", camera), HasSubstr("camera 1: focal length = "));
  EXPECT_THAT(error_with_nan("cameras.bin", camera + 16), HasSubstr("camera 1: principal point"));
  EXPECT_THAT(error_with_nan("images.bin", 12), HasSubstr("image 1: QW, QX, QY, QZ: length"));
  EXPECT_THAT(error_with_nan("images.bin", 12 + 32), HasSubstr("image 1: TX, TY, TZ: must be"));
  EXPECT_EQ(error_with_nan("points3D.bin", 16), "no error");  // one point less
}

TEST_F(ColmapErrors, ImpossibleImages) {
  const std::string images = Sparse("images.txt").string();
  EXPECT_THAT(ErrorWith("images.txt", "1 0 0 0 0 0 9", "0 0 0 0 0 0 9"),
              HasSubstr("image 1: QW, QX, QY, QZ: length 0.000000 cannot be normalised"));
  EXPECT_EQ(ErrorWith("images.txt", "9 2 view1", "9 3 view1"),
            images + ": image 2: CAMERA_ID = 3: no such camera in cameras.txt");
  EXPECT_EQ(ErrorWith("images.txt", "view1.png", "view0.png"),
            images + ": image 2: NAME = view0.png: appears twice");
  EXPECT_EQ(ErrorWith("images.txt", "2 1 0 0 0 1", "1 1 0 0 0 1"),
            images + ": image 1: IMAGE_ID appears twice");
  EXPECT_THAT(ErrorWith("images.txt", "view1.png", "vi\x01w.png"),
              HasSubstr("image 2: NAME: contains the control character 1"));
  EXPECT_EQ(ErrorWith("images.txt", "2 1 0 0 0 1 0 9 2 view1.png\n1 1 1\n", ""),
            images + ": has 1 image(s): at least 2 are needed");
}

TEST_F(ColmapErrors, ImpossiblePoints) {
  const std::string points = Sparse("points3D.txt").string();
  EXPECT_EQ(ErrorWith("points3D.txt", "2 0\n", "2 0\n1 0 0 0 0 0 0 0\n"),
            points + ": point 1: POINT3D_ID appears twice");
}

TEST_F(ColmapErrors, BadImageFiles) {
  EXPECT_EQ(ErrorWith("images.txt", "view1.png", "none.png"),
            Image("none.png").string() +
                ": file is missing; --skip-views 'none.png' leaves its view out, --images DIR says "
                "where photographs are");
  WriteBytes(Image("view1.png"), "no image");
  EXPECT_EQ(LoadError(folder_.path()), Image("view1.png").string() + ": image: cannot be decoded");
  WriteBytes(Image("view1.png"), "");
  EXPECT_EQ(LoadError(folder_.path()), Image("view1.png").string() + ": image: the file is empty");
  cv::imwrite(Image("view1.png").string(), cv::Mat(6, 4, CV_8UC1, cv::Scalar(1)));
  EXPECT_THAT(LoadError(folder_.path()),
              AllOf(StartsWith(Image("view1.png").string() +
                               ": image size: is 4 x 6 but camera 2 is 6 x 4"),
                    HasSubstr("EXIF")));
  // Of several the first by name is reported, whichever thread is faster.
  WriteBytes(Image("view0.png"), "no image");
  EXPECT_THAT(LoadError(folder_.path()), StartsWith(Image("view0.png").string()));
}

// Decoders return the upper part of a truncated JPEG as if nothing was wrong.
TEST_F(ColmapErrors, TruncatedImagesAtEveryLength) {
  cv::Mat image(40, 56, CV_8UC1);
  for (int i = 0; i < 40 * 56; ++i) image.data[i] = static_cast<unsigned char>(i * i / 7);
  for (const std::string name : {"a.png", "a.jpg"}) {
    WriteGrayImage(image, Image(name));
    const std::string bytes = ReadFileBytes(Image(name));
    EXPECT_EQ(ReadGrayImage(Image(name)).size(), image.size());
    EXPECT_NO_THROW(WriteBytes(Image(name), bytes + "trailer"); ReadGrayImage(Image(name)));
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      WriteBytes(Image(name), bytes.substr(0, length));
      EXPECT_THROW(ReadGrayImage(Image(name)), InputError) << name << " " << length;
    }
  }
  // Progressive: several scans with tables between them.
  cv::imwrite(Image("p.jpg").string(), image, {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  const std::string bytes = ReadFileBytes(Image("p.jpg"));
  EXPECT_EQ(ReadGrayImage(Image("p.jpg")).size(), image.size());
  WriteBytes(Image("p.jpg"), bytes.substr(0, bytes.size() - 2));
  EXPECT_THROW(ReadGrayImage(Image("p.jpg")), InputError);
}

TEST_F(ColmapErrors, EveryPrefixOfABinaryModelIsAnError) {
  WriteColmapScene(TinyScene(), folder_.path(), true);
  for (const char* file : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const std::string bytes = ReadFileBytes(Sparse(file));
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      WriteBytes(Sparse(file), bytes.substr(0, length));
      EXPECT_THAT(LoadError(folder_.path()), StartsWith(Sparse(file).string() + ": "))
          << "prefix of " << length;
    }
    WriteBytes(Sparse(file), bytes + '\0');
    EXPECT_THAT(LoadError(folder_.path()), HasSubstr("1 bytes follow the last element"));
    WriteBytes(Sparse(file), bytes);
    EXPECT_EQ(LoadError(folder_.path()), "no error");
  }
}

// A text model cut anywhere either misses something or still is a model; it never crashes.
TEST_F(ColmapErrors, EveryPrefixOfATextModelIsHandled) {
  for (const char* file : {"cameras.txt", "images.txt", "points3D.txt"}) {
    const std::string text = ReadFileBytes(Sparse(file));
    int errors = 0;
    for (std::size_t length = 0; length < text.size(); ++length) {
      WriteText(file, text.substr(0, length));
      errors += LoadError(folder_.path()) != "no error";
    }
    EXPECT_GT(errors, static_cast<int>(text.size()) / 3);
    WriteText(file, text);
  }
}

// Counts of 10^19 elements among them: an InputError, or a model, but no crash and no bad_alloc.
TEST_F(ColmapErrors, EveryChangedByteOfABinaryModelIsHandled) {
  WriteColmapScene(TinyScene(), folder_.path(), true);
  for (const char* file : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const std::string bytes = ReadFileBytes(Sparse(file));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      for (const char changed : {'\xff', '\0', static_cast<char>(bytes[i] ^ 1)}) {
        std::string copy = bytes;
        copy[i] = changed;
        WriteBytes(Sparse(file), copy);
        LoadError(folder_.path());
      }
    }
    WriteBytes(Sparse(file), bytes);
  }
}

TEST_F(ColmapErrors, ScenesThatCannotBeWritten) {
  const fs::path target = folder_.path() / "written";
  const auto error_with = [&](const std::function<void(Scene*)>& change) -> std::string {
    Scene scene = TinyScene();
    change(&scene);
    try {
      WriteColmapScene(scene, target, true);
    } catch (const InputError& error) {
      EXPECT_FALSE(fs::exists(target)) << "something was written before " << error.what();
      return error.what();
    }
    fs::remove_all(target);
    return "no error";
  };
  EXPECT_THAT(error_with([](Scene* s) { s->views[1].name = s->views[0].name; }),
              HasSubstr("view name 'view0.png': appears twice"));
  for (const std::string name : {"../a.png", "/a.png", "a/../../b.png", "", "a/"}) {
    EXPECT_THAT(error_with([&](Scene* s) { s->views[1].name = name; }),
                HasSubstr("view name '" + name + "': must be a path inside this folder"));
  }
  EXPECT_THAT(error_with([](Scene* s) { s->views[1].name = "a.gif"; }),
              HasSubstr("a.gif: extension: must be .png, .jpg or .jpeg"));
  EXPECT_THAT(error_with([](Scene* s) { s->views[1].name = "a\n.png"; }),
              HasSubstr("control character 10"));
  EXPECT_THAT(error_with([](Scene* s) { s->views[1].gray = cv::Mat(); }),
              HasSubstr("of the camera's size, 6 x 4"));
  EXPECT_THAT(error_with([](Scene* s) { s->views.pop_back(); }), HasSubstr("does not exist"));
  EXPECT_THAT(error_with([](Scene* s) {
                s->views[1].camera.rotation.setIdentity();
                s->points[1].position = -s->views[1].camera.translation;
              }),
              HasSubstr("point 2: has no projection in view1.png"));
  EXPECT_THAT(error_with([](Scene* s) { s->views[0].camera.fx = 0; }), HasSubstr("focal length"));
  EXPECT_EQ(error_with([](Scene*) {}), "no error");
  WriteBytes(target, "a file in the way");
  EXPECT_THROW(WriteColmapScene(TinyScene(), target, true), InputError);
}

}  // namespace
}  // namespace burin
