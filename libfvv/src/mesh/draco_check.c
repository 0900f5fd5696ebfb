/* Walks a Draco bitstream from outside before Draco sees it: its header and sizes, its entropy-coded parts,
 * and what its connectivity will cost the decoder (clause 8.4). */
#include "mesh/draco_check.h"

#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "fvv/types.h"

/* Edgebreaker symbols in Draco's numbering (Rossignac, IEEE TVCG 5(1), 1999). */
enum { SYMBOL_C, SYMBOL_S, SYMBOL_L, SYMBOL_R, SYMBOL_E, SYMBOL_COUNT };

/* Each of the functions that skip or read moves the cursor to the end of its part and returns 1, or 0 when
 * the part is cut or malformed. They follow spec/draco.md. */

/* Raw symbols are below 2^18 in every stream of Draco's encoder; the tags are numbers of bits, 0 to 32.
 * Draco's decoder checks neither and would hold 768 bytes for each byte of such a table. */
#define RAW_ALPHABET_MAX ((uint64_t)1 << 18)
#define TAG_ALPHABET_MAX 33

/* Probabilities of tags and of edgebreaker symbols have 12 bits, the least that Draco uses. */
#define SMALL_PRECISION_BITS 12
#define SMALL_PRECISION (1u << SMALL_PRECISION_BITS)

static int fail(fvv_cursor *cursor) {
  cursor->failed = 1;
  return 0;
}

/* A sequence of bits coded by rABS: probability, size, bytes. */
static int skip_bits(fvv_cursor *cursor) {
  fvv_cursor_take(cursor, 1); /* probability of a zero */
  const uint64_t size = fvv_cursor_uleb(cursor);
  if (!size || size > SIZE_MAX) return fail(cursor);
  return fvv_cursor_take(cursor, (size_t)size) != NULL;
}

/* Reads a probability table; probabilities, when not NULL, has room for most entries. The two low bits of an
 * entry's first byte count the bytes that follow, 3 says that the other six count further zeros. */
static int read_alphabet(fvv_cursor *cursor, uint64_t most, uint32_t precision, uint32_t *probabilities) {
  const uint64_t count = fvv_cursor_uleb(cursor);
  if (!count || count > most) return fail(cursor);
  uint64_t sum = 0;
  for (uint64_t i = 0; i < count; i++) {
    const uint8_t *first = fvv_cursor_take(cursor, 1);
    if (!first) return 0;
    const unsigned token = *first & 3;
    uint32_t value = *first >> 2;
    if (token == 3) {
      if (value >= count - i) return fail(cursor);
      i += value;
      continue;
    }
    for (unsigned b = 0; b < token; b++) {
      const uint8_t *more = fvv_cursor_take(cursor, 1);
      if (!more) return 0;
      value |= (uint32_t)*more << (8 * (b + 1) - 2);
    }
    sum += value;
    if (probabilities) probabilities[i] = value;
  }
  return sum == precision || fail(cursor);
}

/* rANS, read from the back (J. Duda, arXiv:1311.2540). */
typedef struct rans {
  const uint8_t *bytes;
  size_t left;
  uint32_t state;
} rans;

/* The two high bits of the last byte say in how many bytes the initial state lies. */
static int open_rans(fvv_cursor *cursor, unsigned precision_bits, rans *coder) {
  const uint64_t size = fvv_cursor_uleb(cursor);
  if (!size || size > SIZE_MAX) return fail(cursor);
  const uint8_t *bytes = fvv_cursor_take(cursor, (size_t)size);
  if (!bytes) return 0;
  const unsigned length = (bytes[size - 1] >> 6) + 1u;
  if (size < length) return fail(cursor);
  uint32_t state = bytes[size - 1] & 63;
  for (unsigned i = 2; i <= length; i++) state = state << 8 | bytes[size - i];
  const uint32_t base = 4u << precision_bits;
  coder->bytes = bytes;
  coder->left = (size_t)size - length;
  coder->state = state + base;
  return coder->state < base << 8 || fail(cursor);
}

/* A coder of tags or edgebreaker symbols with its tables. */
typedef struct small_coder {
  rans input;
  uint32_t probability[TAG_ALPHABET_MAX];
  uint32_t start[TAG_ALPHABET_MAX];
  uint8_t value_at[SMALL_PRECISION];
} small_coder;

static int open_small(fvv_cursor *cursor, uint64_t alphabet, small_coder *coder) {
  memset(coder, 0, sizeof *coder);
  if (!read_alphabet(cursor, alphabet, SMALL_PRECISION, coder->probability)) return 0;
  uint32_t sum = 0;
  for (unsigned value = 0; value < TAG_ALPHABET_MAX; value++) {
    coder->start[value] = sum;
    memset(coder->value_at + sum, (int)value, coder->probability[value]);
    sum += coder->probability[value];
  }
  return open_rans(cursor, SMALL_PRECISION_BITS, &coder->input);
}

/* input: of the coder, in a variable of the caller's, so that it stays in registers. */
static unsigned next_small(const small_coder *coder, rans *input) {
  while (input->state < 4 * SMALL_PRECISION && input->left)
    input->state = input->state << 8 | input->bytes[--input->left];
  const uint32_t rest = input->state % SMALL_PRECISION;
  const unsigned value = coder->value_at[rest];
  input->state = input->state / SMALL_PRECISION * coder->probability[value] + rest - coder->start[value];
  return value;
}

static int skip_tagged(fvv_cursor *cursor, uint64_t count, uint32_t components) {
  small_coder tags;
  if (!open_small(cursor, TAG_ALPHABET_MAX, &tags)) return 0;
  rans input = tags.input;
  uint64_t bits = 0;
  for (uint64_t i = 0; i < count / components; i++) bits += (uint64_t)components * next_small(&tags, &input);
  const uint64_t size = bits / 8 + (bits % 8 != 0);
  if (size > SIZE_MAX) return fail(cursor);
  return fvv_cursor_take(cursor, (size_t)size) != NULL;
}

/* Raw symbols begin with a number of bits, which decides the precision; 0 when it is out of range. */
static unsigned read_precision(fvv_cursor *cursor) {
  const uint8_t *bits = fvv_cursor_take(cursor, 1);
  if (!bits) return 0;
  if (*bits < 1 || *bits > 18) {
    cursor->failed = 1;
    return 0;
  }
  const unsigned wanted = 3u * *bits / 2;
  return wanted < SMALL_PRECISION_BITS ? SMALL_PRECISION_BITS : wanted > 20 ? 20 : wanted;
}

static int skip_raw(fvv_cursor *cursor) {
  const unsigned precision_bits = read_precision(cursor);
  if (!precision_bits) return 0;
  rans coder;
  return read_alphabet(cursor, RAW_ALPHABET_MAX, 1u << precision_bits, NULL) &&
         open_rans(cursor, precision_bits, &coder);
}

/* count values in tuples of that many components, coded raw or tagged; no bytes at all for count 0. */
static int skip_symbols(fvv_cursor *cursor, uint64_t count, uint32_t components) {
  if (!count) return 1;
  const uint8_t *scheme = fvv_cursor_take(cursor, 1);
  if (!scheme) return 0;
  switch (*scheme) {
  case 0:
    return skip_tagged(cursor, count, components);
  case 1:
    return skip_raw(cursor);
  default:
    return fail(cursor);
  }
}

/* Bits from the low end of each byte on; 0 after the end, where position goes on counting. */
typedef struct bit_reader {
  const uint8_t *bytes;
  uint64_t size;
  uint64_t position;
} bit_reader;

static unsigned read_bits(bit_reader *reader, unsigned count) {
  unsigned value = 0;
  for (unsigned i = 0; i < count; i++, reader->position++)
    if (reader->position / 8 < reader->size)
      value |= (unsigned)(reader->bytes[reader->position / 8] >> (reader->position % 8) & 1) << i;
  return value;
}

static int read_tagged(fvv_cursor *cursor, uint32_t count, uint8_t *symbols) {
  small_coder tags;
  /* Five symbols have at most three bits. */
  if (!open_small(cursor, 4, &tags)) return 0;
  rans input = tags.input;
  bit_reader reader = {cursor->data + cursor->position, cursor->size - cursor->position, 0};
  for (uint32_t i = 0; i < count; i++) {
    symbols[i] = (uint8_t)read_bits(&reader, next_small(&tags, &input));
    if (symbols[i] >= SYMBOL_COUNT) return fail(cursor);
  }
  const uint64_t size = (reader.position + 7) / 8;
  if (size > reader.size) return fail(cursor);
  return fvv_cursor_take(cursor, (size_t)size) != NULL;
}

static __attribute__((noinline)) int read_raw(fvv_cursor *cursor, uint32_t count, uint8_t *symbols) {
  small_coder coder;
  if (read_precision(cursor) != SMALL_PRECISION_BITS) return fail(cursor);
  if (!open_small(cursor, SYMBOL_COUNT, &coder)) return 0;
  rans input = coder.input;
  for (uint32_t i = 0; i < count; i++) symbols[i] = (uint8_t)next_small(&coder, &input);
  return 1;
}

/* The same for count edgebreaker symbols, which go to symbols in the order of the stream. */
static int read_symbols(fvv_cursor *cursor, uint32_t count, uint8_t *symbols) {
  if (!count) return 1;
  const uint8_t *scheme = fvv_cursor_take(cursor, 1);
  if (!scheme) return 0;
  switch (*scheme) {
  case 0:
    return read_tagged(cursor, count, symbols);
  case 1:
    return read_raw(cursor, count, symbols);
  default:
    return fail(cursor);
  }
}

/* The same for the symbols of standard edgebreaker: their size, then 1 bit for C and 3 for each other. */
static int read_standard(fvv_cursor *cursor, uint32_t count, uint8_t *symbols) {
  const uint64_t size = fvv_cursor_uleb(cursor);
  const uint8_t *bytes = size > SIZE_MAX ? NULL : fvv_cursor_take(cursor, (size_t)size);
  if (!bytes) return fail(cursor);
  bit_reader reader = {bytes, size, 0};
  /* Draco reads zeros, which are C, after the end: symbols that took no bytes. */
  for (uint32_t i = 0; i < count; i++) {
    if (reader.position >= 8 * size) return fail(cursor);
    symbols[i] = (uint8_t)(read_bits(&reader, 1) ? SYMBOL_S + read_bits(&reader, 2) : SYMBOL_C);
  }
  return (reader.position + 7) / 8 == size || fail(cursor);
}

/* Edgebreaker (Rossignac, IEEE TVCG 5(1), 1999; decoded backwards after Isenburg and Snoeyink, Spirale
 * Reversi, 2001) on boundary loops alone. No face is built: a loop of vertices with their valences says all
 * about what Draco's decoder will do. Its S costs as many steps as the joined vertex has faces, so that a few
 * kilobytes of hostile symbols around one vertex take it time in the square of their number; here every
 * symbol is one step. */

/* Contexts of valence edgebreaker: valences up to 2, 3, 4, 5, 6, from 7 on. */
#define VALENCE_CONTEXTS 6

/* A handle or a hole: the symbol source leaves an edge to which the S of symbol split is glued. Both count
 * from the last symbol backwards, as the encoder did. */
typedef struct split_event {
  uint32_t source;
  uint32_t split;
  int right; /* of the two edges of the source's face that are not active: the right one */
} split_event;

typedef struct edgebreaker_mesh {
  uint32_t vertex_count;
  uint32_t symbol_count;
  uint32_t split_count; /* S among the symbols */
  uint32_t event_count;
  const split_event *events;
  /* Standard: symbol_count of them in order. Valence: one less, for the first is an E; the run of context i
   * is between begin[i] and end[i] and is used from its end. */
  const uint8_t *symbols;
  uint32_t begin[VALENCE_CONTEXTS];
  uint32_t end[VALENCE_CONTEXTS];
  int valence;
  uint8_t *order; /* room for all symbols in the order of their use, or NULL */
} edgebreaker_mesh;

typedef enum outcome {
  CONNECTIVITY_SOUND,
  CONNECTIVITY_BROKEN, /* the symbols do not fit each other or the counts */
  CONNECTIVITY_NO_MEMORY
} outcome;

#define NONE UINT32_MAX

/* Vertices carry Draco's own numbers. An edge of a boundary is named by the vertex that it leaves. */
typedef struct boundary {
  const edgebreaker_mesh *given;
  uint32_t *follower; /* of each vertex along its loop */
  uint32_t *valence;
  uint32_t *alias;  /* the vertex that an S made this one the same as; itself otherwise */
  uint32_t *stack;  /* active edges; the face of the next symbol is put onto the top one */
  uint32_t *joined; /* vertices that an S made the same as another one, in order */
  uint32_t *glued;  /* by symbol: the edge that an event keeps for this S, or NONE */
  uint32_t made, most;
  uint32_t height;
  uint32_t joined_count;
  uint32_t events_left;
  uint32_t left[VALENCE_CONTEXTS];
  uint64_t steps;
} boundary;

static uint32_t new_vertex(boundary *b) {
  const uint32_t v = b->made++;
  b->valence[v] = 2;
  b->alias[v] = v;
  return v;
}

/* What an edge that waits, on the stack or for its S, is called now: another S may have joined the vertex
 * that it leaves. Never a cycle: only vertices that are on a loop, and so no aliases themselves, are joined.
 */
static uint32_t present_name(boundary *b, uint32_t v) {
  while (b->alias[v] != v) v = b->alias[v] = b->alias[b->alias[v]];
  return v;
}

/* The next symbol, SYMBOL_COUNT when its context has none left. */
static unsigned symbol_at(boundary *b, uint32_t i) {
  if (!b->given->valence) return b->given->symbols[i];
  if (i == 0) return SYMBOL_E;
  const uint32_t valence = b->valence[b->follower[b->stack[b->height - 1]]];
  const unsigned context = valence < 2 ? 0 : valence > 7 ? 5 : valence - 2;
  if (b->left[context] == b->given->begin[context]) return SYMBOL_COUNT;
  return b->given->symbols[--b->left[context]];
}

/* Each of these puts one face onto the active edge p -> n; 0 when that is impossible. */

static int put_c(boundary *b) {
  const uint32_t p = b->stack[b->height - 1], n = b->follower[p], m = b->follower[n];
  if (m == p) return 0;
  b->follower[p] = m;
  b->valence[p]++;
  b->valence[m]++;
  return 1;
}

static int put_lr(boundary *b, int right, uint32_t *tip) {
  if (b->made == b->most) return 0;
  const uint32_t p = b->stack[b->height - 1], n = b->follower[p], v = new_vertex(b);
  b->follower[p] = v;
  b->follower[v] = n;
  b->valence[p]++;
  b->valence[n]++;
  if (right) b->stack[b->height - 1] = v;
  *tip = right ? p : n;
  return 1;
}

static int put_s(boundary *b, uint32_t i) {
  const uint32_t second = b->stack[--b->height];
  if (b->glued && b->glued[i] != NONE) b->stack[b->height++] = b->glued[i];
  if (!b->height || b->joined_count == b->given->split_count) return 0;
  const uint32_t first = present_name(b, b->stack[b->height - 1]), n = b->follower[second],
                 m = b->follower[first];
  if (first == second || n == first) return 0;
  b->steps += b->valence[n];
  b->valence[first] += b->valence[n];
  b->valence[second]++;
  b->valence[m]++;
  b->follower[second] = m;
  b->follower[first] = b->follower[n];
  b->alias[n] = first;
  b->joined[b->joined_count++] = n;
  b->stack[b->height - 1] = second;
  return 1;
}

static int put_e(boundary *b, uint32_t *tip) {
  if (b->most - b->made < 3) return 0;
  const uint32_t first = new_vertex(b), second = new_vertex(b), third = new_vertex(b);
  b->follower[third] = second;
  b->follower[second] = first;
  b->follower[first] = third;
  b->stack[b->height++] = third;
  *tip = first;
  return 1;
}

/* Events end in the order in which their sources come; those of one source belong to its E, L or R. */
static int keep_events(boundary *b, uint32_t i, uint32_t tip) {
  const uint32_t count = b->given->symbol_count, id = count - 1 - i;
  for (; b->events_left; b->events_left--) {
    const split_event *event = &b->given->events[b->events_left - 1];
    if (event->source < id) return 1;
    if (event->source > id || event->split >= count) return 0;
    b->glued[count - 1 - event->split] = event->right ? tip : b->follower[b->stack[b->height - 1]];
  }
  return 1;
}

static int put_face(boundary *b, uint32_t i) {
  if (b->height) b->stack[b->height - 1] = present_name(b, b->stack[b->height - 1]);
  const unsigned symbol = b->height || i == 0 ? symbol_at(b, i) : SYMBOL_COUNT;
  if (b->given->order) b->given->order[i] = (uint8_t)symbol;
  uint32_t tip;
  if (symbol != SYMBOL_E && !b->height) return 0;
  switch (symbol) {
  case SYMBOL_C:
    return put_c(b);
  case SYMBOL_S:
    return put_s(b, i);
  case SYMBOL_L:
  case SYMBOL_R:
    return put_lr(b, symbol == SYMBOL_R, &tip) && keep_events(b, i, tip);
  case SYMBOL_E:
    return put_e(b, &tip) && keep_events(b, i, tip);
  default:
    return 0;
  }
}

/* Draco fills each gap that a join left with the last vertex, around which it walks. */
static void renumber(boundary *b) {
  for (uint32_t i = 0; i < b->joined_count; i++) b->valence[b->joined[i]] = 0;
  uint32_t count = b->made;
  for (uint32_t i = 0; i < b->joined_count; i++) {
    while (count && !b->valence[count - 1]) count--;
    const uint32_t gap = b->joined[i], last = count - 1;
    if (!count || last < gap) continue;
    b->steps += b->valence[last];
    b->valence[gap] = b->valence[last];
    b->valence[last] = 0;
  }
}

/* Engines of wasm compile what has such a loop again while it runs: not part of a larger function. */
static __attribute__((noinline)) outcome build_faces(boundary *b) {
  const edgebreaker_mesh *given = b->given;
  /* A copy that nothing else refers to stays in registers. */
  boundary copy = *b;
  for (uint32_t i = 0; i < given->symbol_count; i++)
    if (!put_face(&copy, i)) return CONNECTIVITY_BROKEN;
  *b = copy;
  if (b->joined_count != given->split_count || b->made - b->joined_count != given->vertex_count)
    return CONNECTIVITY_BROKEN;
  renumber(b);
  return CONNECTIVITY_SOUND;
}

/* Follows the symbols along the boundary. *steps: how many corners Draco will walk over besides its linear
 * work: around both sides of every S and around every vertex that it renumbers. */
static outcome follow_symbols(const edgebreaker_mesh *connectivity, const fvv_allocator *allocator,
                              uint64_t *steps) {
  const uint64_t most = (uint64_t)connectivity->vertex_count + connectivity->split_count;
  const uint64_t symbols = connectivity->symbol_count, glued = connectivity->event_count ? symbols : 0;
  /* All tables in one block. Each E takes one place on the stack. */
  const uint64_t total = 3 * most + symbols + connectivity->split_count + glued;
  if (most >= NONE) return CONNECTIVITY_BROKEN;
  if (!symbols || total > SIZE_MAX / sizeof(uint32_t))
    return symbols ? CONNECTIVITY_NO_MEMORY : CONNECTIVITY_BROKEN;
  uint32_t *block = fvv_allocate(allocator, (size_t)total * sizeof(uint32_t));
  if (!block) return CONNECTIVITY_NO_MEMORY;
  boundary b = {.given = connectivity, .follower = block, .most = (uint32_t)most};
  b.valence = b.follower + most;
  b.alias = b.valence + most;
  b.stack = b.alias + most;
  b.joined = b.stack + symbols;
  b.events_left = connectivity->event_count;
  if (glued) b.glued = b.joined + connectivity->split_count;
  for (uint64_t i = 0; i < glued; i++) b.glued[i] = NONE;
  for (int i = 0; i < VALENCE_CONTEXTS; i++) b.left[i] = connectivity->end[i];
  const outcome verdict = build_faces(&b);
  *steps = b.steps;
  fvv_release(allocator, block, (size_t)total * sizeof(uint32_t));
  return verdict;
}

/* Draco's decoder trusts what a bitstream declares: 34 bytes can make it ask for 10 GB. This walk over the
 * bitstream (spec/draco.md) lets through only what is in proportion to
 * its bytes, and only the few coding tools that integers of vertices need: no transforms of Draco's
 * own, metadata or anything deprecated. It knows the layout and nothing of meshes; Draco itself decodes. */

enum { SEQUENTIAL = 0, EDGEBREAKER = 1 };
enum { TRAVERSAL_STANDARD = 0, TRAVERSAL_VALENCE = 2 };
enum { PREDICT_DIFFERENCE = 0, PREDICT_PARALLELOGRAM = 1, PREDICT_MULTI_PARALLELOGRAM = 4 };
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
  const attribute *attributes[ATTRIBUTES_MAX]; /* in the order that clause 8.4 requires */
  unsigned attribute_count;
  uint8_t method;
  uint8_t traversal;
  fvv_draco_symbols *symbols; /* wanted, or NULL */
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

/* Draco's encoder writes corners as they are (way 1). Differences (way 0) are an option of its own, which
 * clause 3 of spec/draco.md forbids. */
static fvv_status walk_sequential(walk *w) {
  const uint64_t corners = 3 * (uint64_t)w->counts.faces;
  const unsigned way = take_u8(w);
  if (!w->cursor.failed && way != 1)
    return FAIL(w, FVV_ISSUE_DRACO_STREAM, "corners of faces in way %u, not as they are", way);
  if (w->counts.vertices < 1u << 16) {
    skip(w, corners * (w->counts.vertices < 256 ? 1 : 2));
  } else if (w->counts.vertices < 1u << 21) {
    for (uint64_t i = 0; i < corners && !w->cursor.failed; i++) take_u32(w);
  } else {
    skip(w, corners * 4);
  }
  return w->cursor.failed ? broken(w, "faces") : FVV_OK;
}

static void read_events(walk *w, split_event *events, uint32_t count) {
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

static void read_valence(walk *w, edgebreaker_mesh *c, uint8_t *symbols) {
  uint32_t sum = 0;
  c->valence = 1;
  skip_bits(&w->cursor); /* start faces */
  for (int i = 0; i < VALENCE_CONTEXTS && !w->cursor.failed; i++) {
    const uint32_t count = take_u32(w);
    /* The first symbol is not coded. */
    if (count >= c->symbol_count - sum) w->cursor.failed = 1;
    if (!w->cursor.failed) read_symbols(&w->cursor, count, symbols + sum);
    c->begin[i] = sum;
    c->end[i] = sum += count;
  }
  if (sum != c->symbol_count - 1) w->cursor.failed = 1;
}

static fvv_status follow(walk *w, const edgebreaker_mesh *c) {
  uint64_t steps = 0;
  switch (follow_symbols(c, w->allocator, &steps)) {
  case CONNECTIVITY_NO_MEMORY:
    return no_memory(w);
  case CONNECTIVITY_BROKEN:
    return FAIL(w, FVV_ISSUE_DRACO_STREAM, "%lu edgebreaker symbols do not build %lu vertices",
                (unsigned long)c->symbol_count, (unsigned long)c->vertex_count);
  default:
    if (steps <= STEPS_PER_FACE * (uint64_t)w->counts.faces) return FVV_OK;
    return FAIL(w, FVV_ISSUE_DRACO_STEPS, "edgebreaker splits of %lu faces take %llu steps",
                (unsigned long)w->counts.faces, (unsigned long long)steps);
  }
}

/* events and symbols have room for the counts in c. */
static fvv_status walk_symbols(walk *w, edgebreaker_mesh *c, split_event *events, uint8_t *symbols) {
  read_events(w, events, c->event_count);
  if (w->cursor.failed) return broken(w, "topology splits");
  c->events = events;
  c->symbols = symbols;
  if (w->traversal == TRAVERSAL_VALENCE) {
    read_valence(w, c, symbols);
  } else {
    read_standard(&w->cursor, c->symbol_count, symbols);
    skip_bits(&w->cursor); /* start faces */
  }
  return w->cursor.failed ? broken(w, "edgebreaker symbols") : follow(w, c);
}

static fvv_status walk_edgebreaker(walk *w) {
  if (w->traversal != TRAVERSAL_STANDARD && w->traversal != TRAVERSAL_VALENCE)
    return FAIL(w, FVV_ISSUE_DRACO_STREAM, "edgebreaker traversal %u, not standard or valence", w->traversal);
  edgebreaker_mesh c = {.vertex_count = w->counts.vertices};
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
  split_event *events = fvv_allocate_array(w->allocator, event_room, sizeof *events);
  uint8_t *symbols = fvv_allocate(w->allocator, symbol_room);
  const int wanted = w->symbols && w->traversal == TRAVERSAL_VALENCE;
  if (wanted) {
    w->symbols->values = c.order = fvv_allocate(w->allocator, symbol_room);
    w->symbols->count = c.symbol_count;
  }
  const int complete = events && symbols && (c.order || !wanted);
  const fvv_status status = complete ? walk_symbols(w, &c, events, symbols) : no_memory(w);
  if (wanted) w->symbols->end = w->cursor.position;
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
  const int known = *prediction == PREDICT_DIFFERENCE ||
                    (w->method == EDGEBREAKER &&
                     (*prediction == PREDICT_PARALLELOGRAM || *prediction == PREDICT_MULTI_PARALLELOGRAM));
  if (!w->cursor.failed && !known)
    return FAIL(w, FVV_ISSUE_DRACO_STREAM, "%s predicted by method %u, which is not one for them", of->name,
                *prediction);
  if (!w->cursor.failed && take_u8(w) != 1) return broken(w, "prediction");
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
    skip_symbols(&w->cursor, values, components);
  } else {
    const unsigned width = take_u8(w);
    if (width < 1 || width > 4) return broken(w, of->name);
    skip(w, width * values);
  }
  for (int i = 0; i < CREASE_CONTEXTS && prediction == PREDICT_MULTI_PARALLELOGRAM; i++) {
    const uint32_t flags = take_u32(w);
    if (flags > 3 * (uint64_t)w->counts.faces) return broken(w, "crease flags");
    if (flags) skip_bits(&w->cursor);
  }
  skip(w, 8); /* least and largest value */
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

static fvv_status walk_all(walk *w, fvv_draco_counts declared) {
  fvv_status status = read_header(w);
  if (status == FVV_OK) status = read_counts(w);
  if (status == FVV_OK) status = compare_counts(w, declared);
  if (status == FVV_OK) status = w->method == EDGEBREAKER ? walk_edgebreaker(w) : walk_sequential(w);
  if (status == FVV_OK) status = walk_attribute_headers(w);
  for (unsigned i = 0; status == FVV_OK && i < w->attribute_count; i++)
    status = walk_values(w, w->attributes[i]);
  if (status == FVV_OK && w->cursor.position != w->cursor.size)
    return FAIL(w, FVV_ISSUE_DRACO_STREAM, "%zu bytes follow the Draco bitstream",
                w->cursor.size - w->cursor.position);
  return status;
}

fvv_status fvv_draco_check(const uint8_t *data, size_t size, fvv_draco_counts declared, int texture,
                           int normals, const fvv_allocator *allocator, fvv_draco_symbols *symbols,
                           fvv_diagnostic *diagnostic) {
  walk w = {.cursor = {data, size, 0, 0},
            .diagnostic = diagnostic,
            .allocator = allocator,
            .attributes = {&positions},
            .attribute_count = 1,
            .symbols = symbols};
  if (symbols) memset(symbols, 0, sizeof *symbols);
  if (texture) w.attributes[w.attribute_count++] = &texture_coordinates;
  if (normals) w.attributes[w.attribute_count++] = &normal_indices;
  const fvv_status status = walk_all(&w, declared);
  if (status != FVV_OK && symbols) {
    fvv_release(allocator, symbols->values, (size_t)symbols->count + 1);
    memset(symbols, 0, sizeof *symbols);
  }
  return status;
}
