// Mesh files as other programs write them: each is the tetrahedron that was written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/mesh/mesh_check.h"
#include "core/mesh/mesh_io.h"
#include "tests/colmap_testing.h"

namespace burin {
namespace {

using testing::HasSubstr;

constexpr int kCorners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
constexpr int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

class MeshDialects : public testing::Test {
 protected:
  TriangleMesh Read(const std::string& name, const std::string& bytes) {
    WriteBytes(folder_.path() / name, bytes);
    return ReadMesh(folder_.path() / name, &report_);
  }
  std::string ErrorOf(const std::string& name, const std::string& bytes) {
    try {
      Read(name, bytes);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
  // Closed, of 4 vertices, outward: its volume is 1/6.
  void ExpectTetrahedron(const TriangleMesh& mesh) const {
    ASSERT_EQ(mesh.vertices.size(), 4U);
    ASSERT_EQ(mesh.faces.size(), 4U);
    EXPECT_EQ(report_.boundary_edge_count, 0);
    double volume = 0;
    for (int f = 0; f < 4; ++f) {
      volume += mesh.vertices[mesh.faces[f][0]].dot(FaceAreaNormal(mesh, f)) / 6;
    }
    EXPECT_NEAR(volume, 1.0 / 6, 1e-12);
  }

  TempFolder folder_;
  MeshReport report_;
};

template <typename T>
void Append(T value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

std::string BinaryStl() {
  std::string bytes = "solid written by a program that begins its header so";
  bytes.resize(80, ' ');
  Append<std::uint32_t>(4, &bytes);
  for (const auto& face : kFaces) {
    for (int k = 0; k < 3; ++k) Append(0.0F, &bytes);
    for (const int v : face) {
      for (int k = 0; k < 3; ++k) Append(static_cast<float>(kCorners[v][k]), &bytes);
    }
    Append<std::uint16_t>(0, &bytes);
  }
  return bytes;
}

TEST_F(MeshDialects, Stl) {
  const std::string binary = BinaryStl();
  ExpectTetrahedron(Read("a.stl", binary));
  EXPECT_EQ(report_.welded_vertex_count, 8);
  EXPECT_THAT(ErrorOf("a.stl", std::string(80, ' ') + binary.substr(80, 100)),
              HasSubstr("announces 4 facets, the file is truncated after 1"));
  std::string text = "solid a\n";
  for (const auto& face : kFaces) {
    text += " facet normal 0 0 0\r\n  outer loop\n";
    for (const int v : face) {
      text += "   vertex " + std::to_string(kCorners[v][0]) + " " + std::to_string(kCorners[v][1]) +
              "e0 " + std::to_string(kCorners[v][2]) + ".0\n";
    }
    text += "  endloop\n endfacet\n";
  }
  ExpectTetrahedron(Read("b.STL", text + "endsolid a\n"));
  EXPECT_THAT(ErrorOf("b.stl", "solid\nfacet\nvertex 0 0 0\nvertex 1 0 x\n"),
              HasSubstr("line 4: vertex: 'x' is not a number"));
  EXPECT_THAT(ErrorOf("b.stl", "solid\nfacet\nvertex 0 0 0\nendfacet\n"),
              HasSubstr("line 4: facet: has not three corners"));
  EXPECT_THAT(ErrorOf("b.stl", "solid\nendsolid\n"), HasSubstr("facets: the mesh has none"));
}

TEST_F(MeshDialects, IntegerCoordinatesAndOddValuesInOtherFields) {
  for (const std::string mark : {"", "\xEF\xBB\xBF"}) {
    ExpectTetrahedron(
        Read("a.ply", mark + "ply\r\nformat ascii 1.0\r\nelement vertex 4\r\n"
                             "property int x\r\nproperty int y\r\nproperty int z\r\n"
                             "property float quality\r\nelement face 4\r\n"
                             "property list uchar int vertex_indices\r\nend_header\r\n"
                             "0 0 0 -nan(ind)\r\n1 0 0 1.#QNAN\r\n0 1 0 nan\r\n0 0 1 7\r\n"
                             "3 0 2 1\r\n3 0 1 3\r\n3 1 2 3\r\n3 2 0 3\r\n"));
  }
  for (const bool big : {false, true}) {
    std::string bytes = "ply\nformat binary_" + std::string(big ? "big" : "little") +
                        "_endian 1.0\nelement vertex 4\nproperty short x\nproperty short y\n"
                        "property short z\nelement face 4\nproperty list uchar uchar "
                        "vertex_indices\nend_header\n";
    for (const auto& corner : kCorners) {
      for (const int value : corner)
        bytes += {static_cast<char>(big ? 0 : value), static_cast<char>(big ? value : 0)};
    }
    for (const auto& face : kFaces) {
      bytes.push_back(3);
      for (const int v : face) bytes.push_back(static_cast<char>(v));
    }
    ExpectTetrahedron(Read("b.ply", bytes));
  }
  ExpectTetrahedron(
      Read("c.obj",
           "\xEF\xBB\xBFv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"));
}

// Two triangles of a strip, and two that begin anew after -1.
TEST_F(MeshDialects, TriangleStrips) {
  const std::string header =
      "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  // 0 2 1 and, turned, 2 3 1; then 0 1 3 and, turned, 1 ... is 3 1 0 2: 0 3 2.
  ExpectTetrahedron(Read("a.ply", "ply\nformat ascii 1.0\n" + header +
                                      "0 0 0\n1 0 0\n0 1 0\n0 0 1\n9 0 2 1 3 -1 1 3 0 2\n"));
  for (const bool big : {false, true}) {
    std::string bytes =
        "ply\nformat binary_" + std::string(big ? "big" : "little") + "_endian 1.0\n" + header;
    const auto append = [&](const void* value) {
      const char* raw = static_cast<const char*>(value);
      for (int k = 0; k < 4; ++k) bytes.push_back(raw[big ? 3 - k : k]);
    };
    for (const auto& corner : kCorners) {
      for (const int value : corner) {
        const auto number = static_cast<float>(value);
        append(&number);
      }
    }
    for (const int number : {9, 0, 2, 1, 3, -1, 1, 3, 0, 2}) append(&number);
    ExpectTetrahedron(Read("b.ply", bytes));
  }
  EXPECT_THAT(ErrorOf("c.ply",
                      "ply\nformat ascii 1.0\n" + header + "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 9\n"),
              HasSubstr("vertex index 9 must be below the vertex count 4"));
}

}  // namespace
}  // namespace burin
