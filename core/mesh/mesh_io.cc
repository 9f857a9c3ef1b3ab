#include "core/mesh/mesh_io.h"

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "core/mesh/mesh_scan.h"
#include "core/mesh/openmesh_silence.h"
#include "core/mesh/polygon_cut.h"
#include "core/mesh/weld.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"

namespace burin {
namespace {

using OpenMesh::EdgeHandle;
using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

// Takes vertices and faces from an OpenMesh reader as they come. What is not asked for in the
// reader's options is never sent, so the rest of the interface has nothing to do.
class PolygonCollector : public OpenMesh::IO::BaseImporter {
 public:
  size_t vertex_count = 0;
  std::vector<int> start = {0};  // polygon f is index[start[f]] .. index[start[f + 1] - 1]
  std::vector<int> index;

  VertexHandle add_vertex() override { return VertexHandle(static_cast<int>(vertex_count++)); }
  VertexHandle add_vertex(const OpenMesh::Vec3f&) override { return add_vertex(); }
  FaceHandle add_face(const VHandles& corners) override {
    for (VertexHandle corner : corners) index.push_back(corner.idx());
    start.push_back(static_cast<int>(index.size()));
    return FaceHandle(static_cast<int>(start.size()) - 2);
  }
  size_t n_vertices() const override { return vertex_count; }
  size_t n_faces() const override { return start.size() - 1; }
  size_t n_edges() const override { return 0; }

  HalfedgeHandle add_edge(VertexHandle, VertexHandle) override { return HalfedgeHandle(); }
  FaceHandle add_face(HalfedgeHandle) override { return FaceHandle(); }
  void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<OpenMesh::Vec2f>&) override {}
  void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<OpenMesh::Vec3f>&) override {}
  void set_face_texindex(FaceHandle, int) override {}
  void set_point(VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_halfedge(VertexHandle, HalfedgeHandle) override {}
  void set_normal(VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_normal(VertexHandle, const OpenMesh::Vec3d&) override {}
  void set_color(VertexHandle, const OpenMesh::Vec3uc&) override {}
  void set_color(VertexHandle, const OpenMesh::Vec4uc&) override {}
  void set_color(VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_color(VertexHandle, const OpenMesh::Vec4f&) override {}
  void set_texcoord(VertexHandle, const OpenMesh::Vec2f&) override {}
  void set_status(VertexHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_next(HalfedgeHandle, HalfedgeHandle) override {}
  void set_face(HalfedgeHandle, FaceHandle) override {}
  void request_face_texcoords2D() override {}
  void set_texcoord(HalfedgeHandle, const OpenMesh::Vec2f&) override {}
  void set_texcoord(VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_texcoord(HalfedgeHandle, const OpenMesh::Vec3f&) override {}
  void set_status(HalfedgeHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_color(EdgeHandle, const OpenMesh::Vec3uc&) override {}
  void set_color(EdgeHandle, const OpenMesh::Vec4uc&) override {}
  void set_color(EdgeHandle, const OpenMesh::Vec3f&) override {}
  void set_color(EdgeHandle, const OpenMesh::Vec4f&) override {}
  void set_status(EdgeHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_normal(FaceHandle, const OpenMesh::Vec3f&) override {}
  void set_normal(FaceHandle, const OpenMesh::Vec3d&) override {}
  void set_color(FaceHandle, const OpenMesh::Vec3uc&) override {}
  void set_color(FaceHandle, const OpenMesh::Vec4uc&) override {}
  void set_color(FaceHandle, const OpenMesh::Vec3f&) override {}
  void set_color(FaceHandle, const OpenMesh::Vec4f&) override {}
  void set_status(FaceHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void add_texture_information(int, std::string) override {}
};

const std::vector<std::string> kWritten = {"ply", "obj", "off"};
const std::vector<std::string> kRead = {"ply", "obj", "off", "stl"};

std::string Extension(const std::filesystem::path& path, const std::vector<std::string>& allowed) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const std::string& known : allowed) {
    if (extension == "." + known) return known;
  }
  std::string text;
  for (size_t k = 0; k < allowed.size(); ++k) {
    text += (k == 0 ? "." : k + 1 < allowed.size() ? ", ." : " or .") + allowed[k];
  }
  throw InputError(path, "extension: '" + extension + "' must be " + text);
}

std::string ReadWholeFile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw InputError(path, "mesh file: does not exist");
  if (std::filesystem::is_directory(path, error)) {
    throw InputError(path, "mesh file: is a folder");
  }
  std::ifstream file(path, std::ios::binary);
  std::string data((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file) throw InputError(path, "mesh file: cannot be read");
  if (data.empty()) throw InputError(path, "mesh file: is empty");
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (data.compare(0, kByteOrderMark.size(), kByteOrderMark) == 0) {
    data.erase(0, kByteOrderMark.size());
  }
  if (data.size() > static_cast<size_t>(std::numeric_limits<int>::max())) {
    throw InputError(path, "mesh file: is larger than 2 GiB");
  }
  return data;
}

// In silence, since what OpenMesh would say is checked before and after.
PolygonCollector ParseWithOpenMesh(const std::filesystem::path& path, const std::string& extension,
                                   const ScannedMesh& scan) {
  PolygonCollector polygons;
  std::istringstream stream(scan.text);
  OpenMesh::IO::Options options;
  const OpenMeshSilence silence;
  const bool parsed = OpenMesh::IO::IOManager().read(stream, extension, polygons, options);
  if (!parsed) throw InputError(path, "mesh file: OpenMesh cannot parse it");
  if (polygons.n_vertices() != scan.positions.size()) {
    throw InputError(path, "vertices: OpenMesh finds " + std::to_string(polygons.n_vertices()) +
                               ", the file has " + std::to_string(scan.positions.size()));
  }
  if (static_cast<std::int64_t>(polygons.n_faces()) != scan.face_count) {
    throw InputError(path, "faces: OpenMesh finds " + std::to_string(polygons.n_faces()) +
                               ", the file has " + std::to_string(scan.face_count));
  }
  return polygons;
}

template <typename T>
void AppendNumber(T value, std::string* text) {
  char digits[32];
  text->append(digits, std::to_chars(digits, digits + sizeof(digits), value).ptr);
}

template <typename T>
void AppendLittleEndian(T value, std::string* bytes) {
  unsigned char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
  std::reverse(raw, raw + sizeof(T));
#endif
  bytes->append(reinterpret_cast<const char*>(raw), sizeof(T));
}

int ColorByte(float channel) {
  return static_cast<int>(std::lround(255 * std::clamp(channel, 0.0F, 1.0F)));
}

std::string PlyText(const TriangleMesh& mesh, const std::vector<Eigen::Vector3f>* colors,
                    const std::vector<VertexScalar>& scalars) {
  std::string out = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                    std::to_string(mesh.vertices.size()) +
                    "\nproperty double x\nproperty double y\nproperty double z\n";
  if (colors) out += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  for (const VertexScalar& scalar : scalars) out += "property float " + scalar.name + "\n";
  out += "element face " + std::to_string(mesh.faces.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
  out.reserve(out.size() + mesh.vertices.size() * (27 + 4 * scalars.size()) +
              mesh.faces.size() * 13);
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    for (int c = 0; c < 3; ++c) AppendLittleEndian(mesh.vertices[v][c], &out);
    for (int c = 0; colors && c < 3; ++c) {
      out.push_back(static_cast<char>(ColorByte((*colors)[v][c])));
    }
    for (const VertexScalar& scalar : scalars) AppendLittleEndian(scalar.values[v], &out);
  }
  for (const Eigen::Vector3i& face : mesh.faces) {
    out.push_back(3);
    for (int c = 0; c < 3; ++c) AppendLittleEndian(static_cast<std::int32_t>(face[c]), &out);
  }
  return out;
}

std::string ObjText(const TriangleMesh& mesh, const std::vector<Eigen::Vector3f>* colors) {
  std::string out;
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    out += 'v';
    for (int c = 0; c < 3; ++c) AppendNumber(mesh.vertices[v][c], &(out += ' '));
    for (int c = 0; colors && c < 3; ++c) AppendNumber((*colors)[v][c], &(out += ' '));
    out += '\n';
  }
  for (const Eigen::Vector3i& face : mesh.faces) {
    out += 'f';
    for (int c = 0; c < 3; ++c) AppendNumber(face[c] + 1, &(out += ' '));
    out += '\n';
  }
  return out;
}

std::string OffText(const TriangleMesh& mesh, const std::vector<Eigen::Vector3f>* colors) {
  std::string out = (colors ? "COFF\n" : "OFF\n") + std::to_string(mesh.vertices.size()) + " " +
                    std::to_string(mesh.faces.size()) + " 0\n";
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    for (int c = 0; c < 3; ++c) {
      AppendNumber(mesh.vertices[v][c], &out);
      out += c < 2 ? " " : "";
    }
    for (int c = 0; colors && c < 3; ++c) AppendNumber(ColorByte((*colors)[v][c]), &(out += ' '));
    out += colors ? " 255\n" : "\n";
  }
  for (const Eigen::Vector3i& face : mesh.faces) {
    out += '3';
    for (int c = 0; c < 3; ++c) AppendNumber(face[c], &(out += ' '));
    out += '\n';
  }
  return out;
}

}  // namespace

TriangleMesh ReadMesh(const std::filesystem::path& path, MeshReport* report) {
  const std::string extension = Extension(path, kRead);
  ScannedMesh scan;
  {
    const std::string data = ReadWholeFile(path);
    scan = extension == "ply"   ? ScanPly(path, data)
           : extension == "obj" ? ScanObj(path, data)
           : extension == "stl" ? ScanStl(path, data)
                                : ScanOff(path, data);
  }
  // A soup of facets is given as OFF (core/mesh/mesh_scan_stl.cc).
  const PolygonCollector polygons =
      ParseWithOpenMesh(path, extension == "stl" ? "off" : extension, scan);

  TriangleMesh mesh;
  mesh.vertices = std::move(scan.positions);
  const int vertex_count = static_cast<int>(mesh.vertices.size());
  int dropped_count = static_cast<int>(scan.skipped_face_count);
  int polygon_count = 0;
  for (size_t f = 0; f < polygons.n_faces(); ++f) {
    const int* corner = polygons.index.data() + polygons.start[f];
    const int corner_count = polygons.start[f + 1] - polygons.start[f];
    for (int c = 0; c < corner_count; ++c) {
      if (corner[c] >= 0 && corner[c] < vertex_count) continue;
      throw InputError(path, "face " + std::to_string(f) + ": vertex index " +
                                 std::to_string(corner[c]) + " must be below the vertex count " +
                                 std::to_string(vertex_count));
    }
    polygon_count += corner_count > 3;
    dropped_count += corner_count < 3;
    if (corner_count == 3) {
      mesh.faces.emplace_back(corner[0], corner[1], corner[2]);
    } else if (corner_count > 3) {
      std::vector<Eigen::Vector3d> corners;
      corners.reserve(corner_count);
      for (int c = 0; c < corner_count; ++c) corners.push_back(mesh.vertices[corner[c]]);
      for (const Eigen::Vector3i& cut : CutPolygon(corners)) {
        mesh.faces.emplace_back(corner[cut[0]], corner[cut[1]], corner[cut[2]]);
      }
    }
  }
  dropped_count += DropDegenerateFaces(&mesh);
  const int duplicate_count = DropDuplicateFaces(&mesh);
  const int welded_count = WeldSeams(&mesh);
  if (mesh.faces.empty()) {
    throw InputError(path, "faces: every one of the " + std::to_string(dropped_count) +
                               " repeats a vertex or has no area");
  }
  const int reoriented_count = OrientConsistently(&mesh);
  if (report != nullptr) {
    *report = CheckMesh(mesh);
    report->polygon_count = polygon_count;
    report->degenerate_face_count += dropped_count;
    report->duplicate_face_count = duplicate_count;
    report->welded_vertex_count = welded_count;
    report->reoriented_face_count = reoriented_count;
  }
  return mesh;
}

void WriteMesh(const std::filesystem::path& path, const TriangleMesh& mesh,
               const std::vector<Eigen::Vector3f>* vertex_colors,
               const std::vector<VertexScalar>& scalars) {
  const std::string extension = Extension(path, kWritten);
  WriteTextAtomically(path, extension == "ply"   ? PlyText(mesh, vertex_colors, scalars)
                            : extension == "obj" ? ObjText(mesh, vertex_colors)
                                                 : OffText(mesh, vertex_colors));
}

}  // namespace burin
