#include "scene/src/atlas/atlas.h"
#include "fvv_cxx/untrusted.h"
#include "fvv_geometry/rect_pack.h"
#include "fvv_media/colour.h"
#include "fvv_media/image.h"
#include "fvv_scene/file_io.h"
#include "scene/src/atlas/tile_cut.h"
#include "scene/src/mesh_build.h"

#include <algorithm>
#include <cmath>

namespace fvv::scene {

namespace {

constexpr uint32_t block = 16;       // of a video: blocks of unlike pictures do not mix
constexpr uint32_t border = 8;       // pixels around each picture that continue it
constexpr uint32_t swatch = 16;      // side of a colour without a picture
constexpr uint32_t most_side = 8192; // of an atlas: what browsers draw
// Of a picture: less than a texel of the largest that are usual, where clamped and repeated ones look alike.
constexpr double rounding = 5e-5;

struct Size {
  uint32_t width, height;
};

// Of a format that is read.
std::string load(const FacePicture &picture) {
  std::string bytes = picture.load();
  const std::string why =
      media::why_no_picture(reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size());
  if (!why.empty())
    throw Error(picture.name + ": " + why + ": convert it, or name another picture (" +
                option_name("atlas", "FILE") + ")");
  return bytes;
}

// Multiplied as light, which the display values of a picture are not.
void apply_tint(const std::array<double, 3> &tint, media::Image &image) {
  uint8_t tinted[3][256];
  for (size_t k = 0; k < 3; k++)
    for (size_t value = 0; value < 256; value++) {
      const double light = media::linear_of_srgb(double(value) / 255) * tint[k];
      tinted[k][value] = uint8_t(std::floor(255 * media::srgb_of_linear(std::clamp(light, 0.0, 1.0)) + 0.5));
    }
  for (size_t i = 0; i < image.pixels.size(); i++) image.pixels[i] = tinted[i % 3][image.pixels[i]];
}

media::Image decoded(const FacePicture &picture, const media::MemoryLimit &limit) {
  const std::string bytes = load(picture);
  media::check_image_memory(reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size(), picture.name,
                            limit);
  media::Image image = media::decode_image<uint8_t>(reinterpret_cast<const uint8_t *>(bytes.data()),
                                                    bytes.size(), 3, picture.name);
  if (picture.is_tinted()) apply_tint(picture.tint, image);
  return image;
}

// A place for each size, with room around it. Height 0: they do not fit into the width.
AtlasLayout packed(const std::vector<Size> &sizes, uint32_t width) {
  std::vector<stbrp_node> nodes(width / block);
  std::vector<stbrp_rect> rects;
  const auto blocks = [](uint32_t side) { return int((side + 2 * border + block - 1) / block); };
  for (const Size &size : sizes)
    rects.push_back({int(rects.size()), blocks(size.width), blocks(size.height), 0, 0, 0});
  stbrp_context context;
  stbrp_init_target(&context, int(width / block), int(most_side / block), nodes.data(), int(nodes.size()));
  AtlasLayout out;
  if (!stbrp_pack_rects(&context, rects.data(), int(rects.size()))) return out;
  out.width = width;
  for (size_t i = 0; i < sizes.size(); i++) {
    out.height = std::max(out.height, uint32_t(rects[i].y + rects[i].h) * block);
    out.places.push_back({uint32_t(rects[i].x) * block + border, uint32_t(rects[i].y) * block + border,
                          sizes[i].width, sizes[i].height});
  }
  return out;
}

// The one with the fewest pixels of a few widths.
AtlasLayout best_of(const std::vector<Size> &sizes) {
  AtlasLayout best;
  double area = 0, widest = 0;
  for (const Size &size : sizes) {
    area += double(size.width + 2 * border) * (size.height + 2 * border);
    widest = std::max(widest, double(size.width + 2 * border));
  }
  for (const double times : {1.0, 1.1, 1.25, 1.5, 2.0, 2.5}) {
    const double side = std::ceil(std::max(std::sqrt(area) * times, widest) / block) * block;
    AtlasLayout one = packed(sizes, uint32_t(std::clamp(side, double(block), double(most_side))));
    const auto pixels = [](const AtlasLayout &of) { return uint64_t(of.width) * of.height; };
    if (one.height && (!best.height || pixels(one) < pixels(best))) best = std::move(one);
  }
  return best;
}

AtlasLayout lay_out(const std::vector<Size> &sizes, const std::string &name) {
  for (const double scale : {1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125, 0.0625}) {
    std::vector<Size> scaled;
    const auto side = [&](uint32_t size) { return std::max(1u, uint32_t(std::lround(size * scale))); };
    for (const Size &size : sizes)
      scaled.push_back(size.width == swatch ? size : Size{side(size.width), side(size.height)});
    AtlasLayout out = best_of(scaled);
    out.scale = scale;
    if (out.height) return out;
  }
  throw Error(name + ": " + std::to_string(sizes.size()) + " pictures do not fit into an atlas of " +
              std::to_string(most_side) + "x" + std::to_string(most_side) + " pixels: bake one of them");
}

Size size_of(const FacePicture &picture) {
  if (picture.is_colour()) return {swatch, swatch};
  const std::string bytes = load(picture);
  const media::ImageInfo info =
      media::probe_image(reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size(), picture.name);
  return {info.width, info.height};
}

// Puts a picture at its place and continues its border around it.
void put(const media::Image &picture, const AtlasPlace &place, media::Image &atlas) {
  for (int64_t y = -int64_t(border); y < int64_t(place.height + border); y++)
    for (int64_t x = -int64_t(border); x < int64_t(place.width + border); x++) {
      const int64_t column = std::clamp<int64_t>(x, 0, place.width - 1),
                    row = std::clamp<int64_t>(y, 0, place.height - 1);
      const size_t to = size_t(int64_t(place.y) + y) * atlas.width + size_t(int64_t(place.x) + x);
      std::copy_n(&picture.pixels[3 * (size_t(row) * picture.width + size_t(column))], 3,
                  &atlas.pixels[3 * to]);
    }
}

// One coordinate of the three corners of a face.
class FaceAxis {
public:
  FaceAxis(double a, double b, double c) : low(std::min({a, b, c})), high(std::max({a, b, c})) {}

  bool is_inside() const { return low >= 0 && high <= 1; }
  // Of whole pictures, that brings them into 0 to 1.
  double shift() const {
    const double whole = std::floor(low);
    // What ends at the next picture's beginning, but for rounding, begins there.
    return low - whole > 1 - rounding && high - whole > 1 + rounding ? whole + 1 : whole;
  }
  bool fits(double whole) const { return low - whole >= -rounding && high - whole <= 1 + rounding; }

  double low, high;
};

std::string range_text(const FaceAxis &axis) {
  std::string low, high;
  append_double(low, axis.low);
  append_double(high, axis.high);
  return low + " to " + high;
}

} // namespace

size_t FacePictures::add(FacePicture picture, const std::string &key) {
  const auto known = std::find(keys.begin(), keys.end(), key);
  if (known != keys.end()) return size_t(known - keys.begin());
  keys.push_back(key);
  pictures.push_back(std::move(picture));
  return pictures.size() - 1;
}

const FacePicture *FacePictures::of(size_t face) const {
  return pictures.empty() ? nullptr : &pictures[pictures.size() > 1 ? of_face[face] : 0];
}

bool FacePictures::has_picture() const {
  return std::any_of(pictures.begin(), pictures.end(),
                     [](const FacePicture &one) { return !one.is_colour(); });
}

void FacePictures::replace_pictures(FacePictures other) {
  pictures = std::move(other.pictures);
  of_face = std::move(other.of_face);
  keys = std::move(other.keys);
}

AtlasLayout lay_out_atlas(const FacePictures &faces, const std::string &name) {
  std::vector<Size> sizes;
  for (const FacePicture &picture : faces.pictures) sizes.push_back(size_of(picture));
  return lay_out(sizes, name);
}

AtlasSize atlas_size(const FacePictures &faces, const std::string &name) {
  if (faces.pictures.size() == 1) {
    const Size own = size_of(faces.pictures[0]);
    return {own.width, own.height, 1};
  }
  const AtlasLayout layout = lay_out_atlas(faces, name);
  return {layout.width, layout.height, layout.scale};
}

std::string atlas_picture(const FacePictures &faces, const std::string &name) {
  if (!faces.has_picture()) throw Error(name + ": expected faces with a picture, found none");
  if (faces.pictures.size() == 1) {
    const FacePicture &only = faces.pictures[0];
    if (!only.is_tinted()) return load(only);
    const std::vector<uint8_t> png = media::encode_png(decoded(only, faces.limit), media::PngEffort::fast);
    return {png.begin(), png.end()};
  }
  const AtlasLayout layout = lay_out_atlas(faces, name);
  media::Image atlas = media::make_image(layout.width, layout.height, 3, 128);
  for (size_t i = 0; i < faces.pictures.size(); i++) {
    const FacePicture &one = faces.pictures[i];
    const AtlasPlace &place = layout.places[i];
    media::Image image =
        one.is_colour() ? media::make_image(place.width, place.height, 3, 0) : decoded(one, faces.limit);
    for (size_t k = 0; one.is_colour() && k < image.pixels.size(); k++) image.pixels[k] = one.colour[k % 3];
    if (image.width != place.width || image.height != place.height)
      image = media::scale(image, place.width, place.height);
    put(image, place, atlas);
  }
  const std::vector<uint8_t> png = media::encode_png(atlas, media::PngEffort::fast);
  return {png.begin(), png.end()};
}

namespace {

// The coordinates of a face's corners within its picture. axis: 0 for u.
void settle_face(double (&corners)[3], const FacePicture *picture, size_t axis, size_t face,
                 const std::string &name) {
  const FaceAxis range(corners[0], corners[1], corners[2]);
  if (range.is_inside()) return;
  const Wrap wrap = picture ? picture->wrap[axis] : Wrap::repeat;
  double whole = wrap == Wrap::clamp ? 0 : range.shift();
  const bool beyond = wrap == Wrap::clamp && (range.high <= rounding || range.low >= 1 - rounding);
  if (!beyond && !range.fits(whole))
    throw Error(name + ": face " + std::to_string(face) +
                ": expected texture coordinates within one picture, found " + "uv"[axis] +
                std::string(" from ") + range_text(range) + ": the picture " +
                (wrap == Wrap::clamp ? "ends" : "repeats") + " on the face; have such faces cut (" +
                option_name("bake-repeats") +
                ", or bake_repeats of the atlas in a capture.json), bake the picture into an atlas, or do "
                "without (" +
                option_name("atlas", "none") + ")");
  for (double &at : corners) {
    at = std::clamp(at - whole, 0.0, 1.0);
    if (wrap == Wrap::mirror && std::fmod(whole, 2) != 0) at = 1 - at;
  }
}

// u v of each corner; those of a face with one colour are in the middle of it.
std::vector<double> corner_texture(const Mesh &mesh, const FacePictures &faces) {
  std::vector<double> texture;
  texture.reserve(2 * mesh.faces.size());
  for (size_t i = 0; i < mesh.faces.size(); i++) {
    const FacePicture *picture = faces.of(i / 3);
    const double *own = &mesh.texture[2 * size_t(mesh.faces[i])];
    if (picture && picture->is_colour())
      texture.insert(texture.end(), 2, 0.5);
    else
      texture.insert(texture.end(), own, own + 2);
  }
  return texture;
}

// Where the faces may be cut.
std::vector<std::array<TileBorders, 2>> tile_borders(const std::vector<double> &texture,
                                                     const FacePictures &faces) {
  std::vector<std::array<TileBorders, 2>> borders(texture.size() / 6);
  for (size_t face = 0; face < borders.size(); face++) {
    const FacePicture *picture = faces.of(face);
    for (size_t axis = 0; axis < 2; axis++) {
      const double *at = &texture[6 * face + axis];
      const FaceAxis range(at[0], at[2], at[4]);
      const bool clamped = picture && picture->wrap[axis] == Wrap::clamp;
      borders[face][axis] = range.fits(clamped ? 0 : range.shift()) ? TileBorders::none
                            : clamped                               ? TileBorders::own
                                                                    : TileBorders::all;
    }
  }
  return borders;
}

} // namespace

void settle_texture(Mesh &mesh, const FacePictures &faces, const fvv_limits &limits, const std::string &name,
                    const std::vector<double> &rest) {
  const bool several = faces.pictures.size() > 1;
  if (mesh.texture.empty() ||
      (!several && std::all_of(mesh.texture.begin(), mesh.texture.end(),
                               [](double value) { return value >= 0 && value <= 1; })))
    return;
  AtlasLayout layout;
  if (several) layout = lay_out_atlas(faces, name);
  TileCut cut;
  cut.texture = corner_texture(mesh, faces);
  if (faces.bake_repeats) {
    cut = cut_at_tiles(mesh, cut.texture, tile_borders(cut.texture, faces),
                       rest.empty() ? mesh.positions : rest, rounding, limits, name);
    apply_cut(cut, mesh);
  }
  std::vector<double> texture, normals;
  texture.reserve(2 * mesh.faces.size());
  for (size_t face = 0; face < mesh.face_count(); face++) {
    const size_t whole = faces.bake_repeats ? cut.whole[face] : face;
    double pairs[2][3];
    for (size_t axis = 0; axis < 2; axis++) {
      for (size_t c = 0; c < 3; c++) pairs[axis][c] = cut.texture[6 * face + 2 * c + axis];
      settle_face(pairs[axis], faces.of(whole), axis, whole, name);
    }
    for (size_t c = 0; c < 3; c++) {
      if (!several) {
        texture.insert(texture.end(), {pairs[0][c], pairs[1][c]});
        continue;
      }
      const AtlasPlace &place = layout.places[faces.of_face[whole]];
      texture.push_back((place.x + pairs[0][c] * place.width) / layout.width);
      texture.push_back((place.y + pairs[1][c] * place.height) / layout.height);
    }
  }
  for (size_t i = 0; !mesh.normals.empty() && i < mesh.faces.size(); i++) {
    const double *normal = &mesh.normals[3 * size_t(mesh.faces[i])];
    normals.insert(normals.end(), normal, normal + 3);
  }
  split_seams(mesh, texture, normals, limits, name);
}

Mesh read_mesh_texture(const std::string &path, const fvv_limits *limits, MeshReport *report, bool normals,
                       bool bake_repeats) {
  Mesh mesh = parse_mesh(path, limits, report, true, normals);
  FacePictures faces;
  faces.bake_repeats = bake_repeats;
  settle_texture(mesh, faces, limits_or_default(limits), path);
  return mesh;
}

Mesh read_mesh_pictures(const std::string &path, const fvv_limits *limits, MeshReport *report, bool normals,
                        FacePictures &faces) {
  const std::string bytes = read_file(path, max_mesh_file);
  const auto parse = is_gltf(path)                                                      ? parse_gltf_pictures
                     : path.size() > 4 && lower(path.substr(path.size() - 4)) == ".ply" ? parse_ply_pictures
                                                                                        : parse_obj_pictures;
  Mesh mesh = parse(bytes, path, limits, report, normals, faces);
  settle_texture(mesh, faces, limits_or_default(limits), path);
  return mesh;
}

} // namespace fvv::scene
