// Visibility of a file's meshes as its cameras have it, by casting rays at the decoded meshes: bits for each
// element and camera, times, and how often a bit is not what a ray to some other place of the face says.
#include "fvvbench.h"

#include "fvv_render/ray_visibility.h"

#include <cmath>

namespace {

using namespace fvv::render;

// Sums over frames and cameras.
struct Sums {
  double pairs = 0, bytes = 0, lost = 0; // element and camera; bytes of payload; seen, no bit
  double places = 0, wrong = 0;          // places that face a camera; bits that do not fit them
  double frames = 0, order = 0, encode = 0, decode = 0; // seconds
};

struct Frame {
  fvv_mesh mesh = {};
  std::vector<float> metres;
  std::vector<std::vector<uint8_t>> faces, vertices; // seen by each camera
  std::vector<std::vector<uint8_t>> places;          // of each face one place: 1 seen by each camera, 0 not
  Mesh view() const {
    Mesh out;
    out.positions = metres.data();
    out.vertex_count = mesh.vertex_count;
    out.faces = mesh.faces;
    out.face_count = mesh.face_count;
    return out;
  }
};

// A place within a face that is as likely to be anywhere in it, another one for each face.
Vec3 place_in(const Mesh &mesh, uint32_t face) {
  double u = std::fmod(0.5 + 0.7548776662466927 * face, 1.0),
         v = std::fmod(0.5 + 0.5698402909980532 * face, 1.0);
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  const auto at = [&](size_t corner) {
    const float *p = mesh.positions + 3 * size_t(mesh.faces[3 * size_t(face) + corner]);
    return Vec3{p[0], p[1], p[2]};
  };
  return at(0) * (1 - u - v) + at(1) * u + at(2) * v;
}

std::vector<uint8_t> seen_places(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays) {
  double c[3];
  fvv_camera_centre(&camera, c);
  std::vector<uint8_t> out(mesh.face_count);
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    const Vec3 place = place_in(mesh, f);
    const double world[3] = {place.x, place.y, place.z};
    double pixel[2];
    out[f] = fvv_camera_project(&camera, world, pixel, nullptr) == 1 && pixel[0] >= 0 && pixel[1] >= 0 &&
             pixel[0] < camera.width && pixel[1] < camera.height &&
             !rays.blocked({c[0], c[1], c[2]}, place, f);
  }
  return out;
}

Frame look(fvv_stream *stream, size_t number, const fvv_configuration &configuration) {
  Frame frame;
  fvv_diagnostic d{};
  require(fvv_stream_mesh(stream, number, 1, &frame.mesh, &d), d);
  frame.metres.resize(3 * size_t(frame.mesh.vertex_count));
  fvv_lattice_to_floats(configuration.scene.lattice_origin, configuration.scene.lattice_step,
                        frame.mesh.positions, frame.mesh.vertex_count, frame.metres.data());
  const Mesh mesh = frame.view();
  const RayCaster rays(mesh);
  for (size_t c = 0; c < configuration.camera_count; c++) {
    frame.faces.push_back(visible_faces(configuration.cameras[c], mesh, rays));
    frame.vertices.push_back(visible_vertices(configuration.cameras[c], mesh, rays));
    frame.places.push_back(seen_places(configuration.cameras[c], mesh, rays));
  }
  return frame;
}

// States of the frame before by camera, and the faces that they belong to.
struct Former {
  std::vector<std::vector<uint8_t>> states;
  std::vector<uint32_t> faces;
  uint32_t number = 0;
};

void code(const Frame &frame, const fvv_configuration &configuration, uint8_t domain, uint8_t threshold,
          Former &former, Sums &sums) {
  const fvv_mesh &mesh = frame.mesh;
  const std::vector<uint32_t> faces(mesh.faces, mesh.faces + 3 * size_t(mesh.face_count));
  const bool follows = former.faces == faces;
  const auto &seen = domain == FVV_VISIBILITY_FACES ? frame.faces : frame.vertices;
  const size_t count = seen[0].size();
  former.number = follows ? former.number + 1 : 0;
  former.faces = faces;
  if (!follows) former.states.assign(seen.size(), std::vector<uint8_t>(count));
  std::vector<fvv_visibility_view> views;
  auto states = former.states;
  fvv_diagnostic d{};
  for (size_t c = 0; c < seen.size(); c++) {
    views.push_back(
        {configuration.cameras[c].id, {}, seen[c].data(), former.states[c].data(), states[c].data()});
    require(fvv_visibility_centre(&configuration.cameras[c], &configuration.scene, views[c].centre, &d), d);
  }
  fvv_visibility_header header = {domain, threshold, 1, 0, former.number, 0};
  fvv_visibility_order *order = nullptr;
  fvv_bytes payload{};
  sums.order += seconds([&] { require(fvv_visibility_order_open(&mesh, domain, nullptr, &order, &d), d); });
  sums.encode += seconds([&] {
    require(fvv_visibility_encode(order, &mesh, &header, views.data(), views.size(), &payload, &d), d);
  });
  std::vector<fvv_visibility_stream> streams(views.size());
  sums.decode += seconds([&] {
    require(
        fvv_visibility_peek(payload.data, payload.size, nullptr, &header, streams.data(), streams.size(), &d),
        d);
    for (size_t c = 0; c < views.size(); c++)
      require(fvv_visibility_decode(order, &mesh, &header, payload.data + streams[c].offset, streams[c].size,
                                    views[c].centre, former.states[c].data(), former.states[c].data(), &d),
              d);
  });
  if (states != former.states) throw std::runtime_error("what was decoded is not what was encoded");
  for (size_t c = 0; c < seen.size(); c++)
    for (size_t i = 0; i < count; i++) {
      sums.lost += seen[c][i] && !states[c][i];
      if (domain == FVV_VISIBILITY_VERTICES || !states[c][i]) continue;
      sums.places++;
      sums.wrong += (states[c][i] == FVV_ELEMENT_SEEN) != (frame.places[c][i] != 0);
    }
  sums.pairs += double(count * seen.size());
  sums.bytes += double(payload.size);
  sums.frames++;
  fvv_bytes_free(&payload);
  fvv_visibility_order_close(order);
}

void report(nlohmann::ordered_json &out, const std::string &name, const Sums &s) {
  out[name + ".bits"] = s.bytes * 8 / s.pairs;
  out[name + ".bytes_a_frame"] = s.bytes / s.frames;
  out[name + ".lost_percent"] = 100 * s.lost / s.pairs;
  if (s.places > 0) out[name + ".error_percent"] = 100 * s.wrong / s.places;
  out[name + ".order_ms"] = s.order / s.frames * 1e3;
  out[name + ".encode_ms"] = s.encode / s.frames * 1e3;
  out[name + ".decode_ms"] = s.decode / s.frames * 1e3;
}

} // namespace

// bits: for each element and camera, 1 if none were coded. lost_percent: of these, seen by the ray to the
// centroid or vertex, and not facing by more than the threshold. error_percent: of the pairs of face and
// camera that have a bit, those where a ray to another place of the face says otherwise.
nlohmann::ordered_json visibility(const char *path) {
  Bytes source = read_file(path);
  fvv_diagnostic d{};
  fvv_stream *stream = nullptr;
  const fvv_input input = input_of(source);
  require(fvv_stream_open(&input, nullptr, nullptr, &stream, &d), d);
  const fvv_configuration *configuration = nullptr;
  require(fvv_stream_configuration(stream, 0, &configuration, &d), d);
  if (!configuration->camera_count) throw std::runtime_error("the file has no cameras");
  const size_t frames = std::min<size_t>(fvv_stream_frame_count(stream), 10);
  Sums faces, nearly_all, all, vertices;
  Former faces_before, nearly_all_before, all_before, vertices_before;
  for (size_t f = 0; f < frames; f++) {
    Frame frame = look(stream, f, *configuration);
    code(frame, *configuration, FVV_VISIBILITY_FACES, FVV_VISIBILITY_THRESHOLD, faces_before, faces);
    code(frame, *configuration, FVV_VISIBILITY_FACES, 4, nearly_all_before, nearly_all);
    code(frame, *configuration, FVV_VISIBILITY_FACES, 0, all_before, all);
    code(frame, *configuration, FVV_VISIBILITY_VERTICES, FVV_VISIBILITY_THRESHOLD, vertices_before, vertices);
    fvv_mesh_free(&frame.mesh);
  }
  nlohmann::ordered_json out = {{"visibility.cameras", configuration->camera_count}};
  report(out, "visibility.faces", faces);
  report(out, "visibility.faces_at_4", nearly_all);
  report(out, "visibility.faces_at_0", all);
  report(out, "visibility.vertices", vertices);
  fvv_stream_close(stream);
  return out;
}
