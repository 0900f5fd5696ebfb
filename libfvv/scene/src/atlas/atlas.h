// The pictures that the faces of one mesh show, and how several of them become one atlas.
#pragma once

#include "fvv_scene/mesh_file.h"

#include <array>
#include <functional>
#include <string>
#include <vector>

namespace fvv::scene {

// What a picture shows beyond its borders.
enum class Wrap { repeat, mirror, clamp };

// What some faces of a mesh show: a picture, or one colour.
struct FacePicture {
  std::string name;                            // for messages; a file's path
  std::function<std::string()> load = nullptr; // its bytes; none: it is one colour
  std::array<uint8_t, 3> colour = {};          // display values; with a picture: of faces that cannot show it
  bool has_colour = false;                     // the file says which
  std::array<double, 3> tint = {1, 1, 1};      // linear light that the picture is multiplied with
  std::array<Wrap, 2> wrap = {Wrap::repeat, Wrap::repeat};

  bool is_colour() const { return !load; }
  bool is_tinted() const { return tint != std::array<double, 3>{1, 1, 1}; }
};

// pictures: each once. of_face: an index of them for each face of a mesh; empty: all show the first.
struct FacePictures {
  std::vector<FacePicture> pictures;
  std::vector<uint32_t> of_face;
  media::MemoryLimit limit = {}; // of decoding one of them
  bool bake_repeats = false;     // cut faces on which one of them repeats

  size_t add(FacePicture picture, const std::string &key); // its index; one with a known key is not added
  const FacePicture *of(size_t face) const;                // NULL: one that is not known
  // The others show something only where there is a picture.
  bool has_picture() const;
  // Takes over what a mesh shows; how it is to be treated stays.
  void replace_pictures(FacePictures other);

private:
  std::vector<std::string> keys;
};

struct AtlasPlace {
  uint32_t x, y, width, height; // pixels
};

struct AtlasLayout {
  uint32_t width = 0, height = 0;
  double scale = 1;               // of all pictures; below 1 where they are too large together
  std::vector<AtlasPlace> places; // as FacePictures::pictures
};

// Of several pictures, or a picture and colours. The same on every machine. Throws Error.
AtlasLayout lay_out_atlas(const FacePictures &faces, const std::string &name);

// Of atlas_picture, by the headers of the pictures. Throws Error.
AtlasSize atlas_size(const FacePictures &faces, const std::string &name);

// The bytes of the picture that the mesh shows: of the only one as they are, if it has no tint, else a PNG
// file. Throws Error.
std::string atlas_picture(const FacePictures &faces, const std::string &name);

// Brings texture coordinates into 0 to 1, and onto the atlas if there are several pictures: a shift by whole
// pictures is exact where they repeat, what lies outside by less than can be seen is rounded. Vertices are
// split where faces are shifted unlike. A face on which its picture repeats is cut where that begins again,
// if faces.bake_repeats is set; else it is an Error. rest: of a mesh that is animated, x y z of its vertices
// by which the cuts of neighbours meet; empty: those of the mesh.
void settle_texture(Mesh &mesh, const FacePictures &faces, const fvv_limits &limits, const std::string &name,
                    const std::vector<double> &rest = {});

// The readers of mesh files with texture coordinates of unlike pictures, which they had before
// settle_texture. Faces that show a colour alone may lack them.
Mesh parse_obj_pictures(std::string_view bytes, const std::string &name, const fvv_limits *limits,
                        MeshReport *report, bool normals, FacePictures &faces);
Mesh parse_ply_pictures(std::string_view bytes, const std::string &name, const fvv_limits *limits,
                        MeshReport *report, bool normals, FacePictures &faces);
Mesh parse_gltf_pictures(std::string_view bytes, const std::string &name, const fvv_limits *limits,
                         MeshReport *report, bool normals, FacePictures &faces);
// The names after "comment TextureFile" in the header of a PLY file, and whether it has texture coordinates.
struct PlyPictures {
  std::vector<std::string> names;
  bool has_coordinates = false;
};
PlyPictures ply_pictures(std::string_view bytes, const std::string &name);
// A mesh file by the extension of path, as it is, and with texture coordinates of one picture that another
// file has.
Mesh parse_mesh(const std::string &path, const fvv_limits *limits, MeshReport *report, bool texture,
                bool normals, MeshExtras *extras = nullptr);
Mesh read_mesh_texture(const std::string &path, const fvv_limits *limits, MeshReport *report, bool normals,
                       bool bake_repeats);
// By the extension of path, which may bring a picture.
Mesh read_mesh_pictures(const std::string &path, const fvv_limits *limits, MeshReport *report, bool normals,
                        FacePictures &faces);

} // namespace fvv::scene
