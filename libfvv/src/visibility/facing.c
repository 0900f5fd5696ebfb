/* What a camera can face (clause 17.2): the cosine between the normal of a face and the direction from its
 * centroid to a camera, compared with a threshold without a root, in integers of 64 bits. Also the weights of
 * coded states, which players interpolate (clause 17.4). */
#include <string.h>

#include "base/diagnostic.h"
#include "fvv/visibility.h"
#include "mesh/mesh.h"

enum {
  /* Components are below 2^11, so that squared lengths are below 3 * 2^22, the product of two of them below
   * 2^48, and that times the square of a threshold, which is below 2^16, below 2^64. */
  COMPONENT_BITS = 11
};

fvv_status fvv_visibility_centre(const fvv_camera *camera, const fvv_scene *scene, int32_t centre[3],
                                 fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  double metres[3];
  fvv_camera_centre(camera, metres);
  for (int a = 0; a < 3; a++)
    if (!fvv_lattice_quantise(metres[a], scene->lattice_origin[a], scene->lattice_step, &centre[a]))
      return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_VISIBILITY_CAMERA, 0, 0,
                      "centre of camera %u, %c = %g m, lies outside the lattice", camera->id, "xyz"[a],
                      metres[a]);
  return FVV_OK;
}

/* Divides by the least power of two that brings all components below 2^COMPONENT_BITS, towards 0. */
static void shorten(int64_t v[3]) {
  uint64_t all = 0;
  for (int a = 0; a < 3; a++) all |= (uint64_t)(v[a] < 0 ? -v[a] : v[a]);
  int shift = 0;
  while (all >> shift >> COMPONENT_BITS) shift++;
  if (shift)
    for (int a = 0; a < 3; a++) v[a] /= INT64_C(1) << shift;
}

/* Differences of positions are within 2^29, their products within 2^58, components of the normal within 2^59.
 */
static int faces_centre(const fvv_mesh *mesh, uint32_t face, const int32_t centre[3], uint8_t threshold) {
  const int32_t *p[3];
  for (int c = 0; c < 3; c++) p[c] = mesh->lattice + 3 * (size_t)mesh->faces[3 * (size_t)face + (size_t)c];
  int64_t u[3], v[3], way[3];
  for (int a = 0; a < 3; a++) {
    u[a] = (int64_t)p[1][a] - p[0][a];
    v[a] = (int64_t)p[2][a] - p[0][a];
    way[a] = 3 * (int64_t)centre[a] - p[0][a] - p[1][a] - p[2][a];
  }
  int64_t normal[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  shorten(normal);
  shorten(way);
  int64_t along = 0;
  uint64_t normal2 = 0, way2 = 0;
  for (int a = 0; a < 3; a++) {
    along += normal[a] * way[a];
    normal2 += (uint64_t)(normal[a] * normal[a]);
    way2 += (uint64_t)(way[a] * way[a]);
  }
  /* along^2 is at most the product of the squares, by Cauchy and Schwarz. */
  return along > 0 &&
         (uint64_t)along * (uint64_t)along << 16 > (uint64_t)threshold * threshold * (normal2 * way2);
}

void fvv_visibility_facing(const fvv_mesh *mesh, const int32_t centre[3], uint8_t threshold,
                           uint8_t *facing) {
  memset(facing, 0, mesh->vertex_count);
  for (uint32_t f = 0; f < mesh->face_count; f++)
    if (faces_centre(mesh, f, centre, threshold))
      for (size_t c = 0; c < 3; c++) facing[mesh->faces[3 * (size_t)f + c]] = 1;
}

void fvv_visibility_weights(const uint8_t *states, size_t count, uint8_t *weights) {
  /* By state: backfacing, a little less than half, so that other corners decide; then hidden and seen in
   * turns, ever nearer to a half. */
  static const uint8_t of_state[] = {127, 0, 255, 85, 170, 113, 142};
  for (size_t v = 0; v < count; v++) weights[v] = of_state[states[v]];
}
