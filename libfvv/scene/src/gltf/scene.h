// The drawn content of a glTF file as plain numbers: nodes, triangles, skins, and one animation. Everything
// is checked while it is read; posing it (pose.h) needs no file and cannot meet an index out of range.
#pragma once

#include "fvv_scene/mesh_file.h"
#include "fvv_scene/transform.h"
#include "scene/src/atlas/atlas.h"
#include "scene/src/gltf/accessor.h"

#include <array>
#include <optional>
#include <variant>

namespace fvv::scene::gltf {

constexpr uint32_t none = UINT32_MAX;

struct Node {
  std::optional<Transform> matrix; // in place of the three below
  double translation[3] = {0, 0, 0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
  std::vector<double> weights; // of morph targets; empty: those of the mesh
  uint32_t parent = none, mesh = none, skin = none;
};

struct Influence {
  uint32_t joint; // index among the joints of a skin
  double weight;  // > 0; those of a vertex add up to 1
};

struct Primitive {
  std::vector<double> positions;                   // 3 per vertex
  std::vector<double> texture;                     // 2 per vertex, or empty: not requested
  std::vector<double> normals;                     // 3 per vertex, or empty: not requested, or there are none
  std::vector<uint8_t> colours;                    // R G B per vertex, display values, or empty likewise
  std::vector<uint32_t> triangles;                 // 3 vertices each
  std::vector<std::vector<double>> targets;        // displacements like positions; empty: all zero
  std::vector<std::vector<double>> normal_targets; // of normals, likewise
  std::vector<size_t> first; // influences of vertex v: first[v] to first[v + 1]; empty: no joints
  std::vector<Influence> influences;
  uint32_t joint_count = 0;     // 1 + the highest joint
  std::optional<int64_t> image; // of the base colour, if the texture was requested and the material has one
  std::optional<int64_t> material;
  std::array<Wrap, 2> wrap = {Wrap::repeat, Wrap::repeat}; // of the image
  uint32_t picture = 0;                                    // in Scene::pictures
  // Of Texture::pictures: linear light that its picture or colour is multiplied with, and whether its
  // vertices have unlike colours besides, which are not shown.
  std::array<double, 3> tint = {1, 1, 1};
  bool has_unlike_colours = false;

  size_t vertex_count() const { return positions.size() / 3; }
};

struct MeshData {
  std::vector<Primitive> primitives;
  std::vector<double> weights; // one per morph target
  bool used = false;           // drawn by the scene; others are not read
};

// Channels of an animation (glTF 2.0 clause 3.11 and appendix C): keyframes of one property of one node.
enum class Path { translation, rotation, scale, weights };
enum class Interpolation { step, linear, cubic_spline };

struct Channel {
  uint32_t node;
  Path path;
  Interpolation interpolation;
  size_t width;               // numbers of a value
  std::vector<double> times;  // seconds, increasing
  std::vector<double> values; // width per time; cubic_spline: in-tangent, value, out-tangent
  std::string place;          // for messages

  // width numbers; before the first time and after the last one those of the nearest. Rotations come with
  // length 1; Error when one has no direction.
  std::vector<double> at(double time) const;
};

// sampler: an item of samplers. width 0: a channel of weights whose node has no morph targets.
Channel read_channel(Container &container, const JsonValue &channel, const JsonValue &samplers, Path path,
                     size_t width);

struct Skin {
  std::vector<uint32_t> joints; // nodes
  std::vector<Transform> inverse_bind;
};

struct Scene {
  std::string file; // for messages
  std::vector<Node> nodes;
  std::vector<uint32_t> order; // all nodes, parents first
  std::vector<uint32_t> drawn; // nodes of the scene that have a mesh, in the order of the file
  std::vector<MeshData> meshes;
  std::vector<Skin> skins;
  std::vector<Channel> channels; // of the chosen animation
  MeshReport report;
  std::string picture;       // bytes of the base colour image, if it was requested
  FacePictures pictures;     // likewise those of all primitives
  std::vector<bool> visible; // of each node: the default scene contains it
};

// Which animation of a file: none, or the only one, or one by index or name.
struct NoAnimation {};
struct OnlyAnimation {};
using AnimationChoice = std::variant<NoAnimation, OnlyAnimation, int64_t, std::string>;

// Appearance: not read; texture coordinates of one atlas, which must exist; its picture as well; coordinates
// wherever a material has a picture of its own; colours of vertices and materials.
// pictures: coordinates of unlike pictures, wherever a material has one, and all of these pictures.
enum class Texture { skipped, coordinates, picture, materials, colours, pictures };
inline Texture texture_for(bool coordinates, const MeshExtras *extras) {
  return coordinates ? (extras ? Texture::pictures : Texture::coordinates)
         : extras    ? Texture::colours
                     : Texture::skipped;
}

// bytes: the whole file. path: for messages, and the folder of its buffers. Error "path: POINTER: what".
// limits: max_vertices and max_faces hold for the scene as drawn.
Scene read_scene(std::string_view bytes, const std::string &path, const AnimationChoice &choice,
                 const fvv_limits &limits, Texture texture = Texture::skipped, bool normals = false);

// Whether no node of the file has a mesh. bytes: as above. false for what is no glTF file.
bool draws_nothing(std::string_view bytes, const std::string &path);

// One item of meshes (primitive.cpp).
MeshData read_mesh_data(Container &container, const JsonValue &mesh, MeshReport &report, Texture texture,
                        bool normals);

// The texture that gives a material its colours: the base colour, the diffuse colour of
// KHR_materials_pbrSpecularGlossiness, or what it emits.
std::optional<JsonValue> colour_texture(const JsonValue &material);

// The base colour of the material of a primitive.
struct BaseColour {
  std::optional<int64_t> image; // index among images
  std::array<Wrap, 2> wrap = {Wrap::repeat, Wrap::repeat};
  int64_t set = 0; // of texture coordinates: TEXCOORD_0, ...
  // Of these, by KHR_texture_transform: rows of a matrix, and what is added.
  std::array<std::array<double, 2>, 2> turn = {{{1, 0}, {0, 1}}};
  double offset[2] = {};

  void transform(std::vector<double> &texture) const;
};
// What is drawn has pictures that colours of its vertices are to be multiplied with, which are not one
// colour.
bool has_unlike_colours(std::string_view bytes, const std::string &path);

BaseColour read_base_colour(const Container &container, const JsonValue &primitive);

// What a material multiplies its colours with: R G B, linear; none where it says nothing.
std::optional<std::array<double, 3>> base_factor(const JsonValue &material);
uint8_t display_of_light(double light);

} // namespace fvv::scene::gltf
