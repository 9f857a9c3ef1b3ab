#include "core/mesh/point_cloud_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include "core/support/error.h"

namespace burin {
namespace {

std::filesystem::path TestPath(const std::string& name) {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  return std::filesystem::path(testing::TempDir()) /
         ("burin_cloud_" + std::string(info->name()) + "_" + name);
}

std::filesystem::path WriteText(const std::string& name, const std::string& text) {
  const std::filesystem::path path = TestPath(name);
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::string ErrorOf(const std::filesystem::path& path) {
  try {
    ReadPointCloud(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

template <typename T>
void Append(std::string* bytes, T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes->append(raw, sizeof(T));
}

TEST(PointCloudIo, ComesBackAsWritten) {
  PointCloud cloud;
  cloud.points = {{1, 2, 3}, {-0.5, 0.25, 1e6}, {0, 0, 0}};
  cloud.normals = {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}};
  WritePointCloud(TestPath("a.ply"), cloud);
  const PointCloud read = ReadPointCloud(TestPath("a.ply"));
  EXPECT_EQ(read.points, cloud.points);
  EXPECT_EQ(read.normals, cloud.normals);

  cloud.normals.clear();
  WritePointCloud(TestPath("b.ply"), cloud);
  EXPECT_EQ(ReadPointCloud(TestPath("b.ply")).points, cloud.points);
  EXPECT_TRUE(ReadPointCloud(TestPath("b.ply")).normals.empty());
}

TEST(PointCloudIo, AsciiWithWindowsLineEndsAndForeignProperties) {
  const auto path = WriteText("a.ply",
                              "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\n"
                              "element camera 2\r\nproperty list uchar float view\r\n"
                              "element vertex 2\r\nproperty uchar red\r\nproperty double z\r\n"
                              "property float y\r\nproperty float x\r\nproperty float nx\r\n"
                              "element face 1\r\nproperty list uchar int vertex_indices\r\n"
                              "end_header\r\n0\r\n2 5 6\r\n255 3 2 1e0 0\r\n0 -6 5 +4 0\r\n"
                              "3 0 1 0\r\n");
  const PointCloud cloud = ReadPointCloud(path);
  EXPECT_THAT(cloud.points,
              testing::ElementsAre(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(4, 5, -6)));
  EXPECT_TRUE(cloud.normals.empty());
}

TEST(PointCloudIo, BinaryOfBothByteOrdersSkipsListsBeforeTheVertices) {
  for (const bool big_endian : {false, true}) {
    std::string bytes = "ply\nformat binary_";
    bytes += big_endian ? "big" : "little";
    bytes +=
        "_endian 1.0\nelement strip 1\nproperty list ushort int index\nelement vertex 1\n"
        "property short y\nproperty double x\nproperty uchar skipped\nproperty float z\n"
        "end_header\n";
    Append<std::uint16_t>(&bytes, 2, big_endian);
    Append<std::int32_t>(&bytes, 70000, big_endian);
    Append<std::int32_t>(&bytes, 9, big_endian);
    Append<std::int16_t>(&bytes, -300, big_endian);
    Append<double>(&bytes, 0.1, big_endian);
    bytes.push_back('\n');
    Append<float>(&bytes, 2.5F, big_endian);
    const PointCloud cloud = ReadPointCloud(WriteText("a.ply", bytes));
    EXPECT_THAT(cloud.points, testing::ElementsAre(Eigen::Vector3d(0.1, -300, 2.5)));
  }
}

TEST(PointCloudIo, BadFilesAreErrorsThatNameTheField) {
  using testing::HasSubstr;
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string ascii = "ply\nformat ascii 1.0\n";
  const std::string binary = "ply\nformat binary_little_endian 1.0\n";
  EXPECT_THAT(ErrorOf(TestPath("absent.ply")), HasSubstr("absent.ply: no such file"));
  EXPECT_THAT(ErrorOf(testing::TempDir()), HasSubstr("no such file"));
  EXPECT_THAT(ErrorOf(WriteText("a", "")), HasSubstr("ends before end_header"));
  EXPECT_THAT(ErrorOf(WriteText("b", "solid cube\n")), HasSubstr("not a PLY file"));
  EXPECT_THAT(ErrorOf(WriteText("c", std::string(100000, 'x'))), HasSubstr("longer than"));
  EXPECT_THAT(ErrorOf(WriteText("d", ascii + "element vertex -1\n")), HasSubstr("count \"-1\""));
  EXPECT_THAT(ErrorOf(WriteText("e", ascii + "end_header\n")), HasSubstr("element vertex"));
  EXPECT_THAT(
      ErrorOf(WriteText("f", ascii + "element vertex 1\nproperty float x\nend_header\n1\n")),
      HasSubstr("property y missing"));
  EXPECT_THAT(ErrorOf(WriteText("g", ascii + "element vertex 1\n" + xyz + "end_header\n1 b 2\n")),
              HasSubstr("vertex 0: cut off or not a number"));
  EXPECT_THAT(
      ErrorOf(WriteText("h", ascii + "element vertex 2\n" + xyz + "end_header\n1 2 3\n4 nan 6\n")),
      HasSubstr("vertex 1: not finite"));
  // A count that would take the machine's memory, and one that overflows 64 bits when multiplied.
  EXPECT_THAT(
      ErrorOf(WriteText("i", binary + "element vertex 4000000000\n" + xyz + "end_header\n")),
      HasSubstr("count 4000000000 needs more than the 0 bytes"));
  EXPECT_THAT(ErrorOf(WriteText(
                  "j", binary + "element vertex 18446744073709551615\n" + xyz + "end_header\nabc")),
              HasSubstr("needs more than the 3 bytes"));
  EXPECT_THAT(ErrorOf(WriteText("k", binary + "element vertex 1\nproperty quad x\nend_header\n")),
              HasSubstr("property: cannot be understood"));
  EXPECT_THAT(ErrorOf(WriteText("l", "ply\nelement vertex 0\n" + xyz + "end_header\n")),
              HasSubstr("format: missing"));
  EXPECT_THAT(ErrorOf(WriteText("m", "ply\nformat binary 1.0\n")), HasSubstr("format: \"binary\""));
}

TEST(PointCloudIo, EveryTruncationIsAnError) {
  PointCloud cloud;
  cloud.points = {{1, 2, 3}, {4, 5, 6}};
  cloud.normals = {{0, 0, 1}, {0, 0, 1}};
  WritePointCloud(TestPath("whole.ply"), cloud);
  std::ifstream file(TestPath("whole.ply"), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  for (size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_NE(ErrorOf(WriteText("cut.ply", bytes.substr(0, length))), "no error") << length;
  }
}

TEST(PointCloudIo, NothingIsLeftWhenTheFolderIsMissing) {
  EXPECT_THROW(WritePointCloud(TestPath("no_folder") / "a.ply", PointCloud()), InputError);
}

}  // namespace
}  // namespace burin
