// What fvvsynth --depth and --visibility write: depth against rays through pixels, files as they are laid
// out.
#include "fvv_catch.h"

#include "fvv_media/exr.h"
#include "fvv_render/ray_visibility.h"
#include "fvvsynth/capture_writer.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>

namespace fs = std::filesystem;
using namespace fvv::synth;
using fvv::render::no_face;

namespace {

using Files = std::map<std::string, std::string>;

Files written(const Settings &settings, const Recording &recording) {
  std::string name = (fs::temp_directory_path() / "fvvtruth-XXXXXX").string();
  REQUIRE(mkdtemp(name.data()));
  {
    fvv::cli::OutputFolder folder(name, true);
    write_capture(Scene(settings), recording, folder);
    folder.commit();
  }
  Files files;
  for (const auto &entry : fs::recursive_directory_iterator(name)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    files[fs::relative(entry.path(), name).string()] = {std::istreambuf_iterator<char>(file), {}};
  }
  fs::remove_all(name);
  return files;
}

Settings tiny(RigKind rig) {
  Settings settings;
  settings.rig = rig;
  settings.cameras = 3;
  settings.width = 64;
  settings.height = 36;
  return settings;
}

fvv::media::FloatImage depth_of(const std::string &bytes) {
  return fvv::media::decode_exr(reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size(), "depth");
}

} // namespace

TEST_CASE("written depth is the distance along the axis of where rays through pixel centres meet triangles",
          "[nightly]") {
  for (const RigKind rig : {RigKind::small, RigKind::studio}) {
    Recording recording;
    recording.frames = 1;
    recording.depth = true;
    Settings settings = tiny(rig);
    settings.width = 160;
    settings.height = 90;
    const Files files = written(settings, recording);
    const Scene scene(settings);
    const Moment moment = scene.at(0);
    for (const size_t number : {size_t(0), size_t(1)}) {
      const fvv_camera &camera = scene.cameras()[number];
      const auto depth = depth_of(files.at(std::string(camera.name, camera.name_size) + "/depth_0000.exr"));
      REQUIRE(depth.channels == std::vector<std::string>{"Z"});
      REQUIRE(depth.width == camera.width);
      REQUIRE(depth.height == camera.height);
      // Every triangle in the camera's frame; the projection is the library's own, not fvv_render's.
      std::vector<Vec3> points;
      for (size_t i = 0; i < scene.vertex_count(); i++) {
        const float *p = &moment.positions[3 * i];
        const double *r = camera.rotation, *t = camera.translation;
        points.push_back({r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + t[0],
                          r[3] * p[0] + r[4] * p[1] + r[5] * p[2] + t[1],
                          r[6] * p[0] + r[7] * p[1] + r[8] * p[2] + t[2]});
      }
      size_t both = 0, far_off = 0, one_only = 0;
      for (uint32_t y = 0; y < camera.height; y += 4)
        for (uint32_t x = 0; x < camera.width; x += 4) {
          const double pixel[2] = {x + 0.5, y + 0.5};
          double ray[3];
          REQUIRE(fvv_camera_unproject(&camera, pixel, ray) == 1);
          const Vec3 along{ray[0], ray[1], ray[2]};
          double nearest = INFINITY;
          for (size_t f = 0; f < scene.faces().size(); f += 3) {
            const Vec3 a = points[scene.faces()[f]];
            const Vec3 e1 = points[scene.faces()[f + 1]] - a, e2 = points[scene.faces()[f + 2]] - a;
            const Vec3 p = cross(along, e2), q = cross(-a, e1);
            const double determinant = dot(e1, p);
            const double u = dot(-a, p) / determinant, v = dot(along, q) / determinant;
            if (!(u >= 0 && v >= 0 && u + v <= 1)) continue;
            if (const double z = dot(e2, q) / determinant; z > 0) nearest = std::min(nearest, z);
          }
          const double found = double(depth.samples[size_t(y) * camera.width + x]);
          if (std::isinf(found) != std::isinf(nearest)) {
            one_only++;
          } else if (!std::isinf(found)) {
            both++;
            far_off += std::abs(found - nearest) > 1e-3;
          }
        }
      CAPTURE(int(rig), number, both, far_off, one_only);
      CHECK(both > 15);
      CHECK(far_off <= 3); // outlines: the rasteriser rounds vertices to 1/768 of a pixel, and bends no edges
      CHECK(one_only <= 2);
    }
  }
}

TEST_CASE("written depth is Picture.depth bit by bit, with all kinds of meshes", "[long]") {
  for (const Meshes meshes : {Meshes::tracked, Meshes::remeshed}) {
    Recording recording;
    recording.frames = 2;
    recording.depth = true;
    recording.meshes = meshes;
    const Settings settings = tiny(RigKind::small);
    const Files files = written(settings, recording);
    const Scene scene(settings);
    fvv::render::SampleBuffer buffer(64, 36, 3);
    const auto picture = scene.picture(2, scene.at(1 / 25.0), buffer);
    const auto depth = depth_of(files.at("cam2/depth_0001.exr"));
    REQUIRE(depth.samples.size() == picture.depth.size());
    CHECK(std::memcmp(depth.samples.data(), picture.depth.data(), 4 * picture.depth.size()) == 0);
  }
}

TEST_CASE("written visibility is that of the written mesh, in NumPy's layout, for any number of threads",
          "[nightly]") {
  for (const Meshes meshes : {Meshes::tracked, Meshes::remeshed, Meshes::hull}) {
    Recording recording;
    recording.frames = 2;
    recording.visibility = true;
    recording.meshes = meshes;
    recording.hull_cells = 60;
    const Settings settings = tiny(RigKind::small);
    const Files files = written(settings, recording);
    recording.threads = 3;
    CHECK(written(settings, recording) == files);
    const Scene scene(settings);
    const std::string &ply = files.at("meshes/0001.ply");
    const auto number_behind = [&](const std::string &text) {
      return size_t(std::stoul(ply.substr(ply.find(text) + text.size())));
    };
    const size_t vertices = number_behind("element vertex "), faces = number_behind("element face ");
    const char *at = ply.data() + ply.find("end_header\n") + 11;
    std::vector<float> positions(3 * vertices);
    std::memcpy(positions.data(), at, 12 * vertices);
    at += 12 * vertices;
    std::vector<uint32_t> indices(3 * faces);
    for (size_t f = 0; f < faces; f++) std::memcpy(&indices[3 * f], at + 13 * f + 1, 12);
    const fvv::render::Mesh mesh = {positions.data(), vertices, indices.data(), faces};
    const fvv::render::RayCaster rays(mesh);
    for (const bool of_faces : {true, false}) {
      const std::string &npy =
          files.at(of_faces ? "visibility/faces_0001.npy" : "visibility/vertices_0001.npy");
      const size_t columns = of_faces ? faces : vertices;
      REQUIRE(npy.compare(0, 8, std::string("\x93NUMPY\x01\x00", 8)) == 0);
      const size_t head = 10 + uint8_t(npy[8]) + 256u * uint8_t(npy[9]);
      CHECK(head % 64 == 0);
      CHECK(npy[head - 1] == '\n');
      CHECK(npy.substr(10, 60).find("{'descr': '|b1', 'fortran_order': False, 'shape': (3, ") == 0);
      REQUIRE(npy.size() == head + 3 * columns);
      size_t seen = 0;
      for (size_t c = 0; c < 3; c++) {
        const fvv_camera &camera = scene.cameras()[c];
        const std::vector<uint8_t> row = of_faces ? fvv::render::visible_faces(camera, mesh, rays)
                                                  : fvv::render::visible_vertices(camera, mesh, rays);
        CHECK(std::memcmp(row.data(), npy.data() + head + c * columns, columns) == 0);
        for (const uint8_t value : row) seen += value;
      }
      CHECK(seen > columns * 3 / 4); // of three cameras, each of which sees less than a half
      CHECK(seen < columns * 3 / 2);
    }
  }
}

TEST_CASE("without the options neither depth nor visibility is written") {
  Recording recording;
  recording.frames = 1;
  for (const auto &[name, bytes] : written(tiny(RigKind::small), recording)) {
    CHECK(name.find(".exr") == std::string::npos);
    CHECK(name.find("visibility") == std::string::npos);
  }
}
