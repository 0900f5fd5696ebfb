#include "scene/src/atlas/tile_cut.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace fvv::scene {

namespace {

constexpr double farthest = 1e9;          // of a texture coordinate: whole numbers stay exact
constexpr double most_pieces = 65536;     // of a face: a floor of 256 x 256 tiles
constexpr size_t most_edge_points = 4096; // of an edge, by the faces on all of its sides
constexpr double same_part = 1e-9;        // of an edge: cuts that are closer than this are one
constexpr double no_area = 1e-13;         // of a face

struct Corner {
  uint32_t vertex;
  double uv[2];
  double weight[3]; // of the corners of the whole face
};
using Polygon = std::vector<Corner>;

// Twice the area, as a part of that of the whole face.
double area_of(const Corner &a, const Corner &b, const Corner &c) {
  const double(&p)[3] = a.weight, (&q)[3] = b.weight, (&r)[3] = c.weight;
  return p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) +
         p[2] * (q[0] * r[1] - q[1] * r[0]);
}

Corner between(const Corner &a, const Corner &b, double part, uint32_t vertex) {
  Corner out = {vertex, {}, {}};
  for (size_t k = 0; k < 2; k++) out.uv[k] = a.uv[k] + part * (b.uv[k] - a.uv[k]);
  for (size_t k = 0; k < 3; k++) out.weight[k] = a.weight[k] + part * (b.weight[k] - a.weight[k]);
  return out;
}

// An edge by the places of its ends, the lower one first; by its vertices where these are one place.
struct Edge {
  std::array<uint32_t, 4> key;
  uint32_t from, to; // vertices

  Edge(uint32_t a, uint32_t b, const std::vector<uint32_t> &place) {
    const bool turned = std::pair(place[a], a) > std::pair(place[b], b);
    from = turned ? b : a;
    to = turned ? a : b;
    const bool is_point = place[a] == place[b];
    key = {place[from], place[to], is_point ? from : 0, is_point ? to : 0};
  }
};

class TileCutter {
public:
  TileCutter(const Mesh &of, const std::vector<double> &coordinates,
             const std::vector<std::array<TileBorders, 2>> &of_faces, double snap_to,
             const fvv_limits &bounds, const std::string &file)
      : mesh(of), texture(coordinates), borders(of_faces), snap(snap_to), limits(bounds), name(file) {}

  TileCut run(const std::vector<double> &places) {
    bool any = false;
    for (size_t face = 0; face < mesh.face_count(); face++) any = is_cut(face) || any;
    if (any) {
      find_places(places);
      find_edge_points();
    }
    for (size_t face = 0; face < mesh.face_count(); face++) cut(face);
    return std::move(out);
  }

private:
  [[noreturn]] void fail(size_t face, const std::string &what) const {
    throw Error(name + ": face " + std::to_string(face) + ": " + what +
                ": bake the picture into an atlas, or do without (" + option_name("atlas", "none") + ")");
  }

  double snapped(double value) const {
    const double whole = std::round(value);
    return std::abs(value - whole) <= snap ? whole : value;
  }
  double at(size_t face, size_t corner, size_t axis) const {
    return snapped(texture[6 * face + 2 * corner + axis]);
  }

  // Calls visit with the borders strictly between two coordinates, rising.
  template <class Visit> void lines(size_t face, size_t axis, double a, double b, const Visit &visit) const {
    const TileBorders which = borders[face][axis];
    if (which == TileBorders::none) return;
    double first = std::floor(std::min(a, b)) + 1, last = std::ceil(std::max(a, b)) - 1;
    if (which == TileBorders::own) {
      first = std::max(first, 0.0);
      last = std::min(last, 1.0);
    }
    for (double line = first; line <= last; line++) visit(line);
  }

  bool is_cut(size_t face) const {
    double pieces = 1;
    for (size_t axis = 0; axis < 2; axis++) {
      if (borders[face][axis] == TileBorders::none) continue;
      const double u[3] = {at(face, 0, axis), at(face, 1, axis), at(face, 2, axis)};
      for (const double value : u)
        if (!(std::abs(value) <= farthest))
          fail(face, "expected texture coordinates of -1e9 to 1e9, found others");
      const double low = std::min({u[0], u[1], u[2]}), high = std::max({u[0], u[1], u[2]});
      const bool own = borders[face][axis] == TileBorders::own;
      const double first = own ? std::max(std::floor(low) + 1, 0.0) : std::floor(low) + 1,
                   last = own ? std::min(std::ceil(high) - 1, 1.0) : std::ceil(high) - 1;
      pieces *= std::max(0.0, last - first + 1) + 1;
    }
    if (pieces > most_pieces)
      fail(face, "its picture repeats on it " + std::to_string(uint64_t(pieces)) + " times, at most " +
                     std::to_string(uint64_t(most_pieces)) + " pieces are allowed");
    return pieces > 1;
  }

  void find_places(const std::vector<double> &places) {
    std::map<std::array<double, 3>, uint32_t> known;
    for (size_t v = 0; v < mesh.vertex_count(); v++)
      place.push_back(known
                          .emplace(std::array{places[3 * v], places[3 * v + 1], places[3 * v + 2]},
                                   uint32_t(known.size()))
                          .first->second);
  }

  // Where the borders cross the edges, from all faces, so that neighbours agree.
  void find_edge_points() {
    for (size_t face = 0; face < mesh.face_count(); face++)
      for (size_t c = 0; c < 3; c++) {
        const Edge edge = edge_of(face, c);
        for (size_t axis = 0; axis < 2; axis++)
          own_parts(face, c, edge, axis, [&](double, double part) {
            points[edge.key].push_back(part);
            if (++point_count > limits.max_vertices) fail_vertices();
          });
      }
    for (auto &[key, parts] : points) {
      std::sort(parts.begin(), parts.end());
      size_t kept = 0;
      for (const double part : parts)
        if (!kept || part - parts[kept - 1] > same_part) parts[kept++] = part;
      parts.resize(kept);
    }
  }

  Edge edge_of(size_t face, size_t corner) const {
    return Edge(mesh.faces[3 * face + corner], mesh.faces[3 * face + (corner + 1) % 3], place);
  }

  // Calls visit with each border that crosses an edge of a face, and the part of the edge that is before it.
  template <class Visit>
  void own_parts(size_t face, size_t corner, const Edge &edge, size_t axis, const Visit &visit) const {
    const bool forth = mesh.faces[3 * face + corner] == edge.from;
    const double a = at(face, corner, axis), b = at(face, (corner + 1) % 3, axis);
    const double from = forth ? a : b, to = forth ? b : a;
    lines(face, axis, a, b, [&](double line) { visit(line, (line - from) / (to - from)); });
  }

  [[noreturn]] void fail_vertices() const {
    throw Error(name + ": more than the allowed " + std::to_string(limits.max_vertices) +
                " vertices, cut where pictures repeat");
  }

  uint32_t add(uint32_t from, uint32_t to, double part) {
    const size_t next = mesh.vertex_count() + out.added.size();
    if (next >= limits.max_vertices) fail_vertices();
    out.added.push_back({from, to, part});
    return uint32_t(next);
  }

  // The corners of a face, and the points on its edges.
  Polygon outline(size_t face, bool cut) {
    Corner corner[3];
    for (size_t c = 0; c < 3; c++) {
      corner[c] = {mesh.faces[3 * face + c], {}, {}};
      corner[c].weight[c] = 1;
      for (size_t axis = 0; axis < 2; axis++)
        corner[c].uv[axis] = cut ? at(face, c, axis) : texture[6 * face + 2 * c + axis];
    }
    Polygon polygon;
    for (size_t c = 0; c < 3; c++) {
      polygon.push_back(corner[c]);
      if (place.empty()) continue;
      const Edge edge = edge_of(face, c);
      const auto found = points.find(edge.key);
      if (found == points.end()) continue;
      const std::vector<double> &parts = found->second;
      if (parts.size() > most_edge_points)
        fail(face, "pictures repeat beside it " + std::to_string(parts.size()) + " times, at most " +
                       std::to_string(most_edge_points) + " points on an edge are allowed");
      const bool forth = corner[c].vertex == edge.from;
      const Corner &from = forth ? corner[c] : corner[(c + 1) % 3],
                   &to = forth ? corner[(c + 1) % 3] : corner[c];
      std::vector<uint32_t> &vertices = edge_vertices[{edge.from, edge.to}];
      if (vertices.empty())
        for (const double part : parts) vertices.push_back(add(edge.from, edge.to, part));
      Polygon side;
      for (size_t i = 0; i < parts.size(); i++) side.push_back(between(from, to, parts[i], vertices[i]));
      for (size_t axis = 0; axis < 2; axis++)
        own_parts(face, c, edge, axis, [&](double line, double part) {
          size_t i = size_t(std::lower_bound(parts.begin(), parts.end(), part) - parts.begin());
          if (i == parts.size() || (i && part - parts[i - 1] <= same_part)) i--;
          side[i].uv[axis] = line;
        });
      if (!forth) std::reverse(side.begin(), side.end());
      polygon.insert(polygon.end(), side.begin(), side.end());
    }
    return polygon;
  }

  // The parts of a convex polygon below and above a border.
  std::pair<Polygon, Polygon> split(const Polygon &polygon, size_t axis, double line) {
    std::pair<Polygon, Polygon> parts;
    for (size_t i = 0; i < polygon.size(); i++) {
      const Corner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      const double here = a.uv[axis], next = b.uv[axis];
      if (here <= line) parts.first.push_back(a);
      if (here >= line) parts.second.push_back(a);
      if (std::min(here, next) < line && std::max(here, next) > line) {
        const Corner middle = crossing(a, b, axis, line);
        parts.first.push_back(middle);
        parts.second.push_back(middle);
      }
    }
    return parts;
  }

  // The same vertex for the pieces on both sides.
  Corner crossing(const Corner &one, const Corner &other, size_t axis, double line) {
    const Corner &a = one.vertex < other.vertex ? one : other, &b = one.vertex < other.vertex ? other : one;
    const double part = (line - a.uv[axis]) / (b.uv[axis] - a.uv[axis]);
    const auto [known, is_new] = crossings.emplace(std::tuple(a.vertex, b.vertex, axis), 0);
    if (is_new) known->second = add(a.vertex, b.vertex, part);
    Corner middle = between(a, b, part, known->second);
    middle.uv[axis] = line;
    return middle;
  }

  // Calls visit with the pieces of a polygon between the borders of one axis.
  template <class Visit> void strips(size_t face, Polygon polygon, size_t axis, const Visit &visit) {
    double low = polygon[0].uv[axis], high = low;
    for (const Corner &corner : polygon) {
      low = std::min(low, corner.uv[axis]);
      high = std::max(high, corner.uv[axis]);
    }
    lines(face, axis, low, high, [&](double line) {
      std::pair<Polygon, Polygon> parts = split(polygon, axis, line);
      visit(std::move(parts.first));
      polygon = std::move(parts.second);
    });
    visit(std::move(polygon));
  }

  void cut(size_t face) {
    const bool is_whole = !is_cut(face);
    Polygon whole = outline(face, !is_whole);
    crossings.clear();
    if (is_whole) {
      triangulate(face, std::move(whole));
      return;
    }
    strips(face, std::move(whole), 0, [&](Polygon strip) {
      strips(face, std::move(strip), 1, [&](Polygon piece) { triangulate(face, std::move(piece)); });
    });
  }

  void append(size_t face, const Corner &a, const Corner &b, const Corner &c) {
    if (out.whole.size() >= limits.max_faces)
      throw Error(name + ": more than the allowed " + std::to_string(limits.max_faces) +
                  " faces, cut where pictures repeat");
    out.whole.push_back(uint32_t(face));
    for (const Corner *corner : {&a, &b, &c}) {
      out.faces.push_back(corner->vertex);
      out.texture.insert(out.texture.end(), corner->uv, corner->uv + 2);
    }
  }

  // A convex polygon, some of whose corners are on its sides: ears, the largest first, but never so that the
  // rest is a line.
  void triangulate(size_t face, Polygon polygon) {
    double left = 0;
    for (size_t i = 1; i + 1 < polygon.size(); i++) left += area_of(polygon[0], polygon[i], polygon[i + 1]);
    while (polygon.size() > 3) {
      const size_t n = polygon.size();
      size_t best = 1;
      double most = 0;
      for (size_t i = 0; i < n; i++) {
        const double area = area_of(polygon[(i + n - 1) % n], polygon[i], polygon[(i + 1) % n]);
        if (area > most && left - area > no_area) {
          most = area;
          best = i;
        }
      }
      append(face, polygon[(best + n - 1) % n], polygon[best], polygon[(best + 1) % n]);
      left -= most;
      polygon.erase(polygon.begin() + std::ptrdiff_t(best));
    }
    if (polygon.size() == 3) append(face, polygon[0], polygon[1], polygon[2]);
  }

  const Mesh &mesh;
  const std::vector<double> &texture;
  const std::vector<std::array<TileBorders, 2>> &borders;
  const double snap;
  const fvv_limits &limits;
  const std::string &name;
  std::vector<uint32_t> place; // of each vertex: vertices at one place have one number; empty: nothing is cut
  std::map<std::array<uint32_t, 4>, std::vector<double>> points; // of edges: the parts before each, rising
  size_t point_count = 0;
  std::map<std::pair<uint32_t, uint32_t>, std::vector<uint32_t>> edge_vertices; // of the same
  std::map<std::tuple<uint32_t, uint32_t, size_t>, uint32_t> crossings;         // within a face
  TileCut out;
};

} // namespace

TileCut cut_at_tiles(const Mesh &mesh, const std::vector<double> &texture,
                     const std::vector<std::array<TileBorders, 2>> &borders,
                     const std::vector<double> &places, double snap, const fvv_limits &limits,
                     const std::string &name) {
  return TileCutter(mesh, texture, borders, snap, limits, name).run(places);
}

void apply_cut(const TileCut &cut, Mesh &mesh) {
  mesh.faces = cut.faces;
  const auto value = [&](std::vector<double> &values, const TileCut::Vertex &vertex, size_t axis) {
    const double from = values[3 * size_t(vertex.from) + axis], to = values[3 * size_t(vertex.to) + axis];
    return from + vertex.part * (to - from);
  };
  for (const TileCut::Vertex &vertex : cut.added)
    for (size_t axis = 0; axis < 3; axis++) mesh.positions.push_back(value(mesh.positions, vertex, axis));
  for (const TileCut::Vertex &vertex : cut.added) {
    if (mesh.normals.empty()) break;
    double normal[3];
    for (size_t axis = 0; axis < 3; axis++) normal[axis] = value(mesh.normals, vertex, axis);
    const double length = std::hypot(normal[0], normal[1], normal[2]);
    for (const double part : normal) mesh.normals.push_back(length > 0 ? part / length : 0);
  }
}

} // namespace fvv::scene
