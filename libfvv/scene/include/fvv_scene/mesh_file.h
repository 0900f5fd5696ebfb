// Triangle meshes from and to OBJ, PLY and Draco (DRC) files, and from glTF.
//
// OBJ and PLY have readers of their own here because existing ones are not strict: tinyobjloader silently
// turns a number that it cannot read into 0, and Debian packages no PLY library that checks counts against
// the file before it allocates. A capture of thousands of files needs an error that names file, line and what
// was expected. Draco files go through libdraco, glTF through gltf/.
//
// Every function throws Error (capture/file.h). Vertices and faces in messages of PLY and DRC count from 0,
// in messages of OBJ from 1, as in the files.
#pragma once

#include "fvv/types.h"
#include "fvv_cxx/error.h"
#include "fvv_geometry/mesh.h"
#include "fvv_media/memory_limit.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::scene {

using geometry::Lattice;
using geometry::Mesh;

// What a reader changed or left out. All zero: the file had only triangles.
struct MeshReport {
  uint64_t polygons =
      0; // faces of more than 3 corners: a fan around the first one, or ears if that leaves them
  uint64_t self_crossing = 0; // those of them that cross themselves, whose fan is kept
  uint64_t lines_and_points =
      0;                   // elements l and p of OBJ, faces of 2 corners, such primitives of glTF, left out
  uint64_t untextured = 0; // triangles of OBJ without coordinates in the picture of their material
};

// What a reader of meshes finds besides, where a caller asks for it.
struct MeshExtras {
  // R G B of each vertex, display values; empty: the file has none. Only without texture coordinates and
  // normals, whose seams split vertices.
  std::vector<uint8_t> colours;
};

// A mesh at the default limits, as text with normals and texture coordinates, stays below this.
constexpr uint64_t max_mesh_file = uint64_t(1) << 30;
// Of the file of a picture that it brings: a PNG of 8192 x 8192 that does not compress.
constexpr uint64_t max_mesh_picture = uint64_t(1) << 28;

// Readers. bytes: the whole file. name: of the file, for messages. limits NULL: the defaults of libfvv;
// max_vertices and max_faces (after triangulation and splitting) are honoured. report may be NULL.
//
// texture: fills Mesh::texture, and a file that lacks coordinates for any corner of a face is an error;
// otherwise they are skipped. normals: fills Mesh::normals, which stays empty if the file lacks
// one for any corner. Where a vertex has several pairs or normals, at the seams of an atlas or at hard edges,
// it is split: it keeps its place with the attributes of the first face, and copies with the others follow
// all vertices of the file. extras: NULL, or filled.
//
// OBJ: v (3 or 4 numbers, 6 or 7 with colours; weight and opacity are dropped; colours go to 1, or to 255 if
// most are above 1; grey where they are no numbers or a vertex has none; else Kd of materials without
// pictures), f (v, v/vt, v//vn, v/vt/vn,
// negative indices, vertices defined later), vt (v points up), vn, comments, line continuation. Groups and
// display attributes are skipped; free-form curves and surfaces, included files and unknown keywords are
// errors. Materials: parse_obj_materials.
Mesh parse_obj(std::string_view bytes, const std::string &name, const fvv_limits *limits = nullptr,
               MeshReport *report = nullptr, bool texture = false, bool normals = false,
               MeshExtras *extras = nullptr);

// The files that the faces of an OBJ file take their colours from.
struct ObjMaterials {
  std::vector<std::string> libraries; // .mtl files, as paths; none where no face has a material
  // map_Kd (else map_Ka or map_Ke) of the materials of all faces, as a path; none where they have none. Where
  // no face has a material of the libraries, the only picture that these name.
  std::optional<std::string> picture;
  std::vector<std::string>
      missing; // sentences on what may be why there is no picture, without the file's name
};
// name: also the path in whose folder, or below, the libraries are. The picture is there too, or directly in
// a folder beside that. Unlike pictures, and a picture for some faces only, are an error.
ObjMaterials parse_obj_materials(std::string_view bytes, const std::string &name);

// PLY 1.0, ascii, binary_little_endian and binary_big_endian: element vertex with x, y, z; element face with
// list vertex_indices or vertex_index. Texture coordinates, v up: the first of a list texcoord of the faces
// (u v for each corner), texture_u and texture_v, s and t, u and v of the vertices; faces of unlike texnumber
// are an error. Normals: nx, ny, nz of the vertices. Colours: red, green, blue (or diffuse_red ..., r, g, b)
// of the vertices, else of the faces, of which a vertex takes the mean. Other elements and properties are
// skipped, in any order.
// Counts are compared with the size of the file before anything is allocated. ASCII: one element per line.
Mesh parse_ply(std::string_view bytes, const std::string &name, const fvv_limits *limits = nullptr,
               MeshReport *report = nullptr, bool texture = false, bool normals = false,
               MeshExtras *extras = nullptr);
// Draco bitstream 2.2, triangular mesh, positions as float32 (quantised or not) or int32, texture coordinates
// as float32 of the first attribute TEX_COORD (v points up), normals as float32 of the first attribute
// NORMAL, colours of the first attribute COLOR. Hostile input: the counts of the header are compared with
// limits and with the size of the file before decoding, and again with the result; but libdraco allocates for
// other attributes (normals, colours) by their description, up to some gigabytes for a forged file. Run it on
// untrusted files only under a memory limit.
Mesh parse_drc(std::string_view bytes, const std::string &name, const fvv_limits *limits = nullptr,
               MeshReport *report = nullptr, bool texture = false, bool normals = false,
               MeshExtras *extras = nullptr);

// glTF 2.0, GLB or JSON: all triangles of the default scene with the transforms of its nodes, skins and morph
// targets without animation. name: also the path in whose folder external buffers lie. Errors name the place
// as a JSON pointer. Memory for a hostile file stays below 1 GiB and 64 times its size. Texture coordinates
// (v points down): the set that the base colour of the material names, else the first, with
// KHR_texture_transform; base colours from unlike images are an error. Colours: COLOR_0
// times the base colour's factor, from linear light to display values.
Mesh parse_gltf(std::string_view bytes, const std::string &name, const fvv_limits *limits = nullptr,
                MeshReport *report = nullptr, bool texture = false, bool normals = false,
                MeshExtras *extras = nullptr);
// The bytes of the base colour image (PNG or JPEG, not decoded) of all that the default scene
// of a glTF file draws: out of the file, or of a file in its folder or below.
std::string parse_gltf_picture(std::string_view bytes, const std::string &name);

struct MeshPicture {
  std::string bytes, name; // name: for messages
};
// The picture that a mesh file brings, PNG, JPEG, WebP or OpenEXR, not decoded: parse_gltf_picture, or the
// file that parse_obj_materials finds. Error for other formats, and where there is none.
// limit: of decoding each of several pictures, which are packed into one.
MeshPicture read_mesh_picture(const std::string &path, const media::MemoryLimit &limit = {});
// Of the picture that a mesh file brings.
struct AtlasSize {
  uint32_t width = 0, height = 0;
  double scale = 1; // of the pictures that are packed into it; below 1 where they are too large together
};
// Of that of read_mesh_picture, without decoding it. Throws Error.
AtlasSize mesh_picture_size(const std::string &path);
bool may_bring_picture(const std::string &path); // by its extension: glTF and OBJ

// MemoryError when reading a mesh file would take more than limit: the file, and what its size can declare.
void check_mesh_memory(const std::string &path, const media::MemoryLimit &limit);

// Reads .obj, .ply, .drc or .draco, .glb or .gltf by the extension (any case) of path; other extensions are
// an error.
Mesh read_mesh(const std::string &path, const fvv_limits *limits = nullptr, MeshReport *report = nullptr,
               bool texture = false, bool normals = false, MeshExtras *extras = nullptr);
bool is_gltf(const std::string &path); // by its extension
// Whether a file says that there is nothing: a PLY file whose header declares 0 vertices and no face, an OBJ
// file without any v and f, or a glTF file no node of which has a mesh. read_mesh refuses such a file. false
// for every other file, and for none.
bool is_empty_mesh(const std::string &path);

// Writers: the bytes of a file, the same for the same mesh everywhere. name: of the file, for messages.
// Refused: coordinates that are not finite, indices out of range, a mesh without faces. Texture coordinates
// are written on the axes of the format, and normals, if the mesh has some. colours: R G B of each vertex,
// display values, or empty.
//
// OBJ: the shortest decimals that read back as the same doubles; a vt and a vn for each v; colours behind the
// coordinates, as fractions.
std::string format_obj(const Mesh &mesh, const std::string &name, const std::vector<uint8_t> &colours = {});
// PLY: binary_little_endian, properties double (x y z, nx ny nz, s t): float would move vertices, and a
// stream that is unpacked and packed again must give the same lattice points. Colours are uchar.
std::string format_ply(const Mesh &mesh, const std::string &name, const std::vector<uint8_t> &colours = {});
// DRC: float32 positions as Draco readers expect them, not quantised, order of vertices and faces kept
// (sequential coding). A float32 errs by far less than half a step while |coordinate| / step < 2^22: every
// coordinate is verified to fall onto the same lattice point again, the first that does not is an error.
// Texture coordinates are float32 too, which holds texture indices of all sizes exactly, and normals.
std::string format_drc(const Mesh &mesh, const Lattice &lattice, const std::string &name);

// OBJ, PLY or DRC by the extension of name. lattice matters to DRC only, which has no colours.
std::string format_mesh(const Mesh &mesh, const Lattice &lattice, const std::string &name,
                        const std::vector<uint8_t> &colours = {});
// The same into a file.
void write_mesh(const Mesh &mesh, const Lattice &lattice, const std::string &path);

} // namespace fvv::scene
