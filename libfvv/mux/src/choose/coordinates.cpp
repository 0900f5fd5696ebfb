// Whether meshes and cameras fit each other: one unit, the same axes, one coordinate frame.
#include "fvv_cxx/format.h"
#include "fvv_geometry/outline.h"
#include "fvv_render/vector.h"
#include "mux/src/choose/choices.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/terms.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fvv::mux {

namespace {

constexpr size_t most_places = 2000; // of a mesh that are projected
constexpr double least_pixels = 4;   // of a picture that a mesh covers along its longer side
// Of a mesh that fits: the fraction within the picture, and its longer side in those of the picture.
constexpr double least_within = 0.5, least_side = 0.125, most_side = 1.25;
constexpr size_t most_candidates = 2; // more tell nothing

using Point = std::array<double, 3>;

struct Candidate {
  const char *text; // what would have to be done to the meshes
  Point (*place)(const Point &);
};

template <int numerator, int denominator> Point scaled(const Point &p) {
  const double factor = double(numerator) / denominator;
  return {factor * p[0], factor * p[1], factor * p[2]};
}

// The frequent mistakes. Units first, because they are the most frequent one.
constexpr Candidate candidates[] = {
    {"times 0.001", scaled<1, 1000>},
    {"times 1000", scaled<1000, 1>},
    {"times 0.01", scaled<1, 100>},
    {"times 100", scaled<100, 1>},
    {"times 0.1", scaled<1, 10>},
    {"times 10", scaled<10, 1>},
    {"times 0.0254 (inches)", scaled<254, 10000>},
    {"times 0.3048 (feet)", scaled<3048, 10000>},
    {"with z up turned to y up (x, z, -y)",
     [](const Point &p) {
       return Point{p[0], p[2], -p[1]};
     }},
    {"with y up turned to z up (x, -z, y)",
     [](const Point &p) {
       return Point{p[0], -p[2], p[1]};
     }},
    {"with y and z the other way round (x, -y, -z)",
     [](const Point &p) {
       return Point{p[0], -p[1], -p[2]};
     }},
};

struct CameraCandidate {
  const char *text; // what the cameras would have to be read as
  void (*change)(fvv_camera &);
};

void turn_axes(fvv_camera &camera) {
  for (size_t row = 1; row < 3; row++) {
    for (size_t k = 0; k < 3; k++) camera.rotation[3 * row + k] *= -1;
    camera.translation[row] *= -1;
  }
}

// t, where it is the centre.
void read_centre(fvv_camera &camera) {
  const std::array<double, 3> centre = {camera.translation[0], camera.translation[1], camera.translation[2]};
  for (size_t row = 0; row < 3; row++) {
    camera.translation[row] = 0;
    for (size_t k = 0; k < 3; k++) camera.translation[row] -= camera.rotation[3 * row + k] * centre[k];
  }
}

void invert(fvv_camera &camera) {
  for (size_t row = 0; row < 3; row++)
    for (size_t k = 0; k < row; k++) std::swap(camera.rotation[3 * row + k], camera.rotation[3 * k + row]);
  read_centre(camera);
}

constexpr CameraCandidate camera_candidates[] = {
    {"with y up and z backwards (OpenGL)", turn_axes},
    {"whose translation is the camera's place", read_centre},
    {"from camera to world", invert},
    {"from camera to world, with y up and z backwards (OpenGL)",
     [](fvv_camera &camera) {
       invert(camera);
       turn_axes(camera);
     }},
};

// How a camera shows places of a mesh.
struct View {
  size_t within = 0; // of the places
  double side = 0;   // the longer one of their box, in pixels
};

View look(const fvv_camera &camera, const std::vector<Point> &places) {
  View out;
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  for (const Point &place : places) {
    double pixel[2], depth;
    if (!fvv_camera_project(&camera, place.data(), pixel, &depth) || !(depth > 0)) continue;
    for (size_t k = 0; k < 2; k++) {
      low[k] = std::min(low[k], pixel[k]);
      high[k] = std::max(high[k], pixel[k]);
    }
    out.within += pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] < camera.width && pixel[1] < camera.height;
  }
  out.side = std::max({0.0, high[0] - low[0], high[1] - low[1]});
  return out;
}

// Of vertices that faces use.
std::vector<Point> places_of(const geometry::Mesh &mesh) {
  std::vector<Point> out;
  const size_t stride = 1 + mesh.faces.size() / most_places;
  for (size_t i = 0; i < mesh.faces.size(); i += stride) {
    const double *p = &mesh.positions[3 * size_t(mesh.faces[i])];
    out.push_back({p[0], p[1], p[2]});
  }
  return out;
}

// The cameras that show most of the mesh in a reasonable size.
size_t fitting(const std::vector<fvv_camera> &cameras, const std::vector<Point> &places) {
  return size_t(std::count_if(cameras.begin(), cameras.end(), [&](const fvv_camera &camera) {
    const View view = look(camera, places);
    const double side = view.side / std::max(camera.width, camera.height);
    return double(view.within) >= least_within * double(places.size()) && side >= least_side &&
           side <= most_side;
  }));
}

bool surrounds(const geometry::Mesh &mesh, const std::vector<fvv_camera> &cameras) {
  const geometry::TypicalBox box = geometry::typical_box(mesh);
  return std::all_of(cameras.begin(), cameras.end(), [&](const fvv_camera &camera) {
    double centre[3];
    fvv_camera_centre(&camera, centre);
    for (size_t k = 0; k < 3; k++)
      if (!(centre[k] > box.low[k] && centre[k] < box.high[k])) return false;
    return true;
  });
}

// Of candidates those that bring the mesh into most pictures, for people; empty: none does, or too many.
// fits: the number of pictures with a candidate.
template <class Candidates, class Fits>
std::string best_of(const Candidates &all, size_t cameras, const char *subject, const Fits &fits) {
  std::string texts;
  size_t most = 0, equal = 0;
  for (const auto &candidate : all) {
    const size_t count = fits(candidate);
    if (!count || count < most) continue;
    if (count > most) {
      texts.clear();
      equal = 0;
    }
    texts += (equal++ ? ", or " : "") + std::string(candidate.text);
    most = count;
  }
  if (2 * most < cameras || !equal || equal > most_candidates) return "";
  return fvv::format("; %s %s: the mesh would be in %zu of %zu pictures", subject, texts.c_str(), most,
                     cameras);
}

std::string advice_for_cameras(const std::vector<fvv_camera> &cameras, const std::vector<Point> &places,
                               const char *subject) {
  return best_of(camera_candidates, cameras.size(), subject, [&](const CameraCandidate &candidate) {
    std::vector<fvv_camera> changed = cameras;
    for (fvv_camera &camera : changed) candidate.change(camera);
    return fitting(changed, places);
  });
}

std::string advice_for(const std::vector<fvv_camera> &cameras, const std::vector<Point> &places) {
  const std::string of_meshes =
      best_of(candidates, cameras.size(), "meshes", [&](const Candidate &candidate) {
        std::vector<Point> moved;
        for (const Point &place : places) moved.push_back(candidate.place(place));
        return fitting(cameras, moved);
      });
  if (!of_meshes.empty()) return of_meshes;
  return advice_for_cameras(cameras, places, "cameras");
}

} // namespace

bool warn_of_coordinates(const Plan &plan, const std::vector<SampledMesh> &sampled) {
  std::string found, advice;
  bool inside = false;
  for (const auto &[number, mesh] : sampled) {
    const std::vector<fvv_camera> cameras = cameras_at(plan.capture, number);
    if (cameras.empty() || mesh.faces.empty()) return false;
    const std::vector<Point> places = places_of(mesh);
    double largest = 0;
    for (const fvv_camera &camera : cameras) largest = std::max(largest, look(camera, places).side);
    // From inside, a body shows backs. A room that was filmed from inside shows fronts.
    inside = surrounds(mesh, cameras) && plan.winding.by_cameras && plan.winding.inside_out();
    if (inside)
      found = "all cameras are inside the mesh and see its back";
    else if (!plan.winding.by_cameras && largest > 0 && largest < least_pixels)
      found = fvv::format("the mesh measures %.2g pixels at most in the pictures", largest);
    else if (!plan.winding.by_cameras)
      found = "no camera sees the mesh";
    else
      return false;
    if (advice.empty()) advice = advice_for(cameras, places);
  }
  if (found.empty()) return false;
  plan.observer.warn(plan.capture.path + ": " + found +
                     ": expected meshes and cameras of one unit, with the same axes and origin" + advice +
                     (inside ? " (surroundings that were filmed from inside: " +
                                   option_name("winding", "flip") + " turns their faces round)"
                             : ""));
  return true;
}

namespace {

constexpr size_t most_searched = 64; // frames of a take in which a camera may see something

// Surface may cover a picture in which it has no vertex.
bool sees(const fvv_camera &camera, const geometry::Mesh &mesh, const std::vector<Point> &places) {
  if (look(camera, places).within) return true;
  constexpr uint32_t enough = 240; // pixels of the longer side
  const uint32_t longer = std::max(camera.width, camera.height);
  const auto side = [&](uint32_t size) {
    return longer <= enough ? size : std::max<uint32_t>(1, uint32_t(uint64_t(size) * enough / longer));
  };
  try {
    const std::vector<uint8_t> covered =
        geometry::ViewedSurface(mesh.positions, mesh.faces)
            .cover(geometry::resized(camera, side(camera.width), side(camera.height)));
    return std::any_of(covered.begin(), covered.end(), [](uint8_t value) { return value != 0; });
  } catch (const std::invalid_argument &) {
    return true; // the canonicaliser reports the error
  }
}

} // namespace

bool warn_of_blind_cameras(const Plan &plan, const std::vector<SampledMesh> &sampled) {
  const scene::Capture &capture = plan.capture;
  // Of frames in memory the take is not known yet.
  if (capture.memory || !plan.winding.by_cameras) return false;
  std::vector<size_t> blind;
  for (size_t i = 0; i < capture.cameras.size(); i++)
    if (capture.cameras[i].pictures) blind.push_back(i);
  const auto search = [&](int64_t number, const geometry::Mesh &mesh) {
    const std::vector<Point> places = places_of(mesh);
    blind.erase(std::remove_if(blind.begin(), blind.end(),
                               [&](size_t i) {
                                 const scene::Camera &camera = capture.cameras[i];
                                 return camera.is_calibrated(number) &&
                                        sees(camera.calibration_at(number), mesh, places);
                               }),
                blind.end());
  };
  for (const auto &[number, mesh] : sampled) search(number, mesh);
  // Who walks about a stage is not always in each picture.
  const std::vector<int64_t> numbers = capture.mesh_frames();
  const size_t count = std::min(most_searched, numbers.size());
  for (size_t k = 0; k < count && !blind.empty(); k++) {
    plan.observer.check_cancelled();
    const int64_t number = numbers[k * numbers.size() / count];
    search(number, frame_mesh(capture, number));
  }
  if (blind.empty()) return false;
  std::string names;
  std::vector<fvv_camera> cameras;
  for (const size_t i : blind) {
    const scene::Camera &camera = capture.cameras[i];
    names += (names.empty() ? "" : ", ") + scene::describe(camera);
    if (camera.is_calibrated(sampled.front().number))
      cameras.push_back(camera.calibration_at(sampled.front().number));
  }
  const std::vector<Point> places = places_of(sampled.front().mesh);
  const std::string advice = advice_for_cameras(cameras, places, "their poses");
  plan.observer.warn(capture.path + ": the mesh is in no picture of " + names + ", in " +
                     (numbers.size() > count ? fvv::format("%zu of %zu frames", count, numbers.size())
                                             : std::string("any frame")) +
                     ": expected poses of all cameras in the coordinates of the meshes" + advice);
  return true;
}

} // namespace fvv::mux
