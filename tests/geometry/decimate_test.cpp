// Decimation of single frames: against spheres and planes, of which distances are known without measuring.
#include "decimate_fixture.h"

#include "geometry/src/fit.h"
#include "geometry/src/simplify.h"

#include <set>

using namespace shapes;
using decimate::Decimated;
using decimate::find_target_error;
using decimate::first_alike;
using decimate::Simplifier;

TEST_CASE("the size of a pixel follows from the focal length, and is smaller at an angle") {
  decimate::Footprint cameras;
  CHECK(!std::isfinite(cameras.look(std::array<double, 3>{0, 0, 5}.data()).metres_per_pixel));
  cameras.add(camera(1000), 0.5, 0.5);
  const double ahead[3] = {0, 0, 5}, aside[3] = {3, 0, 4}, behind[3] = {0, 0, -5};
  CHECK(cameras.look(ahead).metres_per_pixel == Approx(5.0 / 500).epsilon(1e-6));
  CHECK(cameras.look(ahead).camera == 7);
  // Across the ray and in the plane of the axis: a displacement d turns the ray by d / 5, and the picture
  // moves by f / cos^2 of that; the cosine is 4 / 5.
  CHECK(cameras.look(aside).metres_per_pixel == Approx(5.0 * 0.64 / 500).epsilon(1e-4));
  CHECK(!std::isfinite(cameras.look(behind).metres_per_pixel));
  // A sharper camera that does not show the place counts only where no other does.
  cameras.add(camera(8000), 1, 1); // shows up to 1 / 8 beside its axis
  CHECK(cameras.look(ahead).metres_per_pixel == Approx(5.0 / 8000).epsilon(1e-6));
  CHECK(cameras.look(aside).metres_per_pixel == Approx(5.0 * 0.64 / 500).epsilon(1e-4));
  const double outside[3] = {0, 9, 4};
  CHECK(cameras.look(outside).metres_per_pixel < 1.5 * std::hypot(9, 4) / 8000);
}

TEST_CASE("a plane is as few triangles as its border allows") {
  const Mesh plane = sheet(20, false, [](double, double) { return 0.3; });
  const Decimated out = decimate::decimate(plane, millimetre_pixels(), budget(0.1), 0.01);
  // The border stays, 80 vertices: a triangulation without others has 78 triangles.
  CHECK(out.report.faces_before == 800);
  CHECK(out.report.faces_after == 78);
  double area = 0;
  for (size_t f = 0; f < out.mesh.face_count(); f++) area += decimate::face_area(out.mesh, f);
  CHECK(area == Approx(1));
  CHECK(out.report.error.max < 1e-5); // the lattice
  for (size_t v = 0; v < out.vertices.size(); v++)
    CHECK(out.mesh.positions[3 * v] == plane.positions[3 * size_t(out.vertices[v])]);
}

TEST_CASE("a sphere keeps its budget, its radius and its volume") {
  const Mesh ball = sphere(0.5, 6); // 32,768 triangles, within 0.1 mm of the sphere
  const auto cameras = millimetre_pixels();
  for (const double pixels : {0.5, 2.0}) {
    const decimate::Budget wanted = budget(pixels);
    const double target_error = find_target_error(ball, cameras, wanted);
    const Decimated out = decimate::decimate(ball, cameras, wanted, target_error);
    CHECK_FALSE(out.report.kept);
    CHECK(out.report.faces_after < (pixels > 1 ? 1200 : 5000));
    CHECK(out.report.error.rms_pixels <= pixels);
    CHECK(out.report.error.rms_pixels > 0.8 * pixels); // no more triangles than it takes
    CHECK(out.report.error.max_pixels <= 6 * pixels);
    CHECK(out.report.error.rms == Approx(out.report.error.rms_pixels / 1000).epsilon(0.01));
    // By the radius alone, at corners and in the middle of faces.
    double squares = 0, weight = 0, worst = 0;
    for (size_t f = 0; f < out.mesh.face_count(); f++) {
      double middle[3] = {0, 0, 0};
      for (size_t c = 0; c < 3; c++)
        for (size_t k = 0; k < 3; k++)
          middle[k] += out.mesh.positions[3 * size_t(out.mesh.faces[3 * f + c]) + k] / 3;
      const double off = std::abs(std::hypot(middle[0], middle[1], middle[2]) - 0.5);
      squares += off * off * decimate::face_area(out.mesh, f);
      weight += decimate::face_area(out.mesh, f);
      worst = std::max(worst, off);
    }
    CHECK(std::sqrt(squares / weight) < 1.5e-3 * pixels);
    CHECK(worst < 6e-3 * pixels);
    CHECK(std::abs(out.report.volume_after / out.report.volume_before - 1) < 0.004);
    CHECK(out.report.volume_before == Approx(M_PI / 6).epsilon(1e-3));
  }
}

TEST_CASE("fitting takes a good part of the error away") {
  const Mesh ball = sphere(0.5, 5);
  Mesh coarse = sphere(0.5, 2);
  const auto radii = [&] {
    double least = 1, most = 0;
    for (size_t v = 0; v < coarse.vertex_count(); v++) {
      const double *p = &coarse.positions[3 * v];
      least = std::min(least, std::hypot(p[0], p[1], p[2]));
      most = std::max(most, std::hypot(p[0], p[1], p[2]));
    }
    return std::array<double, 2>{least, most};
  };
  const double before = decimate::enclosed_volume(coarse);
  std::vector<bool> fixed(coarse.vertex_count());
  fixed[0] = true;
  decimate::fit(coarse, compare::Faces(coarse), ball, fixed, 0.01);
  CHECK(radii()[0] == Approx(0.5)); // the fixed one
  CHECK(radii()[1] > 0.505);
  CHECK(radii()[1] <= 0.51 + 1e-9); // no further than allowed
  const double missing = 1 - before / decimate::enclosed_volume(ball);
  CHECK(std::abs(1 - decimate::enclosed_volume(coarse) / decimate::enclosed_volume(ball)) < missing / 2);
}

TEST_CASE("a thin part is preserved, and reported when it is not") {
  // A sheet with a needle 60 mm high, a cell wide.
  const Mesh needle = sheet(40, false, [](double x, double y) {
    return std::abs(x - 0.5) < 1e-9 && std::abs(y - 0.5) < 1e-9 ? 0.06 : 0.002 * std::sin(9 * x) * y;
  });
  const auto top = [](const Mesh &mesh) {
    double z = 0;
    for (size_t v = 0; v < mesh.vertex_count(); v++) z = std::max(z, mesh.positions[3 * v + 2]);
    return z;
  };
  const Decimated preserved = decimate::decimate(needle, millimetre_pixels(), budget(3), 0.2);
  CHECK(top(preserved.mesh) > 0.06 - 6 * 3e-3);
  CHECK(preserved.report.error.max_pixels <= 18);
  CHECK(preserved.report.thin_area == 0);
  CHECK(preserved.report.locked_faces > 0);
  CHECK(preserved.report.faces_after < needle.face_count() / 4);
  decimate::Budget wanted = budget(3);
  wanted.triangles = 170;
  const Decimated lost = decimate::decimate(needle, millimetre_pixels(), wanted, 0);
  CHECK(lost.report.faces_after <= 170);
  if (top(lost.mesh) < 0.03) CHECK(lost.report.thin_area > 0);
}

TEST_CASE("pieces that vanish are counted, and specks go before") {
  const Mesh ball = sphere(0.5, 4), speck = sphere(0.0004, 1, 0.51), both = together(ball, speck);
  const decimate::Budget wanted = budget(1, 0.001);
  const Decimated out = decimate::decimate(both, millimetre_pixels(), wanted, 0.004);
  CHECK(out.report.vanished.pieces == 1);
  CHECK(out.report.vanished.area > 0.5 * 4 * M_PI * 0.0004 * 0.0004);
  CHECK(out.report.vanished.area < 4 * M_PI * 0.0004 * 0.0004);
  const Decimated whole =
      decimate::decimate(together(ball, sphere(0.1, 3, 1)), millimetre_pixels(), wanted, 0.004);
  CHECK(whole.report.vanished.pieces == 0);
  decimate::Budget without = wanted;
  without.min_piece = 33; // the speck has 32 faces
  const Decimated dropped = decimate::decimate(both, millimetre_pixels(), without, 0.004);
  CHECK(dropped.report.dropped_pieces == 1);
  CHECK(dropped.report.dropped_faces == 32);
  CHECK(dropped.report.vanished.pieces == 0);
  CHECK(dropped.report.faces_before == ball.face_count());
}

namespace {

// A plate of 0.5 m x 0.5 m.
Mesh plate(double thickness, double z) {
  Mesh mesh;
  for (const double height : {z, z + thickness})
    for (const double y : {0.0, 0.5})
      for (const double x : {0.0, 0.5}) mesh.positions.insert(mesh.positions.end(), {x, y, height});
  mesh.faces = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return mesh;
}

} // namespace

TEST_CASE("plates that lose their thickness on the lattice are counted") {
  const geometry::Lattice lattice = {{0, 0, 0}, 0.002};
  const Mesh ball = sphere(0.3, 4, 2), thin = plate(0.0004, 0.1), thick = plate(0.004, 0.2);
  const double area = 2 * 0.25 + 4 * 0.5 * 0.0004;
  const decimate::Lost lost = decimate::flattened_pieces(together(together(ball, thin), thick), lattice);
  CHECK(lost.pieces == 1);
  CHECK(lost.area == Approx(area));
  CHECK(decimate::merged_area(together(ball, thin), lattice) == Approx(0.25));
  CHECK(decimate::flattened_pieces(thick, lattice).pieces == 0);
  CHECK(decimate::merged_area(thick, lattice) == 0);
  // Far from the origin, as in maps.
  Mesh far = thin;
  for (double &coordinate : far.positions) coordinate += 4096;
  CHECK(decimate::flattened_pieces(far, lattice).pieces == 1);
  // Open sheets, and one that is there twice, have no thickness to lose; specks vanish, or are a few steps.
  Mesh twice = sheet(4, false, [](double, double) { return 0.1; });
  const std::vector<uint32_t> front = twice.faces;
  for (size_t f = 0; f < front.size(); f += 3)
    twice.faces.insert(twice.faces.end(), {front[f], front[f + 2], front[f + 1]});
  CHECK(decimate::flattened_pieces(twice, lattice).pieces == 0);
  CHECK(decimate::merged_area(twice, lattice) == 0);
  CHECK(decimate::flattened_pieces(sheet(4, false, [](double x, double) { return 1e-4 * x; }), lattice)
            .pieces == 0);
  CHECK(decimate::flattened_pieces(sphere(0.0015, 2, 0.0007), lattice).pieces == 0);
}

TEST_CASE("a hole within a face of the source is seen where faces are looked at") {
  Mesh source, holed;
  source.positions = {0, 0, 0, 3, 0, 0, 0, 3, 0};
  source.faces = {0, 1, 2};
  holed.positions = source.positions; // and a triangle half as large around (1, 1, 0), which is left out
  holed.positions.insert(holed.positions.end(), {0.5, 0.5, 0, 2, 0.5, 0, 0.5, 2, 0});
  holed.faces = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4, 2, 0, 3, 2, 3, 5};
  const decimate::Reference reference(source, decimate::Footprint::uniform(1));
  decimate::Budget tight;
  tight.pixels = 0.01;
  tight.lattice.step = 0.5;
  decimate::Outliers outliers;
  decimate::Report report = decimate::measure_on_lattice(reference, holed, tight, outliers);
  CHECK(report.error.max < 1e-9);
  CHECK(outliers.vertices.empty());
  report = decimate::measure_on_lattice(reference, holed, tight, outliers, decimate::Looks::within_faces);
  const double off = std::sqrt(0.125); // from the centre to the nearest side of the hole
  CHECK(report.error.max == Approx(off));
  CHECK(report.error.rms == Approx(std::sqrt(0.75) * off));
  CHECK(outliers.vertices == std::vector<uint32_t>{0, 1, 2});
}

TEST_CASE("stray vertices do not make the typical box") {
  const Mesh ball = sphere(0.5, 5);
  const double size = geometry::typical_box(ball).diagonal();
  Mesh stray = ball;
  const size_t count = ball.vertex_count();
  // Triangles far off, of which all vertices are 1 %.
  for (size_t i = 0; 300 * i < count; i++) {
    const double way = i % 2 ? 50.0 + double(i) : -80.0 - double(i);
    const auto first = uint32_t(stray.vertex_count());
    for (int k = 0; k < 3; k++)
      for (int axis = 0; axis < 3; axis++) stray.positions.push_back(way + 0.001 * (k == axis));
    stray.faces.insert(stray.faces.end(), {first, first + 1, first + 2});
  }
  const double with = geometry::typical_box(stray).diagonal();
  CHECK(with > 0.8 * size);
  CHECK(with <= size);
  // Two bodies of the same size are one scene.
  const Mesh both = together(ball, sphere(0.5, 5, 20));
  CHECK(geometry::typical_box(both).diagonal() > 20);
}

TEST_CASE("decimation leaves no two faces with the same corners") {
  for (const double thickness : {0.001, 0.003}) {
    // A plate as thin as the error beside a ball: both its sides come together.
    Mesh fin = together(sphere(0.5, 4), plate(thickness, 0));
    for (const double target : {0.005, 0.02, 0.05}) {
      const Simplifier simplifier(fin, first_alike(fin, true));
      const std::vector<uint32_t> faces = simplifier.simplify({target, 0}, {});
      std::set<std::set<uint32_t>> sets;
      for (size_t i = 0; i < faces.size(); i += 3) sets.insert({faces[i], faces[i + 1], faces[i + 2]});
      CHECK(sets.size() == faces.size() / 3);
      CHECK(faces.size() > 24);
    }
  }
}

TEST_CASE("seams of an atlas stay seams") {
  // Two halves of a sheet that meet at x = 0.5, with texture coordinates of their own.
  Mesh mesh = sheet(20, true, [](double x, double y) { return 0.01 * std::sin(5 * x + 3 * y); });
  const size_t count = mesh.vertex_count();
  std::vector<uint32_t> twin(count, UINT32_MAX);
  for (size_t f = 0; f < mesh.face_count(); f++) {
    double x = 0;
    for (size_t k = 0; k < 3; k++) x += mesh.positions[3 * size_t(mesh.faces[3 * f + k])] / 3;
    if (x < 0.5) continue;
    for (size_t k = 0; k < 3; k++) {
      uint32_t &v = mesh.faces[3 * f + k];
      if (twin[v] == UINT32_MAX) {
        twin[v] = uint32_t(mesh.vertex_count());
        for (size_t c = 0; c < 3; c++) mesh.positions.push_back(mesh.positions[3 * size_t(v) + c]);
        mesh.texture.insert(mesh.texture.end(),
                            {1 - mesh.texture[2 * size_t(v)], mesh.texture[2 * size_t(v) + 1]});
      }
      v = twin[v];
    }
  }
  const Decimated out = decimate::decimate(mesh, millimetre_pixels(), budget(1), 0.004);
  CHECK(out.report.faces_after < 400);
  CHECK(out.report.faces_after >= 78);
  for (size_t f = 0; f < out.mesh.face_count(); f++) {
    double least = 1, most = 0, u_least = 1, u_most = 0;
    for (size_t k = 0; k < 3; k++) {
      const uint32_t v = out.mesh.faces[3 * f + k];
      const double x = mesh.positions[3 * size_t(out.vertices[v])], u = out.mesh.texture[2 * size_t(v)];
      least = std::min(least, x), most = std::max(most, x);
      u_least = std::min(u_least, u), u_most = std::max(u_most, u);
    }
    CHECK((most <= 0.5 + 1e-9 || least >= 0.5 - 1e-9)); // no face reaches over the seam
    CHECK(u_most - u_least == Approx(most - least).margin(1e-9));
  }
}

TEST_CASE("what cannot be decimated comes back as it was") {
  Mesh ball = sphere(0.5, 3);
  const decimate::Footprint no_cameras;
  CHECK(decimate::decimate(ball, no_cameras, budget(1), 0.01).report.kept);
  CHECK(find_target_error(ball, no_cameras, budget(1)) == 0);
  // A lattice of 20 mm alone is off by 5.8 mm and more.
  CHECK(find_target_error(ball, millimetre_pixels(), budget(1, 0.02)) == 0);
  const Decimated kept = decimate::decimate(ball, millimetre_pixels(), budget(1, 0.02), 0.01);
  CHECK(kept.report.kept);
  CHECK(kept.mesh.faces == ball.faces);
  CHECK(kept.mesh.positions == ball.positions);
  decimate::Budget wanted = budget(1);
  wanted.triangles = 100;
  CHECK(decimate::decimate(ball, no_cameras, wanted, 0).report.faces_after <= 100);
  ball.positions[5] = NAN;
  CHECK(decimate::decimate(ball, millimetre_pixels(), budget(1), 0.01).mesh.faces == ball.faces);
}

TEST_CASE("a mesh of half a million triangles keeps its budget by the exact measure", "[long]") {
  const Mesh source = sphere(0.5, 8);
  REQUIRE(source.face_count() == 524288);
  const decimate::Budget wanted = budget(1);
  const double target_error = decimate::find_target_error(source, millimetre_pixels(), wanted);
  CHECK(target_error > 0);
  const decimate::Decimated out = decimate::decimate(source, millimetre_pixels(), wanted, target_error);
  CHECK(!out.report.kept);
  CHECK(out.report.faces_before == source.face_count());
  CHECK(out.report.faces_after < 6000);
  CHECK(out.report.error.rms_pixels <= 1);
  CHECK(out.report.error.max_pixels <= 6);
  for (const uint32_t v : out.vertices) REQUIRE(v < source.vertex_count());
}
