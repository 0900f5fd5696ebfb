/* Cameras that move: a camera as integers and back (clauses 9.4, 9.5), the choice of their precision, and the
 * payloads of CALB chunks (clause 9.4). */
#include <inttypes.h>
#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "calibration/lens.h"
#include "fvv/calibration.h"

enum {
  ROTATION_MIN = 8,
  ROTATION_MAX = 25, /* squares of four components are then exact in binary64 */
  BITS_MAX = 40,
  AT_CENTRE = 4, /* where the centre, fx and the coefficients are */
  AT_FX = 7,
  AT_LENS = 12,
  VALUES_MAX = 21 /* upper bound */
};

/* The largest |value|: all integers up to it are exact in binary64. */
#define VALUE_MAX (INT64_C(1) << 53)

/* How many values a camera of a lens model has, r_max last: 0 where it is infinite. */
static size_t value_count(uint8_t lens) {
  return AT_LENS + (lens == FVV_LENS_RADTAN ? 9 : lens == FVV_LENS_FISHEYE ? 5 : 1);
}

static int bits_valid(const fvv_calibration_bits *bits) {
  return bits->rotation >= ROTATION_MIN && bits->rotation <= ROTATION_MAX && bits->position <= BITS_MAX &&
         bits->pixel <= BITS_MAX && bits->lens <= BITS_MAX;
}

/* The bits of the unit of value i. */
static int bits_of(const fvv_calibration_bits *bits, size_t i) {
  return i < AT_CENTRE ? bits->rotation : i < AT_FX ? bits->position : i < AT_LENS ? bits->pixel : bits->lens;
}

static int round_to(double value, int bits, int64_t *out) {
  const double scaled = floor(ldexp(value, bits) + 0.5);
  if (!(fabs(scaled) <= (double)VALUE_MAX)) return 0;
  *out = (int64_t)scaled;
  return 1;
}

/* A unit quaternion, real part first, of a rotation that is orthonormal to 1e-4. The largest of the four
 * components is computed from the diagonal of R and the others from it (Shepperd, Quaternion from rotation
 * matrix, Journal of Guidance and Control 1, 1978), which is exact at all angles, 180 degrees included. */
static void quaternion_of(const double *r, double q[4]) {
  const double trace = r[0] + r[4] + r[8];
  const double diagonal[4] = {trace, r[0], r[4], r[8]};
  int largest = 0;
  for (int i = 1; i < 4; i++)
    if (diagonal[i] > diagonal[largest]) largest = i;
  /* Row i: 4 q_i times q. */
  const double rows[4][4] = {{1 + trace, r[7] - r[5], r[2] - r[6], r[3] - r[1]},
                             {r[7] - r[5], 1 + 2 * r[0] - trace, r[1] + r[3], r[2] + r[6]},
                             {r[2] - r[6], r[1] + r[3], 1 + 2 * r[4] - trace, r[5] + r[7]},
                             {r[3] - r[1], r[2] + r[6], r[5] + r[7], 1 + 2 * r[8] - trace}};
  double squares = 0;
  for (int i = 0; i < 4; i++) squares += rows[largest][i] * rows[largest][i];
  for (int i = 0; i < 4; i++) q[i] = rows[largest][i] / sqrt(squares);
}

/* Whether q should be written as -q: it is nearer to before, or, without one, its first component that is not
 * 0 is negative. */
static int is_opposite(const double q[4], const int64_t *before) {
  double product = 0;
  for (int i = 0; i < 4; i++) product += q[i] * (double)before[i];
  for (int i = 0; i < 4 && product == 0; i++) product = q[i];
  return product < 0;
}

static int lens_to_values(const fvv_camera *camera, int bits, int64_t *values) {
  const size_t coefficients = value_count(camera->lens) - AT_LENS - 1;
  double rounded[8] = {0};
  for (size_t i = 0; i < coefficients; i++) {
    if (!round_to(camera->distortion[i], bits, &values[i])) return 0;
    rounded[i] = ldexp((double)values[i], -bits);
  }
  values[coefficients] = 0;
  if (isinf(camera->r_max)) return 1;
  const fvv_lens lens = {camera->lens, rounded};
  const double radius = fmin(camera->r_max, fvv_lens_rising(&lens, camera->r_max));
  const double steps = floor(ldexp(radius, bits));
  if (!(steps >= 1 && steps <= (double)VALUE_MAX)) return 0;
  values[coefficients] = (int64_t)steps;
  return 1;
}

/* camera -> values, each the nearest. before: the camera's last values, all 0 when there are none; of q and
 * -q, the same rotation, the nearer is taken. r_max is rounded down and shortened to where the rounded lens
 * can be inverted. 0: a value would be beyond its range. For a valid camera. */
static int to_values(const fvv_camera *camera, const fvv_calibration_bits *bits, const int64_t *before,
                     int64_t *values) {
  double q[4], all[AT_LENS];
  quaternion_of(camera->rotation, q);
  const double sign = is_opposite(q, before) ? -1 : 1;
  for (int i = 0; i < 4; i++) all[i] = sign * q[i];
  fvv_camera_centre(camera, all + AT_CENTRE);
  const double intrinsics[5] = {camera->fx, camera->fy, camera->cx, camera->cy, camera->skew};
  memcpy(all + AT_FX, intrinsics, sizeof intrinsics);
  for (size_t i = 0; i < AT_LENS; i++)
    if (!round_to(all[i], bits_of(bits, i), &values[i])) return 0;
  return lens_to_values(camera, bits->lens, values + AT_LENS);
}

static int64_t squared_length(const int64_t *q) {
  return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
}

/* 0: q is no unit quaternion. */
static int quaternion_valid(const int64_t *values, const fvv_calibration_bits *bits) {
  const int64_t longest = INT64_C(1) << (bits->rotation + 1);
  for (int i = 0; i < 4; i++)
    if (values[i] < -longest || values[i] > longest) return 0;
  const int64_t n = squared_length(values), unit = INT64_C(1) << 2 * bits->rotation;
  return n >= unit / 4 && n <= unit * 4;
}

/* values -> camera, of which everything else is kept. The result is not checked. */
static void from_values(const int64_t *values, const fvv_calibration_bits *bits, fvv_camera *camera) {
  double real[VALUES_MAX] = {0};
  const size_t count = value_count(camera->lens);
  for (size_t i = AT_CENTRE; i < count; i++) real[i] = ldexp((double)values[i], -bits_of(bits, i));
  const int64_t *q = values, n = squared_length(q);
  const int64_t rotation[9] = {q[0] * q[0] + q[1] * q[1] - q[2] * q[2] - q[3] * q[3],
                               2 * (q[1] * q[2] - q[0] * q[3]),
                               2 * (q[1] * q[3] + q[0] * q[2]),
                               2 * (q[1] * q[2] + q[0] * q[3]),
                               q[0] * q[0] - q[1] * q[1] + q[2] * q[2] - q[3] * q[3],
                               2 * (q[2] * q[3] - q[0] * q[1]),
                               2 * (q[1] * q[3] - q[0] * q[2]),
                               2 * (q[2] * q[3] + q[0] * q[1]),
                               q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]};
  const double *centre = real + AT_CENTRE;
  for (int i = 0; i < 9; i++) camera->rotation[i] = (double)rotation[i] / (double)n;
  for (int i = 0; i < 3; i++) {
    const double *r = camera->rotation + 3 * i;
    camera->translation[i] = -((r[0] * centre[0] + r[1] * centre[1]) + r[2] * centre[2]);
  }
  const double *k = real + AT_FX;
  camera->fx = k[0], camera->fy = k[1], camera->cx = k[2], camera->cy = k[3], camera->skew = k[4];
  memset(camera->distortion, 0, sizeof camera->distortion);
  memcpy(camera->distortion, real + AT_LENS, (count - AT_LENS - 1) * sizeof *real);
  camera->r_max = camera->lens == FVV_LENS_NONE && !values[count - 1] ? INFINITY : real[count - 1];
}

/* How fine the steps of a moving camera have to be. Only sums, products and square roots, so that every
 * machine chooses the same. */

/* The least e with 2^-e <= step, within [least, most]. */
static int bits_for(double step, int least, int most) {
  for (int e = least; e < most; e++)
    if (ldexp(1, -e) <= step) return e;
  return most;
}

/* The most e <= bits with largest * 2^e within the range of values. */
static int bits_within(double largest, int bits) {
  while (bits > 0 && !(ldexp(largest, bits) <= (double)VALUE_MAX / 2)) bits--;
  return bits;
}

static int finer(int a, int b) {
  return a > b ? a : b;
}

/* The distance from the axis of the picture's corner that is furthest from it, at distance 1. */
static double reach_of(const fvv_camera *camera) {
  double reach = 0;
  for (int corner = 0; corner < 4; corner++) {
    const double y = ((corner & 2 ? camera->height : 0) - camera->cy) / camera->fy;
    const double x = ((corner & 1 ? camera->width : 0) - camera->cx - camera->skew * y) / camera->fx;
    reach = fmax(reach, sqrt(x * x + y * y));
  }
  return reach;
}

void fvv_calibration_choose(const fvv_camera *cameras, size_t count, double position_step, double max_pixels,
                            fvv_calibration_bits *bits) {
  const double share = max_pixels / 4;
  int rotation = ROTATION_MIN, pixel = 0, lens = 0;
  double furthest = 0, longest = 0, strongest = 0;
  for (size_t i = 0; i < count; i++) {
    const fvv_camera *c = &cameras[i];
    const double f = fmax(c->fx, c->fy) + fabs(c->skew), reach = reach_of(c);
    const double r = fmin(c->r_max, 1.5 * reach);
    double centre[3];
    /* A quaternion whose components are half a step off turns by two steps at most. */
    rotation = finer(rotation, bits_for(share / (2 * f * (1 + r * r)), ROTATION_MIN, ROTATION_MAX));
    pixel = finer(pixel, bits_for(share / (1 + reach), 0, BITS_MAX));
    /* Nine powers of the radius at most, eight coefficients, half a step each; twice for denominators. */
    double power = 1;
    for (int k = 0; k < 9 && r > 1; k++) power *= r;
    lens = finer(lens, bits_for(share / (8 * f * power), 0, BITS_MAX));
    fvv_camera_centre(c, centre);
    for (int k = 0; k < 3; k++) furthest = fmax(furthest, fabs(centre[k]));
    longest = fmax(fmax(longest, fmax(f, fabs(c->skew))), fmax(fabs(c->cx), fabs(c->cy)));
    for (int k = 0; k < 8; k++) strongest = fmax(strongest, fabs(c->distortion[k]));
    if (!isinf(c->r_max)) strongest = fmax(strongest, c->r_max);
  }
  bits->rotation = (uint8_t)rotation;
  bits->position = (uint8_t)bits_within(furthest, bits_for(position_step, 0, BITS_MAX));
  bits->pixel = (uint8_t)bits_within(longest, pixel);
  bits->lens = (uint8_t)bits_within(strongest, lens);
}

/* Payloads of CALB chunks (clause 9.4). Work and memory are bounded by the number of cameras, not by the
 * payload. */

typedef struct moving_camera {
  fvv_camera now;             /* and its constant fields */
  int64_t values[VALUES_MAX]; /* of its last entry since the key chunk; 0 without one */
  int calibrated;             /* in the current chunk */
} moving_camera;

struct fvv_calibration {
  fvv_allocator allocator;
  moving_camera *cameras; /* by rising identifier */
  size_t count;
  fvv_calibration_bits bits;
  int has_key;
  uint16_t number; /* of the current chunk */
};

/* New values of a camera; applied when the whole chunk is valid. */
typedef struct entry {
  moving_camera *camera;
  int64_t values[VALUES_MAX];
} entry;

fvv_status fvv_calibration_create(const fvv_camera *cameras, size_t count, const fvv_allocator *allocator,
                                  fvv_calibration **calibration) {
  const fvv_allocator chosen = fvv_allocator_or_default(allocator);
  *calibration = NULL;
  fvv_calibration *c = fvv_allocate_zeroed(&chosen, sizeof *c);
  if (!c) return FVV_ERROR_MEMORY;
  c->allocator = chosen;
  size_t moving = 0;
  for (size_t i = 0; i < count; i++) moving += (cameras[i].flags & FVV_CAMERA_MOVES) != 0;
  c->cameras = moving ? fvv_allocate_array(&chosen, moving, sizeof *c->cameras) : NULL;
  if (moving && !c->cameras) {
    fvv_release(&chosen, c, sizeof *c);
    return FVV_ERROR_MEMORY;
  }
  if (moving) memset(c->cameras, 0, moving * sizeof *c->cameras);
  for (size_t i = 0; i < count; i++) {
    if (!(cameras[i].flags & FVV_CAMERA_MOVES)) continue;
    size_t at = c->count++;
    for (; at && c->cameras[at - 1].now.id > cameras[i].id; at--) c->cameras[at] = c->cameras[at - 1];
    c->cameras[at].now = cameras[i];
  }
  *calibration = c;
  return FVV_OK;
}

void fvv_calibration_destroy(fvv_calibration *calibration) {
  if (!calibration) return;
  const fvv_allocator allocator = calibration->allocator;
  if (calibration->cameras)
    fvv_release(&allocator, calibration->cameras, calibration->count * sizeof *calibration->cameras);
  fvv_release(&allocator, calibration, sizeof *calibration);
}

void fvv_calibration_reset(fvv_calibration *calibration) {
  calibration->has_key = 0;
  for (size_t i = 0; i < calibration->count; i++) calibration->cameras[i].calibrated = 0;
}

static moving_camera *find(fvv_calibration *c, uint64_t id) {
  size_t first = 0, end = c->count;
  while (first < end) {
    const size_t middle = first + (end - first) / 2;
    if (c->cameras[middle].now.id < id)
      first = middle + 1;
    else
      end = middle;
  }
  return first < c->count && c->cameras[first].now.id == id ? &c->cameras[first] : NULL;
}

fvv_status fvv_calibration_camera(const fvv_calibration *calibration, uint16_t id, fvv_camera *camera) {
  const moving_camera *found = find((fvv_calibration *)calibration, id);
  if (!found) return FVV_ERROR_ARGUMENT;
  if (!found->calibrated) return FVV_END;
  *camera = found->now;
  return FVV_OK;
}

/* A new chunk begins. */
static void advance(fvv_calibration *c, const fvv_calibration_bits *bits, uint16_t number) {
  fvv_calibration_reset(c);
  c->bits = *bits;
  c->number = number;
  c->has_key = 1;
  for (size_t i = 0; i < c->count && !number; i++)
    memset(c->cameras[i].values, 0, sizeof c->cameras[i].values);
}

static void take(fvv_calibration *c, const entry *entries, size_t count) {
  for (size_t i = 0; i < count; i++) {
    moving_camera *camera = entries[i].camera;
    memcpy(camera->values, entries[i].values, sizeof camera->values);
    from_values(camera->values, &c->bits, &camera->now);
    camera->calibrated = 1;
  }
}

/* ---- payload -> cameras ----------------------------------------------------------------------------- */

#define WRONG(rule, at, ...)                                                                                 \
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_##rule, FVV_CHUNK_CALIBRATION, at, __VA_ARGS__)

static fvv_status read_head(const fvv_calibration *c, const uint8_t *payload, size_t size, int key,
                            fvv_calibration_bits *bits, fvv_diagnostic *diagnostic) {
  if (size < FVV_CALB_SIZE)
    WRONG(CALIBRATION_PAYLOAD, 0, "payload has %zu bytes, expected at least %d", size, FVV_CALB_SIZE);
  const uint16_t number = fvv_get_u16(payload + FVV_CALB_NUMBER);
  bits->rotation = payload[FVV_CALB_ROTATION_BITS];
  bits->position = payload[FVV_CALB_POSITION_BITS];
  bits->pixel = payload[FVV_CALB_PIXEL_BITS];
  bits->lens = payload[FVV_CALB_LENS_BITS];
  if (!bits_valid(bits))
    WRONG(CALIBRATION_PAYLOAD, FVV_CALB_ROTATION_BITS,
          "bits are %u %u %u %u, expected 8 to 25 for the rotation and up to 40 for the others",
          bits->rotation, bits->position, bits->pixel, bits->lens);
  if (!number != !!key)
    WRONG(CALIBRATION_NUMBER, FVV_CALB_NUMBER, "number %u in a chunk %s the key flag", number,
          key ? "with" : "without");
  if (key) return FVV_OK;
  if (!c->has_key)
    WRONG(CALIBRATION_NUMBER, FVV_CALB_NUMBER, "number %u, but no key chunk precedes it", number);
  if (number != c->number + 1)
    WRONG(CALIBRATION_NUMBER, FVV_CALB_NUMBER, "number %u, expected %u", number, c->number + 1u);
  if (memcmp(bits, &c->bits, sizeof *bits) != 0)
    WRONG(CALIBRATION_NUMBER, FVV_CALB_ROTATION_BITS, "bits differ from those of the key chunk");
  return FVV_OK;
}

static fvv_status read_values(entry *e, const int64_t *before, const fvv_calibration_bits *bits,
                              fvv_cursor *cursor, fvv_diagnostic *diagnostic) {
  const uint16_t id = e->camera->now.id;
  const uint64_t start = cursor->position;
  for (size_t i = 0; i < value_count(e->camera->now.lens); i++) {
    const uint64_t at = cursor->position;
    const int64_t difference = fvv_unzigzag(fvv_cursor_uleb(cursor));
    if (cursor->failed)
      WRONG(CALIBRATION_PAYLOAD, at, "value %zu of camera %u is cut short or not in its shortest form", i,
            id);
    /* Twice the range covers any change of a value, and sums fit. */
    if (difference < -2 * VALUE_MAX || difference > 2 * VALUE_MAX)
      WRONG(CALIBRATION_RANGE, at, "value %zu of camera %u changes by %" PRId64 ", beyond 2^54", i, id,
            difference);
    e->values[i] = before[i] + difference;
    if (e->values[i] < -VALUE_MAX || e->values[i] > VALUE_MAX)
      WRONG(CALIBRATION_RANGE, at, "value %zu of camera %u is %" PRId64 ", beyond 2^53", i, id, e->values[i]);
  }
  if (!quaternion_valid(e->values, bits))
    WRONG(CALIBRATION_RANGE, start, "length of the quaternion of camera %u is not from 1/2 to 2", id);
  fvv_camera camera = e->camera->now;
  fvv_diagnostic why = {0};
  camera.name_size = 0; /* was checked with its CAMR */
  from_values(e->values, bits, &camera);
  if (fvv_camera_validate(&camera, &why) != FVV_OK)
    WRONG(CALIBRATION_RESULT, start, "camera %u: %s", id, why.message);
  return FVV_OK;
}

static fvv_status read_entries(fvv_calibration *c, const fvv_calibration_bits *bits, int key,
                               fvv_cursor *cursor, entry *entries, size_t count, fvv_diagnostic *diagnostic) {
  static const int64_t zeros[VALUES_MAX];
  for (size_t i = 0; i < count; i++) {
    const uint64_t at = cursor->position, id = fvv_cursor_uleb(cursor);
    if (cursor->failed) WRONG(CALIBRATION_PAYLOAD, at, "entry %zu of %zu is cut short", i, count);
    entries[i].camera = find(c, id);
    if (!entries[i].camera)
      WRONG(CALIBRATION_CAMERA, at, "entry %zu is of camera %" PRIu64 ", expected a moving camera", i, id);
    if (i && entries[i].camera <= entries[i - 1].camera)
      WRONG(CALIBRATION_CAMERA, at, "entry %zu is of camera %" PRIu64 ", expected an identifier above %u", i,
            id, entries[i - 1].camera->now.id);
    const fvv_status status =
        read_values(&entries[i], key ? zeros : entries[i].camera->values, bits, cursor, diagnostic);
    if (status != FVV_OK) return status;
  }
  if (cursor->position != cursor->size)
    WRONG(CALIBRATION_PAYLOAD, cursor->position, "%zu bytes follow the last entry, expected none",
          cursor->size - cursor->position);
  return FVV_OK;
}

static entry *make_entries(const fvv_calibration *c, size_t count) {
  entry *entries = fvv_allocate_array(&c->allocator, count + 1, sizeof *entries);
  if (entries) memset(entries, 0, (count + 1) * sizeof *entries);
  return entries;
}

static void free_entries(const fvv_calibration *c, entry *entries, size_t count) {
  fvv_release(&c->allocator, entries, (count + 1) * sizeof *entries);
}

fvv_status fvv_calibration_decode(fvv_calibration *c, const uint8_t *payload, size_t size, int key,
                                  fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_calibration_bits bits;
  fvv_status status = read_head(c, payload, size, key, &bits, diagnostic);
  const size_t count = status == FVV_OK ? fvv_get_u16(payload + FVV_CALB_COUNT) : 0;
  if (count > c->count)
    status = fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CALIBRATION_CAMERA, FVV_CHUNK_CALIBRATION,
                      FVV_CALB_COUNT, "%zu entries, but %zu cameras move", count, c->count);
  entry *entries = status == FVV_OK ? make_entries(c, count) : NULL;
  if (status == FVV_OK && !entries) status = fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory");
  if (status == FVV_OK) {
    fvv_cursor cursor = {payload, size, FVV_CALB_SIZE, 0};
    status = read_entries(c, &bits, key, &cursor, entries, count, diagnostic);
  }
  if (status == FVV_OK) {
    advance(c, &bits, fvv_get_u16(payload + FVV_CALB_NUMBER));
    take(c, entries, count);
  } else {
    fvv_calibration_reset(c);
  }
  if (entries) free_entries(c, entries, count);
  return status;
}

/* ---- cameras -> payload ----------------------------------------------------------------------------- */

static fvv_status append_uleb(fvv_bytes *bytes, uint64_t value) {
  uint8_t coded[10];
  return fvv_bytes_append(bytes, coded, fvv_put_uleb(coded, value));
}

static fvv_status append_entry(const entry *e, const int64_t *before, fvv_bytes *payload) {
  fvv_status status = append_uleb(payload, e->camera->now.id);
  for (size_t i = 0; i < value_count(e->camera->now.lens) && status == FVV_OK; i++)
    status = append_uleb(payload, fvv_zigzag(e->values[i] - before[i]));
  return status;
}

static int same_constants(const fvv_camera *a, const fvv_camera *b) {
  return a->lens == b->lens && a->width == b->width && a->height == b->height;
}

/* Finds the camera and computes the values of an entry. */
static fvv_status make_entry(fvv_calibration *c, const fvv_camera *camera, const fvv_calibration_bits *bits,
                             int key, entry *e, fvv_diagnostic *diagnostic) {
  static const int64_t zeros[VALUES_MAX];
  const fvv_status valid = fvv_camera_validate(camera, diagnostic);
  if (valid != FVV_OK) {
    if (diagnostic) diagnostic->status = FVV_ERROR_INPUT;
    return FVV_ERROR_INPUT;
  }
  e->camera = find(c, camera->id);
  if (!e->camera || !same_constants(&e->camera->now, camera))
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_CALIBRATION_CAMERA, FVV_CHUNK_CALIBRATION, 0,
                    "camera %u is not a moving camera, or its lens model or picture size changed",
                    camera->id);
  fvv_camera result = e->camera->now;
  if (to_values(camera, bits, key ? zeros : e->camera->values, e->values) &&
      quaternion_valid(e->values, bits)) {
    from_values(e->values, bits, &result);
    if (fvv_camera_validate(&result, NULL) == FVV_OK) return FVV_OK;
  }
  return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_CALIBRATION_RANGE, FVV_CHUNK_CALIBRATION, 0,
                  "camera %u cannot be coded with %u, %u, %u and %u bits", camera->id, bits->rotation,
                  bits->position, bits->pixel, bits->lens);
}

static int by_id(const fvv_camera *cameras, size_t count) {
  for (size_t i = 1; i < count; i++)
    if (cameras[i].id <= cameras[i - 1].id) return 0;
  return 1;
}

fvv_status fvv_calibration_encode(fvv_calibration *c, const fvv_calibration_bits *bits,
                                  const fvv_camera *cameras, size_t count, int key, fvv_bytes *payload,
                                  fvv_diagnostic *diagnostic) {
  static const int64_t zeros[VALUES_MAX];
  fvv_diagnostic_clear(diagnostic);
  payload->size = 0;
  if (!payload->data) payload->allocator = c->allocator;
  if (!bits_valid(bits) || !by_id(cameras, count) || count > c->count ||
      (!key && (!c->has_key || c->number == UINT16_MAX || memcmp(bits, &c->bits, sizeof *bits) != 0)))
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, FVV_CHUNK_CALIBRATION, 0,
                    "bits are out of range, cameras are not in rising order, or there is no key chunk yet");
  entry *entries = make_entries(c, count);
  if (!entries) return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory");
  fvv_status status = FVV_OK;
  for (size_t i = 0; i < count && status == FVV_OK; i++)
    status = make_entry(c, &cameras[i], bits, key, &entries[i], diagnostic);
  if (status == FVV_OK) {
    const uint16_t number = key ? 0 : (uint16_t)(c->number + 1);
    uint8_t head[FVV_CALB_SIZE];
    fvv_put_u16(head + FVV_CALB_NUMBER, number);
    head[FVV_CALB_ROTATION_BITS] = bits->rotation;
    head[FVV_CALB_POSITION_BITS] = bits->position;
    head[FVV_CALB_PIXEL_BITS] = bits->pixel;
    head[FVV_CALB_LENS_BITS] = bits->lens;
    fvv_put_u16(head + FVV_CALB_COUNT, (uint16_t)count);
    status = fvv_bytes_append(payload, head, sizeof head);
    for (size_t i = 0; i < count && status == FVV_OK; i++)
      status = append_entry(&entries[i], key ? zeros : entries[i].camera->values, payload);
    if (status != FVV_OK) fvv_fail(diagnostic, status, 0, 0, 0, "out of memory");
    if (status == FVV_OK) {
      advance(c, bits, number);
      take(c, entries, count);
    }
  }
  free_entries(c, entries, count);
  return status;
}
