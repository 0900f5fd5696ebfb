// What the mesh readers and writers share: growing a mesh within limits, splitting it at the seams of its
// atlas and at hard edges.
#pragma once

#include "fvv_scene/mesh_file.h"

namespace fvv::scene {

// Appends the fan of a polygon around its first corner. corners: at least 3 indices.
void append_fan(Mesh &mesh, const std::vector<uint32_t> &corners, MeshReport &report);

// Of 0 to white; grey for what is no number.
std::vector<uint8_t> display_colours(const std::vector<double> &values, double white);
// The white of colours that a file does not explain: 1, 255 or 65535. Light above white (a sum, a highlight,
// rounding) does not make all others bytes.
double white_of(const std::vector<double> &values, bool are_integers);

// A text without a byte order mark, and with LF where a file of old programs has CR alone. kept: where the
// bytes are then, if they differ.
std::string_view as_usual(std::string_view bytes, std::string &kept);

// Places of vertices that are not numbers (depth cameras write them for pixels without depth): 0 where no
// face uses the vertex, else Error.
void settle_unused(Mesh &mesh, const std::string &name);

// Gives every vertex one pair of texture coordinates, one normal, or both. texture: u v for each corner of
// mesh.faces, in their order, normals: x y z for each; or empty. A vertex keeps its place with the first pair
// and normal; copies for all others follow all vertices. Vertices that no face uses get (0, 0) and (0, 0, 0).
// Error when there would be more than limits.max_vertices.
void split_seams(Mesh &mesh, const std::vector<double> &texture, const std::vector<double> &normals,
                 const fvv_limits &limits, const std::string &name);

} // namespace fvv::scene
