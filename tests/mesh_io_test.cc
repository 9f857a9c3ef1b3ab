// GCC 12 takes the default value of an OpenMesh property for uninitialised once it is inlined.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"

#include "core/mesh/mesh_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <cstring>
#include <fstream>
#include <functional>

#include "core/support/error.h"

namespace burin {
namespace {

using testing::HasSubstr;

class MeshIo : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path Write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }

  // What ReadMesh says about a file with this content; "" when it takes it.
  std::string ErrorOf(const std::string& name, const std::string& content) const {
    const std::filesystem::path path = Write(name, content);
    try {
      ReadMesh(path);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path.string() + ": "));
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

// A pyramid over a quad at UTM coordinates: float would move its corners by up to a quarter metre.
TriangleMesh Pyramid() {
  TriangleMesh mesh;
  mesh.vertices = {{500000.123, 5400000.456, 101.1},
                   {500001.123, 5400000.456, 101.2},
                   {500001.123, 5400001.456, 101.3},
                   {500000.123, 5400001.456, 101.4},
                   {500000.623, 5400000.956, 1.0 / 3}};
  mesh.faces = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {0, 2, 1}, {0, 3, 2}};
  return mesh;
}

void ExpectSame(const TriangleMesh& a, const TriangleMesh& b) {
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  ASSERT_EQ(a.faces.size(), b.faces.size());
  for (size_t v = 0; v < a.vertices.size(); ++v) EXPECT_EQ(a.vertices[v], b.vertices[v]) << v;
  for (size_t f = 0; f < a.faces.size(); ++f) EXPECT_EQ(a.faces[f], b.faces[f]) << f;
}

template <typename T>
void Append(T value, bool big_endian, std::string* bytes) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes->append(raw, sizeof(T));
}

// With what other programs add: normals, colours, a texture list after the indices, an element
// before the faces and one behind them, and other integer types.
std::string RichBinaryPly(const TriangleMesh& mesh, bool big_endian) {
  std::string ply = std::string("ply\r\nformat binary_") + (big_endian ? "big" : "little") +
                    "_endian 1.0\r\ncomment made for a test\r\nobj_info none\r\n" +
                    "element camera 1\r\nproperty list ushort float view\r\nelement vertex " +
                    std::to_string(mesh.vertices.size()) +
                    "\r\nproperty uchar red\r\nproperty double x\r\nproperty float nx\r\n"
                    "property double y\r\nproperty double z\r\nproperty list uchar short tracks\r\n"
                    "element face " +
                    std::to_string(mesh.faces.size()) +
                    "\r\nproperty uchar flags\r\nproperty list uint uint vertex_index\r\n"
                    "property list uchar float texcoord\r\nproperty int texnumber\r\n"
                    "element tail 1\r\nproperty list uchar int values\r\nend_header\r\n";
  const auto put = [&](auto value) { Append(value, big_endian, &ply); };
  put(std::uint16_t{2});
  put(1.0F);
  put(2.0F);
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    put(std::uint8_t{7});
    put(mesh.vertices[v].x());
    put(0.5F);
    put(mesh.vertices[v].y());
    put(mesh.vertices[v].z());
    put(static_cast<std::uint8_t>(v));
    for (size_t t = 0; t < v; ++t) put(std::int16_t{-3});
  }
  for (const Eigen::Vector3i& face : mesh.faces) {
    put(std::uint8_t{1});
    put(std::uint32_t{3});
    for (int c = 0; c < 3; ++c) put(static_cast<std::uint32_t>(face[c]));
    put(std::uint8_t{6});
    for (int t = 0; t < 6; ++t) put(0.25F);
    put(std::int32_t{0});
  }
  put(std::uint8_t{1});
  put(std::int32_t{9});
  return ply;
}

TEST_F(MeshIo, EveryFormatReturnsTheSameBits) {
  const TriangleMesh mesh = Pyramid();
  const std::vector<Eigen::Vector3f> colors(5, Eigen::Vector3f(1, 0.5, 0));
  for (const char* name : {"a.ply", "a.obj", "a.off", "a.PLY"}) {
    for (const auto* with_colors : {static_cast<decltype(&colors)>(nullptr), &colors}) {
      SCOPED_TRACE(name);
      WriteMesh(folder_ / name, mesh, with_colors);
      MeshReport report;
      ExpectSame(ReadMesh(folder_ / name, &report), mesh);
      EXPECT_EQ(report.Brief(), "5 vertices, 6 faces, 1 components, 0 boundary edges");
    }
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 4);  // nothing beside
}

TEST_F(MeshIo, OpenMeshItselfReadsWhatIsWritten) {
  const TriangleMesh mesh = Pyramid();
  const std::vector<Eigen::Vector3f> colors(5, Eigen::Vector3f(1, 0.5, 0));
  for (const char* name : {"a.ply", "a.obj", "a.off"}) {
    SCOPED_TRACE(name);
    WriteMesh(folder_ / name, mesh, &colors);
    OpenMesh::TriMesh_ArrayKernelT<> other;
    ASSERT_TRUE(OpenMesh::IO::read_mesh(other, (folder_ / name).string()));
    ASSERT_EQ(other.n_vertices(), mesh.vertices.size());
    ASSERT_EQ(other.n_faces(), mesh.faces.size());
    for (int v = 0; v < 5; ++v) {
      const auto& point = other.point(OpenMesh::VertexHandle(v));
      for (int c = 0; c < 3; ++c) EXPECT_EQ(point[c], static_cast<float>(mesh.vertices[v][c]));
    }
  }
}

TEST_F(MeshIo, BinaryPlyInBothByteOrdersWithForeignProperties) {
  const TriangleMesh mesh = Pyramid();
  for (bool big_endian : {false, true}) {
    ExpectSame(ReadMesh(Write("a.ply", RichBinaryPly(mesh, big_endian))), mesh);
  }
}

TEST_F(MeshIo, TextFormatsAsOthersWriteThem) {
  const TriangleMesh quad = ReadMesh(Write("a.ply",
                                           "ply\nformat ascii 1.0\nelement vertex 4\n"
                                           "property float x\nproperty float y\nproperty float z\n"
                                           "property list uchar int seen_by\nelement face 1\n"
                                           "property list int int vertex_indices\nend_header\n"
                                           "0 0 0 2 5 6\n1 0 0 0\n1 1 +0 1 7\n0 1e0 0 0\n"
                                           "4 0 1 2 3"));
  MeshReport report;
  ExpectSame(ReadMesh(Write("a.obj",
                            "# a comment\nmtllib missing.mtl\no thing\nv 0 0 0 0.5 0.5 0.5\n"
                            "v 1 0 0\nv 1 1 \\\n 0\nvt 0 0\nvn 0 0 1\nv 0 1 0\nusemtl none\n"
                            "s off\nf 1/1/1 -3//1 3/1 4 # last\n"),
                      &report),
             quad);
  EXPECT_EQ(report.polygon_count, 1);
  EXPECT_EQ(report.face_count, 2);
  EXPECT_EQ(report.boundary_edge_count, 4);
  ExpectSame(ReadMesh(Write("a.off",
                            "COFF # with colours\n\n4 1 0\n0 0 0 255 0 0 255\n1 0 0 0 0 0 0\n"
                            "# between\n1 1 0 1 1 1 1\n0 1 0 2 2 2 2\n4 0 1 2 3 0.1 0.2 0.3\n")),
             quad);
  ExpectSame(ReadMesh(Write("b.off", "OFF 4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3")), quad);
}

TEST_F(MeshIo, NonManifoldFacesAreKeptOthersDroppedAndCounted) {
  // Three sheets on edge 0-1, one of them twice, one flat on a line, one that repeats a vertex.
  MeshReport report;
  const TriangleMesh mesh = ReadMesh(Write("a.off",
                                           "OFF\n7 6 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 -1 0\n"
                                           "2 0 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 1 4\n3 1 4 0\n"
                                           "3 0 1 5\n3 2 2 3\n"),
                                     &report);
  EXPECT_EQ(mesh.faces.size(), 3U);
  EXPECT_EQ(report.face_count, 3);
  EXPECT_EQ(report.nonmanifold_edge_count, 1);
  EXPECT_EQ(report.degenerate_face_count, 2);
  EXPECT_EQ(report.duplicate_face_count, 1);
  EXPECT_EQ(report.duplicate_vertex_count, 1);
  EXPECT_EQ(report.unreferenced_vertex_count, 2);
  EXPECT_EQ(report.component_count, 1);
  EXPECT_THAT(report.Brief(), HasSubstr("2 degenerate faces, 1 duplicate faces"));
}

// Two strips with a row of facets between them that two corners at one place make areas of nothing.
TEST_F(MeshIo, FacesOfNoAreaLeaveNoSlit) {
  MeshReport report;
  const TriangleMesh mesh =
      ReadMesh(Write("a.off",
                     "OFF\n6 4 0\n0 0 0\n1 0 0\n0.5 1 0\n1 0 0\n0 0 0\n0.5 -1 0\n3 0 1 2\n"
                     "3 3 4 5\n3 0 4 1\n3 4 3 1\n"),
               &report);
  EXPECT_EQ(report.face_count, 2);
  EXPECT_EQ(report.degenerate_face_count, 2);
  EXPECT_EQ(report.boundary_edge_count, 4);
  EXPECT_EQ(mesh.vertices.size(), 6U);
}

TEST_F(MeshIo, FacesOfNoAreaOnlyAreRefused) {
  EXPECT_THROW(ReadMesh(Write("a.off", "OFF\n3 1 0\n0 0 0\n1 1 1\n2 2 2\n3 0 1 2\n")), InputError);
}

TEST_F(MeshIo, MinorityOfFlippedFacesIsTurned) {
  TriangleMesh mesh = Pyramid();
  std::swap(mesh.faces[2][0], mesh.faces[2][1]);
  std::swap(mesh.faces[5][1], mesh.faces[5][2]);
  WriteMesh(folder_ / "a.ply", mesh);
  MeshReport report;
  const TriangleMesh turned = ReadMesh(folder_ / "a.ply", &report);
  EXPECT_EQ(report.reoriented_face_count, 2);
  EXPECT_EQ(report.inconsistent_edge_count, 0);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int f = 0; f < 6; ++f) {
    sum += FaceAreaNormal(turned, f);
    EXPECT_GT(FaceAreaNormal(turned, f).dot(FaceAreaNormal(Pyramid(), f)), 0);
  }
  EXPECT_LT(sum.norm(), 1e-6);
}

TEST(MeshCheck, MoebiusStripIsLeftAndReported) {
  TriangleMesh strip;
  const int n = 9;
  for (int i = 0; i < n; ++i) {
    const double turn = 2 * M_PI * i / n;
    for (double side : {-0.3, 0.3}) {
      const double radius = 1 + side * std::cos(turn / 2);
      strip.vertices.emplace_back(radius * std::cos(turn), radius * std::sin(turn),
                                  side * std::sin(turn / 2));
    }
  }
  for (int i = 0; i < n; ++i) {
    const int low = 2 * i, high = 2 * i + 1;
    const int next_low = i + 1 < n ? low + 2 : 1, next_high = i + 1 < n ? high + 2 : 0;
    strip.faces.push_back({low, next_low, high});
    strip.faces.push_back({high, next_low, next_high});
  }
  const TriangleMesh before = strip;
  EXPECT_EQ(OrientConsistently(&strip), 0);
  ExpectSame(strip, before);
  EXPECT_EQ(CheckMesh(strip).inconsistent_edge_count, 1);
  EXPECT_EQ(CheckMesh(strip).nonmanifold_edge_count, 0);
  EXPECT_EQ(CheckMesh(strip).boundary_edge_count, 2 * n);
}

TEST_F(MeshIo, ErrorsNameTheElement) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  EXPECT_EQ(ErrorOf("a.ply", head + "0 0 0 1 0 0 0 1 0 3 0 1 2"), "");
  EXPECT_THAT(ErrorOf("a.ply", ""), HasSubstr("is empty"));
  EXPECT_THAT(ErrorOf("a.stl", "solid"), HasSubstr("extension: '.stl' must be"));
  EXPECT_THAT(ErrorOf("a.ply", "solid\n"), HasSubstr("first line is not 'ply'"));
  EXPECT_THAT(ErrorOf("a.ply", head + "0 0 0 1 nan 0 0 1 0 3 0 1 2"),
              HasSubstr("vertex 1: y is nan"));
  EXPECT_THAT(ErrorOf("a.ply", head + "0 0 0 1 0 0 0 1 -inf 3 0 1 2"),
              HasSubstr("vertex 2: z is -inf"));
  EXPECT_THAT(ErrorOf("a.ply", head + "1e999 0 0 1 0 0 0 1 0 3 0 1 2"),
              HasSubstr("vertex 0: x is inf"));
  EXPECT_THAT(ErrorOf("a.ply", head + "0 0 0 1 0 0 0 1 0 3 0 1 3"),
              HasSubstr("face 0: vertex index 3 must be below the vertex count 3"));
  EXPECT_THAT(ErrorOf("a.ply", head + "0 0 0 1 0 0 0 1 0 3 0 1 -1"), HasSubstr("vertex index -1"));
  EXPECT_THAT(ErrorOf("a.ply", head + "0 0 0 1 0 0 0 1 0 3 0 1 1.5"), HasSubstr("not an integer"));
  EXPECT_THAT(ErrorOf("a.ply", head + "0 0 0 1 0 0 0 1 0 3 0 1 2 3"), HasSubstr("end of file"));
  EXPECT_THAT(ErrorOf("a.ply", head + "0 0 0 1 0 0 0 1 0 3 0 0 2"), HasSubstr("repeats a vertex"));
  EXPECT_THAT(ErrorOf("a.ply", head + "0 0 0 1 0 0 0 1 0 3 0 1"), HasSubstr("face 0: the file is"));
  EXPECT_THAT(ErrorOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n"),
              HasSubstr("vertex 2: y is nan"));
  EXPECT_THAT(ErrorOf("a.obj", "v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n"),
              HasSubstr("line 2: vertex 1: has fewer than three coordinates"));
  EXPECT_THAT(ErrorOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
              HasSubstr("line 4: face 0: vertex number 4 of 3 does not exist"));
  EXPECT_THAT(ErrorOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n"), HasSubstr("number -4"));
  EXPECT_THAT(ErrorOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n"), HasSubstr("'x' must be"));
  EXPECT_THAT(ErrorOf("a.obj", "v 0 0 0\n"), HasSubstr("no faces"));
  EXPECT_THAT(ErrorOf("a.obj", "f 1 2 3\n"), HasSubstr("no vertices"));
  EXPECT_THAT(ErrorOf("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
              HasSubstr("face 0: vertex index 3 must be below"));
  EXPECT_THAT(ErrorOf("a.off", "OFF\n3 1 0\n0 0 0\n1.00000 0 0\n"),
              HasSubstr("vertex 2: the file is"));
  EXPECT_THAT(ErrorOf("a.off", "OFF BINARY\n"), HasSubstr("BINARY is not supported"));
  EXPECT_THAT(ErrorOf("a.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n"), HasSubstr("no faces"));
  EXPECT_THROW(ReadMesh(folder_ / "missing.ply"), InputError);
  EXPECT_THROW(ReadMesh(folder_), InputError);
  std::filesystem::create_directory(folder_ / "folder.ply");
  EXPECT_THROW(ReadMesh(folder_ / "folder.ply"), InputError);
  EXPECT_THROW(WriteMesh(folder_ / "a.xyz", Pyramid()), InputError);
  EXPECT_THROW(WriteMesh(folder_ / "none" / "a.ply", Pyramid()), InputError);
}

TEST_F(MeshIo, HeadersWithoutVerticesOrFacesAreRefused) {
  const auto ply = [](const char* vertices, const char* faces) {
    return std::string("ply\nformat ascii 1.0\nelement vertex ") + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
           "\nproperty list uchar int vertex_indices\nend_header\n";
  };
  EXPECT_THAT(ErrorOf("a.ply", ply("0", "1") + "3 0 0 0"), HasSubstr("element vertex"));
  EXPECT_THAT(ErrorOf("a.ply", ply("1", "0") + "0 0 0"), HasSubstr("element face"));
  EXPECT_THAT(ErrorOf("a.ply", ply("-1", "1")), HasSubstr("the count must be an integer"));
}

TEST_F(MeshIo, HugeCountsAreRefusedBeforeAnythingIsAllocated) {
  // 2^62 of anything would throw bad_alloc or length_error, which are no InputError.
  for (const char* count : {"4294967295", "4611686018427387904"}) {
    for (const char* format : {"ascii", "binary_little_endian"}) {
      const std::string start = std::string("ply\nformat ") + format + " 1.0\nelement vertex ";
      const std::string xyz = "\nproperty float x\nproperty float y\nproperty float z\n";
      const std::string list = "\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n";
      EXPECT_THAT(ErrorOf("a.ply", start + count + xyz + "element face 1" + list),
                  HasSubstr("element vertex: the header announces"));
      EXPECT_THAT(ErrorOf("a.ply", start + "1" + xyz + "element face " + count + list +
                                       std::string(12, '\0')),
                  HasSubstr("element face: the header announces"));
      EXPECT_THAT(ErrorOf("a.ply", start + "1" + xyz + "element nothing " + count +
                                       "\nelement face 0" + list + std::string(6, '0')),
                  HasSubstr("element face"));
    }
    EXPECT_THAT(ErrorOf("a.off", std::string("OFF\n") + count + " 1 0\n0 0 0\n"),
                HasSubstr("vertices are more than the file holds"));
    EXPECT_THAT(ErrorOf("a.off", std::string("OFF\n1 ") + count + " 0\n0 0 0\n"),
                HasSubstr("faces are more than the file holds"));
    EXPECT_THAT(ErrorOf("b.off", std::string("OFF\n1 1 0\n0 0 0\n") + count + " 0 0 0\n"),
                HasSubstr("fewer vertices than"));
  }
  std::string list =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\nelement face 1\n"
      "property list uint int vertex_indices\nend_header\n";
  list += std::string(12, '\0');
  Append(std::uint32_t{4000000000}, false, &list);
  EXPECT_THAT(ErrorOf("a.ply", list),
              HasSubstr("truncated here, vertex_indices has a length of 4e+09"));
}

TEST_F(MeshIo, NoPrefixOfABinaryFileIsTakenForASmallerMesh) {
  const TriangleMesh mesh = Pyramid();
  WriteMesh(folder_ / "plain.ply", mesh);
  std::ifstream file(folder_ / "plain.ply", std::ios::binary);
  const std::string plain((std::istreambuf_iterator<char>(file)), {});
  for (const std::string& whole : {plain, RichBinaryPly(mesh, true)}) {
    for (size_t length = 0; length < whole.size(); ++length) {
      EXPECT_NE(ErrorOf("a.ply", whole.substr(0, length)), "") << length << " of " << whole.size();
    }
    EXPECT_EQ(ErrorOf("a.ply", whole), "");
  }
}

TEST_F(MeshIo, PrefixesOfTextFilesNeverLoseAWholeElement) {
  // The last number can always lose digits unseen; whole vertices or faces cannot (PLY and OFF).
  const TriangleMesh mesh = Pyramid();
  for (const char* name : {"a.obj", "a.off"}) {
    WriteMesh(folder_ / name, mesh);
    std::ifstream file(folder_ / name, std::ios::binary);
    const std::string whole((std::istreambuf_iterator<char>(file)), {});
    for (size_t length = 0; length < whole.size(); ++length) {
      const std::string error = ErrorOf(std::string("cut_") + name, whole.substr(0, length));
      if (name == std::string("a.off")) {
        EXPECT_EQ(error.empty(), length + 1 >= whole.size()) << length << " " << error;
      }
    }
  }
}

TEST_F(MeshIo, CorruptedBytesGiveAMeshOrAnError) {
  const std::string whole = RichBinaryPly(Pyramid(), false);
  std::uint32_t state = 12345;
  for (int trial = 0; trial < 600; ++trial) {
    std::string corrupt = whole;
    for (int change = 0; change < 3; ++change) {
      state = state * 1664525U + 1013904223U;
      corrupt[(state >> 8) % corrupt.size()] = static_cast<char>(state >> 24);
    }
    ErrorOf("a.ply", corrupt);  // anything but an InputError fails the test
  }
}

}  // namespace
}  // namespace burin
