// Texture map of the made-up scene: where its triangles lie, and what colours they find there.
#include "fvv_catch.h"

#include "fvv_render/picture.h"
#include "fvvsynth/atlas.h"

#include <algorithm>
#include <cmath>

using namespace fvv;
using namespace fvv::synth;
using render::Rgb;

namespace {

const Scene &game_scene() {
  Settings settings;
  settings.rig = RigKind::small;
  settings.cameras = 3;
  settings.width = 480;
  settings.height = 270;
  static const Scene made(settings);
  return made;
}

const Atlas &atlas() {
  static const Atlas made = make_atlas(game_scene(), default_atlas_size, 2);
  return made;
}

// Where a vertex lies in the solid texture.
Vec3 solid(uint32_t vertex) {
  const float *at = &game_scene().solid()[3 * size_t(vertex)];
  return {at[0], at[1], at[2]};
}

// Of the atlas' own vertices: of its faces and at weights of their corners.
Vec3 solid(const Layout &layout, uint32_t face, const std::array<double, 3> &weights) {
  Vec3 at;
  for (size_t c = 0; c < 3; c++) at += solid(layout.source[layout.faces[3 * face + c]]) * weights[c];
  return at;
}

Flat centre(const Layout &layout, size_t face) {
  Flat at = {0, 0};
  for (size_t c = 0; c < 3; c++)
    for (size_t axis = 0; axis < 2; axis++) at[axis] += layout.texels[layout.faces[3 * face + c]][axis] / 3;
  return at;
}

// Display values, between the centres of texels bilinear: (0, 0) is the corner of the first texel.
Rgb sample(const media::Image &picture, double x, double y) {
  const auto split = [](double at, uint32_t size) {
    const double from = std::clamp(at - 0.5, 0.0, double(size - 1));
    const uint32_t low = std::min(uint32_t(from), size - 2);
    return std::pair(low, from - low);
  };
  const auto [column, right] = split(x, picture.width);
  const auto [row, down] = split(y, picture.height);
  const auto texel = [&](uint32_t i, uint32_t j) {
    const uint8_t *p = &picture.pixels[3 * (size_t(j) * picture.width + i)];
    return Rgb{p[0] / 255.0, p[1] / 255.0, p[2] / 255.0};
  };
  return (texel(column, row) * (1 - right) + texel(column + 1, row) * right) * (1 - down) +
         (texel(column, row + 1) * (1 - right) + texel(column + 1, row + 1) * right) * down;
}

double largest_difference(Rgb a, Rgb b) {
  return std::max({std::fabs(a.x - b.x), std::fabs(a.y - b.y), std::fabs(a.z - b.z)});
}

Rgb display(Rgb linear) {
  return {std::sqrt(linear.x), std::sqrt(linear.y), std::sqrt(linear.z)};
}

} // namespace

TEST_CASE("no point of the atlas belongs to two triangles, counted in integers", "[slow]") {
  const Layout &layout = atlas().layout;
  // Corners are rounded to 65536ths of a texel, neighbours share them; triangles are counted at 4 x 4 points
  // of a texel. A point on a common edge would count twice: of those on edges only left and upper ones count.
  constexpr int64_t texel = 65536, fine = 4, step = texel / fine;
  const int64_t columns = int64_t(layout.size) * fine;
  std::vector<uint8_t> count(size_t(columns * columns));
  size_t turned = 0;
  for (size_t face = 0; face < layout.faces.size() / 3; face++) {
    int64_t p[3][2];
    for (size_t c = 0; c < 3; c++)
      for (size_t axis = 0; axis < 2; axis++)
        p[c][axis] = std::llround(layout.texels[layout.faces[3 * face + c]][axis] * texel);
    std::swap(p[1], p[2]); // clockwise where y points down, so that insides are positive
    const auto side = [&](size_t from, int64_t x, int64_t y) {
      const size_t to = (from + 1) % 3;
      return (p[to][0] - p[from][0]) * (y - p[from][1]) - (p[to][1] - p[from][1]) * (x - p[from][0]);
    };
    turned += side(0, p[2][0], p[2][1]) <= 0;
    const auto inside = [&](int64_t x, int64_t y) {
      for (size_t from = 0; from < 3; from++) {
        const int64_t dx = p[(from + 1) % 3][0] - p[from][0], dy = p[(from + 1) % 3][1] - p[from][1];
        const int64_t distance = side(from, x, y);
        const bool counts = dy < 0 || (dy == 0 && dx > 0);
        if (distance < 0 || (distance == 0 && !counts)) return false;
      }
      return true;
    };
    const auto [left, right] = std::minmax({p[0][0], p[1][0], p[2][0]});
    const auto [top, bottom] = std::minmax({p[0][1], p[1][1], p[2][1]});
    for (int64_t row = top / step; row < columns && row * step <= bottom; row++)
      for (int64_t column = left / step; column < columns && column * step <= right; column++)
        if (inside(column * step + step / 2, row * step + step / 2)) count[size_t(row * columns + column)]++;
  }
  CHECK(turned == 0); // also: none without area
  CHECK(std::count_if(count.begin(), count.end(), [](uint8_t n) { return n > 1; }) == 0);
  const double covered = double(std::count(count.begin(), count.end(), 1)) / double(count.size());
  CHECK(covered > 0.4);
}

TEST_CASE("a surface that winds over itself is cut where it would lie on itself") {
  // A spiral staircase of two and a half turns without risers, 24 steps a turn, seen from above.
  constexpr size_t steps = 60, turn = 24;
  Surface stairs;
  for (size_t i = 0; i <= steps; i++) {
    const double angle = 2 * M_PI * double(i) / turn;
    for (const double radius : {0.5, 1.0})
      stairs.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.01 * double(i)});
  }
  for (uint32_t i = 0; i < steps; i++) {
    const uint32_t a = 2 * i, b = a + 1, c = a + 2, d = a + 3;
    for (const uint32_t vertex : {a, b, d, a, d, c}) stairs.faces.push_back(vertex);
  }
  const std::vector<Chart> charts = make_charts(stairs, std::vector<uint8_t>(2 * steps), {Mat3{}});
  REQUIRE(charts.size() == 3);
  size_t faces = 0;
  for (const Chart &chart : charts) {
    CHECK(chart.faces.size() <= 2 * turn);
    faces += chart.faces.size();
  }
  CHECK(faces == 2 * steps);
}

TEST_CASE("charts keep their margins from each other and from the edge of the atlas", "[long]") {
  const Layout &layout = atlas().layout;
  const std::vector<Chart> &charts = atlas().charts;
  REQUIRE(charts.size() == layout.places.size());
  CHECK(charts.size() < 400);
  std::vector<uint8_t> taken(size_t(layout.size) * layout.size);
  std::vector<uint8_t> of_face(layout.faces.size() / 3);
  size_t outside = 0;
  for (size_t i = 0; i < charts.size(); i++) {
    const ChartBox &box = layout.places[i];
    REQUIRE((box.x + box.width <= layout.size && box.y + box.height <= layout.size));
    for (uint32_t y = box.y; y < box.y + box.height; y++)
      for (uint32_t x = box.x; x < box.x + box.width; x++) taken[size_t(y) * layout.size + x]++;
    for (const uint32_t face : charts[i].faces) {
      of_face[face]++;
      for (size_t c = 0; c < 3; c++) {
        const Flat &at = layout.texels[layout.faces[3 * face + c]];
        constexpr double margin = chart_margin - 1e-6;
        outside += !(at[0] >= box.x + margin && at[0] <= box.x + box.width - margin &&
                     at[1] >= box.y + margin && at[1] <= box.y + box.height - margin);
      }
    }
  }
  CHECK(outside == 0);
  CHECK(*std::max_element(taken.begin(), taken.end()) == 1);
  CHECK(std::count(of_face.begin(), of_face.end(), 1) == ptrdiff_t(of_face.size()));
}

TEST_CASE("the opened mesh has the scene's triangles, in its order", "[long]") {
  const Layout &layout = atlas().layout;
  REQUIRE(layout.faces.size() == game_scene().faces().size());
  REQUIRE(layout.texels.size() == layout.source.size());
  size_t unlike = 0;
  for (size_t i = 0; i < layout.faces.size(); i++)
    unlike += layout.source[layout.faces[i]] != game_scene().faces()[i];
  CHECK(unlike == 0);
  CHECK(layout.source.size() < game_scene().vertex_count() * 5 / 4); // seams cost little
  for (size_t i = 0; i < game_scene().vertex_count(); i++) unlike += layout.source[i] != i;
  CHECK(unlike == 0);
  CHECK(atlas().opened(game_scene().solid(), 3).size() == 3 * layout.source.size());
}

TEST_CASE("no triangle shrinks to less than a third of its size on the body, nor grows", "[long]") {
  const Layout &layout = atlas().layout;
  // Of the rest figures, whose solid texture is where they are; the ball's is on a larger sphere.
  const size_t faces =
      (game_scene().players()[0].rest.faces.size() + game_scene().players()[1].rest.faces.size()) / 3;
  double least = 1, most = 0;
  for (uint32_t face = 0; face < faces; face++) {
    const uint32_t *v = &layout.faces[3 * face];
    const Vec3 a = solid(layout.source[v[0]]), b = solid(layout.source[v[1]]), c = solid(layout.source[v[2]]);
    const Flat p = layout.texels[v[0]], q = layout.texels[v[1]], r = layout.texels[v[2]];
    const double area = std::fabs((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]));
    const double share = area / (layout.density * layout.density * length(cross(b - a, c - a)));
    least = std::min(least, share);
    most = std::max(most, share);
  }
  CHECK(least > 1.0 / 3);
  CHECK(most < 1.001);
}

TEST_CASE("a colour that changes evenly over the body is found again at the centre of every face", "[long]") {
  const Layout &layout = atlas().layout;
  // Within the display range over the height and width of the figures; the ball is 2 m wide here.
  const auto colour = [&](Vec3 at) {
    return Rgb{0.5 + 0.25 * at.x, 0.2 + 0.25 * std::fabs(at.y), 0.5 + 0.25 * at.z};
  };
  const media::Image picture = bake(
      atlas().charts, layout,
      [&](uint32_t face, const std::array<double, 3> &weights) {
        return render::to_linear(colour(solid(layout, face, weights)));
      },
      2);
  const size_t player_faces =
      (game_scene().players()[0].rest.faces.size() + game_scene().players()[1].rest.faces.size()) / 3;
  double worst = 0, worst_of_ball = 0;
  for (uint32_t face = 0; face < layout.faces.size() / 3; face++) {
    const Flat at = centre(layout, face);
    const double error = largest_difference(sample(picture, at[0], at[1]),
                                            colour(solid(layout, face, {1 / 3.0, 1 / 3.0, 1 / 3.0})));
    double &largest = face < player_faces ? worst : worst_of_ball;
    largest = std::max(largest, error * 255);
  }
  CHECK(worst < 0.75); // half a level is rounding
  CHECK(worst_of_ball < 1.5);
}

TEST_CASE("the atlas has the solid texture's colours at the centres of faces", "[long]") {
  const Layout &layout = atlas().layout;
  std::vector<double> errors;
  for (uint32_t face = 0; face < layout.faces.size() / 3; face++) {
    const Flat at = centre(layout, face);
    const Rgb solid_colour =
        game_scene().reflectance(face, solid(layout, face, {1 / 3.0, 1 / 3.0, 1 / 3.0})).colour;
    errors.push_back(255 * largest_difference(sample(atlas().picture, at[0], at[1]), display(solid_colour)));
  }
  std::sort(errors.begin(), errors.end());
  // Of 255. Most of the texture is smooth; a letter's edge through a face is a step there, a ramp in the
  // atlas.
  const auto quantile = [&](double share) { return errors[size_t(share * double(errors.size()))]; };
  CHECK(quantile(0.5) < 1);
  CHECK(quantile(0.9) < 8);
  CHECK(quantile(0.98) < 60);
}

TEST_CASE("a picture drawn with the atlas is the one drawn with the solid texture", "[long]") {
  const Moment moment = game_scene().at(0.5);
  const std::vector<float> positions = atlas().opened(moment.positions, 3);
  const std::vector<float> normals = atlas().opened(moment.normals, 3);
  const std::vector<float> solids = atlas().opened(game_scene().solid(), 3);
  const Layout &layout = atlas().layout;
  const render::Mesh mesh = {positions.data(), positions.size() / 3, layout.faces.data(),
                             layout.faces.size() / 3};
  std::vector<float> coordinates;
  for (const Flat &at : layout.texels)
    coordinates.insert(coordinates.end(), {float(at[0]), float(at[1]), 0.0f});
  const std::vector<float> open(mesh.vertex_count, 1);
  const render::Light even = {{0, 1, 0}, {0, 0, 0}, {1, 1, 1}, {1, 1, 1}};
  render::SampleBuffer buffer(480, 270, 3);
  for (size_t camera = 0; camera < 3; camera++) {
    const render::Projection projection(game_scene().cameras()[camera]);
    const auto drawn = [&](const std::vector<float> &texture, const render::Material &material) {
      const render::Picture picture = render::draw(
          projection, mesh, {normals.data(), texture.data(), open.data()}, material, even, {}, buffer);
      media::Image image = media::make_image(480, 270, 3, 0);
      image.pixels.assign(picture.rgb.begin(), picture.rgb.end());
      media::Image mask = media::make_image(480, 270, 1, 0);
      mask.pixels.assign(picture.mask.begin(), picture.mask.end());
      return std::pair(image, mask);
    };
    const auto [expected, mask] = drawn(solids, [&](uint32_t face, Vec3 at) {
      return render::Reflectance{game_scene().reflectance(face, at).colour, 0};
    });
    const auto [found, same_mask] = drawn(coordinates, [&](uint32_t, Vec3 at) {
      return render::Reflectance{render::to_linear(sample(atlas().picture, at.x, at.y)), 0};
    });
    CHECK(media::psnr_luma(expected, found, &mask) > 38);
  }
}

TEST_CASE("an atlas does not depend on the number of threads, and has bounds", "[long]") {
  const Atlas one = make_atlas(game_scene(), 512, 1), three = make_atlas(game_scene(), 512, 3);
  CHECK(one.picture.pixels == three.picture.pixels);
  CHECK(one.layout.texels == three.layout.texels);
  CHECK(one.picture.width == 512);
  CHECK(one.layout.density < atlas().layout.density);
  CHECK_THROWS_WITH(make_atlas(game_scene(), 64, 1),
                    Catch::Contains("an atlas of 64 x 64 texels cannot hold ") && Catch::EndsWith(" charts"));
  CHECK_THROWS_AS(make_atlas(game_scene(), 16385, 1), std::invalid_argument);
}
