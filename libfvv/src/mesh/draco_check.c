/* Draco's decoder trusts what a bitstream declares: 34 bytes can make it ask for 10 GB. This walk over the
 * bitstream (version 2.2, https://google.github.io/draco/spec/) lets through only what is in proportion to
 * its bytes, and only the few coding tools that integers of vertices need: no transforms of Draco's
 * own, metadata or anything deprecated. It knows the layout and nothing of meshes; Draco itself decodes. */
#include "mesh/draco_check.h"

#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "mesh/draco_connectivity.h"
#include "mesh/draco_symbols.h"

enum { SEQUENTIAL = 0, EDGEBREAKER = 1 };
enum { TRAVERSAL_STANDARD = 0, TRAVERSAL_VALENCE = 2 };
enum {
  PREDICT_NONE = 0xfe,
  PREDICT_DIFFERENCE = 0,
  PREDICT_PARALLELOGRAM = 1,
  PREDICT_MULTI_PARALLELOGRAM = 4
};
enum { CREASE_CONTEXTS = 4 };

/* Data type 5 is INT32, types 0, 3 and 1 are POSITION, TEX_COORD and NORMAL; no value is normalised. */
typedef struct attribute {
  const char *name;
  uint8_t descriptor[4]; /* type, data type, components, normalised */
} attribute;
static const attribute positions = {"positions", {0, 5, 3, 0}},
                       texture_coordinates = {"texture coordinates", {3, 5, 2, 0}},
                       normal_indices = {"normals", {1, 5, 2, 0}};
enum { ATTRIBUTES_MAX = 3 };

/* Corners that Draco may walk over for each face while it joins and renumbers vertices. Hulls need less than
 * one; without a bound hostile symbols take time in the square of their number. */
#define STEPS_PER_FACE 16

typedef struct walk {
  fvv_cursor cursor;
  fvv_diagnostic *diagnostic;
  const fvv_allocator *allocator;
  fvv_draco_counts counts;
  const attribute *attributes[ATTRIBUTES_MAX]; /* in the order that clause 8.4 asks for */
  unsigned attribute_count;
  uint8_t method;
  uint8_t traversal;
} walk;

#define FAIL(w, issue, ...)                                                                                  \
  fvv_fail((w)->diagnostic, FVV_ERROR_INVALID, issue, FVV_CHUNK_MESH, FVV_MESH_SIZE + (w)->cursor.position,  \
           __VA_ARGS__)

/* Where a number or block does not end, is not in its shortest form, or contradicts itself. */
static fvv_status broken(walk *w, const char *part) {
  return FAIL(w, FVV_ISSUE_DRACO_STREAM, "the Draco bitstream is cut or malformed in its %s", part);
}

static fvv_status no_memory(walk *w) {
  return fvv_fail(w->diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory to check %lu faces",
                  (unsigned long)w->counts.faces);
}

static unsigned take_u8(walk *w) {
  const uint8_t *p = fvv_cursor_take(&w->cursor, 1);
  return p ? *p : 0;
}

static uint32_t take_u32(walk *w) {
  const uint64_t value = fvv_cursor_uleb(&w->cursor);
  if (value <= UINT32_MAX) return (uint32_t)value;
  w->cursor.failed = 1;
  return 0;
}

static void skip(walk *w, uint64_t size) {
  if (size > SIZE_MAX || !fvv_cursor_take(&w->cursor, (size_t)size)) w->cursor.failed = 1;
}

static fvv_status read_header(walk *w) {
  const uint8_t *p = fvv_cursor_take(&w->cursor, 11);
  if (!p)
    return FAIL(w, FVV_ISSUE_DRACO_HEADER, "%zu bytes of Draco bitstream, its header has 11", w->cursor.size);
  if (memcmp(p, "DRACO", 5) != 0) return FAIL(w, FVV_ISSUE_DRACO_HEADER, "no Draco bitstream");
  if (p[5] != 2 || p[6] != 2)
    return FAIL(w, FVV_ISSUE_DRACO_HEADER, "Draco bitstream version %u.%u, not 2.2", p[5], p[6]);
  if (p[7] != 1)
    return FAIL(w, FVV_ISSUE_DRACO_HEADER, "Draco geometry type %u, not a triangular mesh", p[7]);
  w->method = p[8];
  if (w->method > EDGEBREAKER)
    return FAIL(w, FVV_ISSUE_DRACO_HEADER, "Draco encoding method %u, not sequential or edgebreaker", p[8]);
  if (fvv_get_u16(p + 9))
    return FAIL(w, FVV_ISSUE_DRACO_HEADER, "Draco flags 0x%x, not 0: no metadata",
                (unsigned)fvv_get_u16(p + 9));
  return FVV_OK;
}

static fvv_status read_counts(walk *w) {
  if (w->method == EDGEBREAKER) {
    w->traversal = (uint8_t)take_u8(w);
    w->counts.vertices = take_u32(w);
  }
  w->counts.faces = take_u32(w);
  if (w->method == SEQUENTIAL) w->counts.vertices = take_u32(w);
  return w->cursor.failed ? broken(w, "counts") : FVV_OK;
}

static fvv_status walk_sequential(walk *w) {
  const uint64_t corners = 3 * (uint64_t)w->counts.faces;
  const unsigned coding = take_u8(w);
  if (coding == 0) {
    fvv_draco_skip_symbols(&w->cursor, corners, 1);
  } else if (w->counts.vertices < 1u << 16) {
    skip(w, corners * (w->counts.vertices < 256 ? 1 : 2));
  } else if (w->counts.vertices < 1u << 21) {
    for (uint64_t i = 0; i < corners && !w->cursor.failed; i++) take_u32(w);
  } else {
    skip(w, corners * 4);
  }
  return w->cursor.failed ? broken(w, "faces") : FVV_OK;
}

static void read_events(walk *w, fvv_draco_event *events, uint32_t count) {
  uint32_t source = 0;
  for (uint32_t i = 0; i < count && !w->cursor.failed; i++) {
    const uint32_t advance = take_u32(w), back = take_u32(w);
    if (advance > UINT32_MAX - source || back > source + advance) w->cursor.failed = 1;
    source += advance;
    events[i].source = source;
    events[i].split = source - back;
  }
  const uint8_t *sides = fvv_cursor_take(&w->cursor, ((size_t)count + 7) / 8);
  for (uint32_t i = 0; sides && i < count; i++) events[i].right = sides[i / 8] >> (i % 8) & 1;
}

static void read_valence(walk *w, fvv_draco_connectivity *c, uint8_t *symbols) {
  uint32_t sum = 0;
  c->valence = 1;
  fvv_draco_skip_bits(&w->cursor); /* start faces */
  for (int i = 0; i < FVV_DRACO_CONTEXTS && !w->cursor.failed; i++) {
    const uint32_t count = take_u32(w);
    /* The first symbol is not coded. */
    if (count >= c->symbol_count - sum) w->cursor.failed = 1;
    if (!w->cursor.failed) fvv_draco_read_symbols(&w->cursor, count, symbols + sum);
    c->begin[i] = sum;
    c->end[i] = sum += count;
  }
  if (sum != c->symbol_count - 1) w->cursor.failed = 1;
}

static fvv_status follow(walk *w, const fvv_draco_connectivity *c) {
  uint64_t steps = 0;
  switch (fvv_draco_follow(c, w->allocator, &steps)) {
  case FVV_DRACO_NO_MEMORY:
    return no_memory(w);
  case FVV_DRACO_BROKEN:
    return FAIL(w, FVV_ISSUE_DRACO_STREAM, "%lu edgebreaker symbols do not build %lu vertices",
                (unsigned long)c->symbol_count, (unsigned long)c->vertex_count);
  default:
    if (steps <= STEPS_PER_FACE * (uint64_t)w->counts.faces) return FVV_OK;
    return FAIL(w, FVV_ISSUE_DRACO_STEPS, "edgebreaker splits of %lu faces take %llu steps",
                (unsigned long)w->counts.faces, (unsigned long long)steps);
  }
}

/* events and symbols have room for the counts in c. */
static fvv_status walk_symbols(walk *w, fvv_draco_connectivity *c, fvv_draco_event *events,
                               uint8_t *symbols) {
  read_events(w, events, c->event_count);
  if (w->cursor.failed) return broken(w, "topology splits");
  c->events = events;
  c->symbols = symbols;
  if (w->traversal == TRAVERSAL_VALENCE) {
    read_valence(w, c, symbols);
  } else {
    fvv_draco_read_standard(&w->cursor, c->symbol_count, symbols);
    fvv_draco_skip_bits(&w->cursor); /* start faces */
  }
  return w->cursor.failed ? broken(w, "edgebreaker symbols") : follow(w, c);
}

static fvv_status walk_edgebreaker(walk *w) {
  if (w->traversal != TRAVERSAL_STANDARD && w->traversal != TRAVERSAL_VALENCE)
    return FAIL(w, FVV_ISSUE_DRACO_STREAM, "edgebreaker traversal %u, not standard or valence", w->traversal);
  fvv_draco_connectivity c = {.vertex_count = w->counts.vertices};
  const unsigned seams = take_u8(w);
  c.symbol_count = take_u32(w);
  c.split_count = take_u32(w);
  c.event_count = take_u32(w);
  if (w->cursor.failed) return broken(w, "connectivity header");
  if (seams) return FAIL(w, FVV_ISSUE_DRACO_ATTRIBUTE, "%u attributes with seams, expected none", seams);
  /* A component may begin with one face that has no symbol, and has at least three more. */
  if (c.symbol_count > w->counts.faces || w->counts.faces > (uint64_t)c.symbol_count + c.symbol_count / 3)
    return FAIL(w, FVV_ISSUE_DRACO_STREAM, "%lu edgebreaker symbols for %lu faces",
                (unsigned long)c.symbol_count, (unsigned long)w->counts.faces);
  if (c.split_count > c.symbol_count || c.event_count > c.symbol_count)
    return FAIL(w, FVV_ISSUE_DRACO_STREAM, "%lu splits and %lu events among %lu edgebreaker symbols",
                (unsigned long)c.split_count, (unsigned long)c.event_count, (unsigned long)c.symbol_count);
  /* One more than needed: nothing is allocated for nothing. */
  const size_t event_room = (size_t)c.event_count + 1, symbol_room = (size_t)c.symbol_count + 1;
  fvv_draco_event *events = fvv_allocate_array(w->allocator, event_room, sizeof *events);
  uint8_t *symbols = fvv_allocate(w->allocator, symbol_room);
  const fvv_status status = events && symbols ? walk_symbols(w, &c, events, symbols) : no_memory(w);
  fvv_release(w->allocator, events, event_room * sizeof *events);
  fvv_release(w->allocator, symbols, symbol_room);
  return status;
}

static fvv_status walk_descriptor(walk *w, const attribute *expected) {
  const uint8_t *p = fvv_cursor_take(&w->cursor, sizeof expected->descriptor);
  if (!p) return broken(w, "attribute header");
  if (memcmp(p, expected->descriptor, sizeof expected->descriptor) != 0)
    return FAIL(
        w, FVV_ISSUE_DRACO_ATTRIBUTE,
        "expected %s: type %u, data type %u, %u components; found type %u, data type %u, %u %scomponents",
        expected->name, expected->descriptor[0], expected->descriptor[1], expected->descriptor[2], p[0], p[1],
        p[2], p[3] ? "normalised " : "");
  take_u32(w); /* its identifier means nothing to us */
  return FVV_OK;
}

/* One attributes decoder for all vertices: how many attributes, what each of them is, how each is coded. */
static fvv_status walk_attribute_headers(walk *w) {
  static const uint8_t edgebreaker[] = {1, 0xff, 0};
  const size_t size = w->method == EDGEBREAKER ? sizeof edgebreaker : 1;
  const uint8_t *p = fvv_cursor_take(&w->cursor, size);
  if (!p) return broken(w, "attribute header");
  if (memcmp(p, edgebreaker, size) != 0)
    return FAIL(w, FVV_ISSUE_DRACO_ATTRIBUTE, "expected attributes coded per vertex, found others");
  if (w->method == EDGEBREAKER && take_u8(w) > 1)
    return FAIL(w, FVV_ISSUE_DRACO_STREAM, "vertices are traversed in an unknown order");
  const uint32_t count = take_u32(w);
  if (w->cursor.failed) return broken(w, "attribute header");
  if (count != w->attribute_count)
    return FAIL(w, FVV_ISSUE_DRACO_ATTRIBUTE, "%lu attributes, the MESH header declares %u",
                (unsigned long)count, w->attribute_count);
  for (unsigned i = 0; i < count; i++) {
    const fvv_status status = walk_descriptor(w, w->attributes[i]);
    if (status != FVV_OK) return status;
  }
  for (unsigned i = 0; i < count; i++) {
    const unsigned coding = take_u8(w);
    if (w->cursor.failed) return broken(w, "attribute header");
    if (coding != 1)
      return FAIL(w, FVV_ISSUE_DRACO_ATTRIBUTE, "%s coded in way %u, not as integers", w->attributes[i]->name,
                  coding);
  }
  return FVV_OK;
}

static fvv_status walk_prediction(walk *w, const attribute *of, unsigned *prediction) {
  *prediction = take_u8(w);
  const int known = *prediction == PREDICT_NONE || *prediction == PREDICT_DIFFERENCE ||
                    (w->method == EDGEBREAKER &&
                     (*prediction == PREDICT_PARALLELOGRAM || *prediction == PREDICT_MULTI_PARALLELOGRAM));
  if (!w->cursor.failed && !known)
    return FAIL(w, FVV_ISSUE_DRACO_STREAM, "%s predicted by method %u, which is not one for them", of->name,
                *prediction);
  if (!w->cursor.failed && *prediction != PREDICT_NONE && take_u8(w) != 1) return broken(w, "prediction");
  return w->cursor.failed ? broken(w, "prediction") : FVV_OK;
}

static fvv_status walk_values(walk *w, const attribute *of) {
  const uint32_t components = of->descriptor[2];
  const uint64_t values = components * (uint64_t)w->counts.vertices;
  unsigned prediction;
  const fvv_status status = walk_prediction(w, of, &prediction);
  if (status != FVV_OK) return status;
  const unsigned compressed = take_u8(w);
  if (compressed > 1) return broken(w, of->name);
  if (compressed) {
    fvv_draco_skip_symbols(&w->cursor, values, components);
  } else {
    const unsigned width = take_u8(w);
    if (width < 1 || width > 4) return broken(w, of->name);
    skip(w, width * values);
  }
  for (int i = 0; i < CREASE_CONTEXTS && prediction == PREDICT_MULTI_PARALLELOGRAM; i++) {
    const uint32_t flags = take_u32(w);
    if (flags > 3 * (uint64_t)w->counts.faces) return broken(w, "crease flags");
    if (flags) fvv_draco_skip_bits(&w->cursor);
  }
  if (prediction != PREDICT_NONE) skip(w, 8); /* least and largest value */
  return w->cursor.failed ? broken(w, of->name) : FVV_OK;
}

fvv_status fvv_draco_read_counts(const uint8_t *data, size_t size, fvv_draco_counts *counts,
                                 fvv_diagnostic *diagnostic) {
  walk w = {.cursor = {data, size, 0, 0}, .diagnostic = diagnostic};
  fvv_status status = read_header(&w);
  if (status == FVV_OK) status = read_counts(&w);
  *counts = w.counts;
  return status;
}

static fvv_status compare_counts(walk *w, fvv_draco_counts declared) {
  if (w->counts.vertices != declared.vertices || w->counts.faces != declared.faces)
    return FAIL(w, FVV_ISSUE_DRACO_COUNTS,
                "the Draco bitstream has %lu vertices and %lu faces, the MESH header declares %lu and %lu",
                (unsigned long)w->counts.vertices, (unsigned long)w->counts.faces,
                (unsigned long)declared.vertices, (unsigned long)declared.faces);
  if (declared.vertices > FVV_DRACO_COUNT_MAX || declared.faces > FVV_DRACO_COUNT_MAX)
    return fvv_fail(w->diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_MESH, FVV_MESH_SIZE,
                    "%lu vertices and %lu faces are more than Draco can count",
                    (unsigned long)declared.vertices, (unsigned long)declared.faces);
  return FVV_OK;
}

fvv_status fvv_draco_check(const uint8_t *data, size_t size, fvv_draco_counts declared, int texture,
                           int normals, const fvv_allocator *allocator, fvv_diagnostic *diagnostic) {
  walk w = {.cursor = {data, size, 0, 0},
            .diagnostic = diagnostic,
            .allocator = allocator,
            .attributes = {&positions},
            .attribute_count = 1};
  if (texture) w.attributes[w.attribute_count++] = &texture_coordinates;
  if (normals) w.attributes[w.attribute_count++] = &normal_indices;
  fvv_status status = read_header(&w);
  if (status == FVV_OK) status = read_counts(&w);
  if (status == FVV_OK) status = compare_counts(&w, declared);
  if (status == FVV_OK) status = w.method == EDGEBREAKER ? walk_edgebreaker(&w) : walk_sequential(&w);
  if (status == FVV_OK) status = walk_attribute_headers(&w);
  for (unsigned i = 0; status == FVV_OK && i < w.attribute_count; i++)
    status = walk_values(&w, w.attributes[i]);
  if (status == FVV_OK && w.cursor.position != size)
    return FAIL(&w, FVV_ISSUE_DRACO_STREAM, "%zu bytes follow the Draco bitstream", size - w.cursor.position);
  return status;
}
