/* COLR payloads: the cells that a mesh occupies, the coder of their colours, and the way from cells to
 * vertices (clause 19). */
#include "fvv/colours.h"

#include <string.h>

#include "base/bytes.h"
#include "base/checked.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "base/range_coder.h"

enum {
  AXIS_BITS = 10, /* of a cell's coordinate in its key; 0 and the last value are never occupied */
  AROUND = 27,    /* cells around a cell, itself in the middle */
  CHANNELS = 3,   /* Y, Co, Cg */
  CLASSES = 5,    /* of the magnitudes of residuals around */
  MOST = 511,     /* magnitude of a coded value */
  DIGITS = 10     /* "more" decisions with a context of their own, and the most that a residual has */
};
static const uint32_t no_cell = UINT32_MAX;

/* The cells that contain a vertex, in order of their keys. */
typedef struct cell_grid {
  fvv_allocator allocator;
  uint32_t vertex_count, count;
  int32_t size;
  uint32_t *of;               /* for each vertex: its cell */
  uint32_t *keys;             /* for each cell: z, y and x within the mesh, x in the lowest bits */
  uint32_t (*around)[AROUND]; /* for each cell the cells around it, no_cell: none; x varies fastest */
} cell_grid;

static fvv_status no_memory(fvv_diagnostic *diagnostic) {
  return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory for colours");
}

static void close_grid(cell_grid *g) {
  fvv_release(&g->allocator, g->of, (size_t)g->vertex_count * sizeof *g->of);
  fvv_release(&g->allocator, g->keys, (size_t)g->count * sizeof *g->keys);
  fvv_release(&g->allocator, g->around, (size_t)g->count * sizeof *g->around);
}

static int32_t divide_down(int32_t value, int32_t by) {
  return value / by - (value % by < 0);
}

/* Sorts by one digit of AXIS_BITS. */
static void sort_by(const uint32_t *from, uint32_t *to, size_t count, int shift) {
  uint32_t places[1 << AXIS_BITS] = {0};
  const uint32_t mask = (1 << AXIS_BITS) - 1;
  for (size_t i = 0; i < count; i++) places[from[i] >> shift & mask]++;
  uint32_t next = 0;
  for (size_t digit = 0; digit <= mask; digit++) {
    const uint32_t here = places[digit];
    places[digit] = next;
    next += here;
  }
  for (size_t i = 0; i < count; i++) to[places[from[i] >> shift & mask]++] = from[i];
}

/* Key of the cell of each vertex. Returns 0 where the mesh extends over too many cells. */
static int find_keys(cell_grid *g, const int32_t *lattice) {
  int32_t least[3], most[3];
  for (size_t i = 0; i < g->vertex_count; i++)
    for (size_t axis = 0; axis < 3; axis++) {
      const int32_t p = lattice[3 * i + axis];
      if (!i || p < least[axis]) least[axis] = p;
      if (!i || p > most[axis]) most[axis] = p;
    }
  for (size_t axis = 0; axis < 3; axis++) {
    least[axis] = divide_down(least[axis], g->size);
    if (divide_down(most[axis], g->size) - least[axis] >= FVV_COLOURS_MAX_EXTENT) return 0;
  }
  for (size_t i = 0; i < g->vertex_count; i++) {
    uint32_t key = 0;
    for (size_t axis = 3; axis-- > 0;)
      key = key << AXIS_BITS | (uint32_t)(divide_down(lattice[3 * i + axis], g->size) - least[axis] + 1);
    g->of[i] = key;
  }
  return 1;
}

/* Distinct keys, rising; scratch: room for two of each vertex. Returns how many. */
static uint32_t *distinct_keys(const cell_grid *g, uint32_t *scratch, uint32_t *count) {
  uint32_t *a = scratch, *b = scratch + g->vertex_count;
  size_t n = 0;
  /* Neighbours mostly share their cell. */
  for (size_t i = 0; i < g->vertex_count; i++)
    if (!n || a[n - 1] != g->of[i]) a[n++] = g->of[i];
  for (int digit = 0; digit < 3; digit++) {
    sort_by(a, b, n, digit * AXIS_BITS);
    uint32_t *const swapped = a;
    a = b;
    b = swapped;
  }
  *count = 0;
  for (size_t i = 0; i < n; i++)
    if (!*count || a[*count - 1] != a[i]) a[(*count)++] = a[i];
  return a;
}

/* Keys grow with cells: a walk for each direction finds all neighbours. */
static void find_around(cell_grid *g) {
  for (uint32_t k = 0; k < AROUND; k++) {
    const int32_t x = (int32_t)(k % 3) - 1, y = (int32_t)(k / 3 % 3) - 1, z = (int32_t)(k / 9) - 1;
    const int32_t away = (z * (1 << AXIS_BITS) + y) * (1 << AXIS_BITS) + x;
    uint32_t at = 0;
    for (uint32_t i = 0; i < g->count; i++) {
      const uint32_t wanted = (uint32_t)((int32_t)g->keys[i] + away);
      while (at < g->count && g->keys[at] < wanted) at++;
      g->around[i][k] = at < g->count && g->keys[at] == wanted ? at : no_cell;
    }
  }
}

/* From keys to cells. */
static void find_cells(cell_grid *g) {
  uint32_t key = 0, cell = no_cell;
  for (size_t i = 0; i < g->vertex_count; i++) {
    if (cell == no_cell || g->of[i] != key) {
      key = g->of[i];
      uint32_t end = g->count;
      for (cell = 0; end - cell > 1;) {
        const uint32_t middle = cell + (end - cell) / 2;
        if (g->keys[middle] <= key)
          cell = middle;
        else
          end = middle;
      }
    }
    g->of[i] = cell;
  }
}

/* failure: the status where the mesh has no such cells. wanted: how many are declared, 0: any. */
static fvv_status open_grid(cell_grid *g, const fvv_mesh *mesh, uint32_t size, uint32_t wanted,
                            const fvv_allocator *allocator, fvv_status failure, fvv_diagnostic *diagnostic) {
  memset(g, 0, sizeof *g);
  g->allocator = fvv_allocator_or_default(allocator);
  g->vertex_count = mesh->vertex_count;
  g->size = (int32_t)size;
  const size_t scratch_count = 2 * (size_t)mesh->vertex_count;
  g->of = fvv_allocate_array(&g->allocator, mesh->vertex_count, sizeof *g->of);
  if (!g->of) return no_memory(diagnostic);
  if (!find_keys(g, mesh->lattice))
    return fvv_fail(diagnostic, failure, FVV_ISSUE_COLOURS_CELLS, FVV_CHUNK_COLOURS, FVV_COLR_CELL_SIZE,
                    "the mesh extends over more than %d cells of %lu lattice steps", FVV_COLOURS_MAX_EXTENT,
                    (unsigned long)size);
  uint32_t *scratch = fvv_allocate_array(&g->allocator, scratch_count, sizeof *scratch);
  if (!scratch) return no_memory(diagnostic);
  uint32_t count;
  const uint32_t *keys = distinct_keys(g, scratch, &count);
  fvv_status status = FVV_OK;
  if (count > FVV_COLOURS_MAX_CELLS || (wanted && count != wanted)) {
    status = fvv_fail(diagnostic, failure, FVV_ISSUE_COLOURS_CELLS, FVV_CHUNK_COLOURS, FVV_COLR_CELL_COUNT,
                      "the mesh occupies %lu cells, expected %lu%s", (unsigned long)count,
                      (unsigned long)(wanted ? wanted : FVV_COLOURS_MAX_CELLS), wanted ? "" : " at most");
  } else {
    g->keys = fvv_allocate_array(&g->allocator, count, sizeof *g->keys);
    g->around = fvv_allocate_array(&g->allocator, count, sizeof *g->around);
    g->count = count;
    if (g->keys && g->around) {
      memcpy(g->keys, keys, (size_t)count * sizeof *keys);
      find_around(g);
      find_cells(g);
    } else {
      status = no_memory(diagnostic);
    }
  }
  fvv_release(&g->allocator, scratch, scratch_count * sizeof *scratch);
  return status;
}

/* ---- from cells to vertices, clause 19.4 -------------------------------------------------------------- */

/* The cells from which a vertex has its colour, and their weights. */
typedef struct cell_mix {
  uint32_t count, sum;
  uint32_t cell[8], weight[8];
} cell_mix;

static void mix_of(const cell_grid *g, const int32_t *lattice, uint32_t vertex, cell_mix *mix) {
  uint32_t own[3], other[3];
  int32_t step[3];
  for (size_t axis = 0; axis < 3; axis++) {
    const int32_t p = lattice[3 * (size_t)vertex + axis];
    const uint32_t inside = (uint32_t)(p - divide_down(p, g->size) * g->size);
    const int32_t h = (int32_t)((64 * inside + 32 * (uint32_t)g->size) / (2 * (uint32_t)g->size));
    step[axis] = h >= 32 ? 1 : -1;
    other[axis] = (uint32_t)(h >= 32 ? h - 32 : 32 - h);
    own[axis] = 32 - other[axis];
  }
  mix->count = mix->sum = 0;
  for (uint32_t k = 0; k < 8; k++) {
    int32_t at = 13;
    uint32_t weight = 1;
    for (uint32_t axis = 0, stride = 1; axis < 3; axis++, stride *= 3) {
      const int away = k >> axis & 1;
      weight *= away ? other[axis] : own[axis];
      if (away) at += step[axis] * (int32_t)stride;
    }
    const uint32_t cell = g->around[g->of[vertex]][at];
    if (cell == no_cell || !weight) continue;
    mix->cell[mix->count] = cell;
    mix->weight[mix->count++] = weight;
    mix->sum += weight;
  }
}

static int32_t clamp(int32_t value, int32_t least, int32_t most) {
  return value < least ? least : value > most ? most : value;
}

/* R, G, B of coded values. */
static void to_rgb(const int16_t value[CHANNELS], const fvv_colours_header *header, uint8_t rgb[3]) {
  const int32_t y = clamp(value[0] * header->luma_step, 0, 255);
  const int32_t co = clamp(value[1] * header->chroma_step, -255, 255);
  const int32_t cg = clamp(value[2] * header->chroma_step, -255, 255);
  const int32_t t = y - divide_down(cg, 2), blue = t - divide_down(co, 2);
  rgb[0] = (uint8_t)clamp(blue + co, 0, 255);
  rgb[1] = (uint8_t)clamp(cg + t, 0, 255);
  rgb[2] = (uint8_t)clamp(blue, 0, 255);
}

/* cells: R, G, B of each. */
static void interpolate(const cell_grid *g, const fvv_mesh *mesh, const uint8_t *cells, uint8_t *colours) {
  cell_mix mix;
  for (uint32_t v = 0; v < mesh->vertex_count; v++) {
    mix_of(g, mesh->lattice, v, &mix);
    for (size_t c = 0; c < 3; c++) {
      uint32_t sum = mix.sum / 2;
      for (uint32_t i = 0; i < mix.count; i++) sum += mix.weight[i] * cells[3 * (size_t)mix.cell[i] + c];
      colours[3 * (size_t)v + c] = (uint8_t)(sum / mix.sum);
    }
  }
}

/* ---- values of cells, clause 19.3 --------------------------------------------------------------------- */

typedef struct colour_model {
  fvv_probability some[CHANNELS][CLASSES]
                      [CHANNELS];           /* class around, residuals of other channels that are not 0 */
  fvv_probability more[2][CLASSES][DIGITS]; /* luma or chroma */
} colour_model;

typedef struct coded_cells {
  int16_t (*value)[CHANNELS];
  uint16_t (*magnitude)[CHANNELS]; /* of residuals */
} coded_cells;

static void reset(colour_model *model) {
  fvv_probability *p = (fvv_probability *)model;
  for (size_t i = 0; i < sizeof *model / sizeof *p; i++) fvv_probability_reset(&p[i]);
}

/* What the coded cells around say of a cell's value on a channel. */
typedef struct expected {
  int32_t value;
  uint32_t class;
} expected;

static expected expect(const cell_grid *g, const coded_cells *cells, uint32_t cell, uint32_t channel,
                       int32_t first) {
  /* By how many axes a cell lies away: 1, 2, 3. */
  static const int32_t weights[4] = {0, 4, 2, 1};
  int32_t sum = 0, all = 0, magnitudes = 0;
  for (uint32_t k = 0; k < AROUND / 2; k++) {
    const uint32_t other = g->around[cell][k];
    if (other == no_cell) continue;
    const int32_t w = weights[(k % 3 != 1) + (k / 3 % 3 != 1) + (k / 9 != 1)];
    all += w;
    sum += w * cells->value[other][channel];
    magnitudes += w * (int32_t)cells->magnitude[other][channel];
  }
  if (!all && !cell) return (expected){first, CLASSES - 1};
  if (!all) return (expected){cells->value[cell - 1][channel], CLASSES - 1};
  const int32_t mean = 2 * magnitudes / all; /* in halves */
  const uint32_t class = mean < 1 ? 0 : mean < 2 ? 1 : mean < 4 ? 2 : mean < 8 ? 3 : 4;
  return (expected){divide_down(2 * sum + all, 2 * all), class};
}

static int32_t first_value(uint32_t channel, const fvv_colours_header *header) {
  return channel ? 0 : 128 / header->luma_step;
}

/* Returns 0 where a value is out of range. */
static int decode_cells(const cell_grid *g, const fvv_colours_header *header, const uint8_t *data,
                        size_t size, coded_cells *cells) {
  colour_model model;
  reset(&model);
  fvv_range_decoder d;
  fvv_range_decoder_init(&d, data, size);
  for (uint32_t i = 0; i < g->count && !fvv_range_decoder_failed(&d); i++) {
    uint32_t others = 0;
    for (uint32_t c = 0; c < CHANNELS; c++) {
      const expected e = expect(g, cells, i, c, first_value(c, header));
      int32_t residual = 0;
      if (fvv_range_decode(&d, &model.some[c][e.class][others])) {
        others++;
        uint32_t digits = 0;
        while (digits < DIGITS && fvv_range_decode(&d, &model.more[c != 0][e.class][digits])) digits++;
        residual = 1;
        for (uint32_t k = 0; k < digits; k++) residual = 2 * residual + fvv_range_decode_even(&d);
        cells->magnitude[i][c] = (uint16_t)residual;
        if (fvv_range_decode_even(&d)) residual = -residual;
      } else {
        cells->magnitude[i][c] = 0;
      }
      const int32_t value = e.value + residual;
      if (value < -MOST || value > MOST) return 0;
      cells->value[i][c] = (int16_t)value;
    }
  }
  return fvv_range_decoder_finished(&d);
}

static fvv_status encode_cells(const cell_grid *g, const fvv_colours_header *header, coded_cells *cells,
                               fvv_bytes *payload) {
  colour_model model;
  reset(&model);
  fvv_range_encoder encoder;
  fvv_range_encoder_init(&encoder, payload);
  for (uint32_t i = 0; i < g->count; i++) {
    uint32_t others = 0;
    for (uint32_t c = 0; c < CHANNELS; c++) {
      const expected e = expect(g, cells, i, c, first_value(c, header));
      const int32_t residual = cells->value[i][c] - e.value;
      const uint32_t magnitude = (uint32_t)(residual < 0 ? -residual : residual);
      cells->magnitude[i][c] = (uint16_t)magnitude;
      fvv_range_encode(&encoder, &model.some[c][e.class][others], magnitude != 0);
      if (!magnitude) continue;
      others++;
      uint32_t digits = 0;
      while (magnitude >> (digits + 1)) digits++;
      for (uint32_t k = 0; k < digits; k++) fvv_range_encode(&encoder, &model.more[c != 0][e.class][k], 1);
      if (digits < DIGITS) fvv_range_encode(&encoder, &model.more[c != 0][e.class][digits], 0);
      for (uint32_t k = digits; k-- > 0;) fvv_range_encode_even(&encoder, magnitude >> k & 1);
      fvv_range_encode_even(&encoder, residual < 0);
    }
  }
  return fvv_range_encoder_finish(&encoder);
}

static void close_cells(const cell_grid *g, coded_cells *cells) {
  fvv_release(&g->allocator, cells->value, g->count * sizeof *cells->value);
  fvv_release(&g->allocator, cells->magnitude, g->count * sizeof *cells->magnitude);
}

static int open_cells(const cell_grid *g, coded_cells *cells) {
  cells->value = fvv_allocate_array(&g->allocator, g->count, sizeof *cells->value);
  cells->magnitude = fvv_allocate_array(&g->allocator, g->count, sizeof *cells->magnitude);
  return cells->value && cells->magnitude;
}

/* ---- payloads ----------------------------------------------------------------------------------------- */

fvv_status fvv_colours_peek(const uint8_t *payload, size_t size, const fvv_limits *limits,
                            fvv_colours_header *header, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *header = (fvv_colours_header){0};
  if (size < FVV_COLR_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_COLOURS_PAYLOAD, FVV_CHUNK_COLOURS, size,
                    "payload has %zu bytes, expected at least %d", size, FVV_COLR_SIZE);
  const fvv_colours_header found = {fvv_get_u16(payload + FVV_COLR_MESH_TRACK),
                                    payload[FVV_COLR_LUMA_STEP],
                                    payload[FVV_COLR_CHROMA_STEP],
                                    fvv_get_u32(payload + FVV_COLR_VERTEX_COUNT),
                                    fvv_get_u32(payload + FVV_COLR_CELL_SIZE),
                                    fvv_get_u32(payload + FVV_COLR_CELL_COUNT)};
  if (!found.luma_step || found.luma_step > FVV_COLOURS_MAX_STEP || !found.chroma_step ||
      found.chroma_step > FVV_COLOURS_MAX_STEP)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_COLOURS_PAYLOAD, FVV_CHUNK_COLOURS,
                    FVV_COLR_LUMA_STEP, "steps are %u and %u, expected 1 to %d", found.luma_step,
                    found.chroma_step, FVV_COLOURS_MAX_STEP);
  if (!found.cell_size || found.cell_size > FVV_COLOURS_MAX_CELL)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_COLOURS_PAYLOAD, FVV_CHUNK_COLOURS,
                    FVV_COLR_CELL_SIZE, "cells have a side of %lu lattice steps, expected 1 to %d",
                    (unsigned long)found.cell_size, FVV_COLOURS_MAX_CELL);
  if (!found.cell_count || found.cell_count > FVV_COLOURS_MAX_CELLS)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_COLOURS_CELLS, FVV_CHUNK_COLOURS,
                    FVV_COLR_CELL_COUNT, "%lu cells, expected 1 to %d", (unsigned long)found.cell_count,
                    FVV_COLOURS_MAX_CELLS);
  const fvv_limits chosen = fvv_limits_or_default(limits);
  if (found.vertex_count > chosen.max_vertices)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_COLOURS, FVV_COLR_VERTEX_COUNT,
                    "%lu vertices, limit %lu", (unsigned long)found.vertex_count,
                    (unsigned long)chosen.max_vertices);
  *header = found;
  return FVV_OK;
}

static fvv_status decode_grid(const cell_grid *g, const fvv_colours_header *header, const uint8_t *payload,
                              size_t size, const fvv_mesh *mesh, uint8_t *colours,
                              fvv_diagnostic *diagnostic) {
  coded_cells cells;
  uint8_t *rgb = fvv_allocate_array(&g->allocator, g->count, 3);
  fvv_status status = FVV_OK;
  if (!open_cells(g, &cells) || !rgb) {
    status = no_memory(diagnostic);
  } else if (!decode_cells(g, header, payload + FVV_COLR_SIZE, size - FVV_COLR_SIZE, &cells)) {
    status = fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_COLOURS_STREAM, FVV_CHUNK_COLOURS,
                      FVV_COLR_SIZE, "stream has %zu bytes, its last cell ends elsewhere or is out of range",
                      size - FVV_COLR_SIZE);
  } else {
    for (uint32_t i = 0; i < g->count; i++) to_rgb(cells.value[i], header, rgb + 3 * (size_t)i);
    interpolate(g, mesh, rgb, colours);
  }
  close_cells(g, &cells);
  fvv_release(&g->allocator, rgb, (size_t)g->count * 3);
  return status;
}

fvv_status fvv_colours_decode(const uint8_t *payload, size_t size, const fvv_mesh *mesh,
                              const fvv_limits *limits, const fvv_allocator *allocator, uint8_t *colours,
                              fvv_diagnostic *diagnostic) {
  fvv_colours_header header;
  fvv_status status = fvv_colours_peek(payload, size, limits, &header, diagnostic);
  if (status != FVV_OK) return status;
  if (header.vertex_count != mesh->vertex_count || !mesh->vertex_count)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_COLOURS_MESH, FVV_CHUNK_COLOURS,
                    FVV_COLR_VERTEX_COUNT, "colours of %lu vertices, the mesh at their time has %lu",
                    (unsigned long)header.vertex_count, (unsigned long)mesh->vertex_count);
  cell_grid grid;
  status =
      open_grid(&grid, mesh, header.cell_size, header.cell_count, allocator, FVV_ERROR_INVALID, diagnostic);
  if (status == FVV_OK) status = decode_grid(&grid, &header, payload, size, mesh, colours, diagnostic);
  close_grid(&grid);
  return status;
}

/* Cells for which the interpolated colours of vertices err least: weighted means, corrected by what is left
 * of the vertices' colours as long as that pays. mean, sum: room for three of each cell. */
enum { CORRECTIONS = 2 };

static void fit_cells(const cell_grid *g, const fvv_mesh *mesh, const uint8_t *colours,
                      const uint8_t *weights, double (*mean)[4], double (*cell)[3]) {
  cell_mix mix;
  memset(cell, 0, g->count * sizeof *cell);
  for (int round = 0; round <= CORRECTIONS; round++) {
    memset(mean, 0, g->count * sizeof *mean);
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
      /* What is given no weight counts where there is nothing else. */
      const double weight = weights ? weights[v] + 1e-3 : 1;
      mix_of(g, mesh->lattice, v, &mix);
      double left[3];
      for (size_t c = 0; c < 3; c++) {
        left[c] = colours[3 * (size_t)v + c];
        for (uint32_t i = 0; i < mix.count; i++) left[c] -= cell[mix.cell[i]][c] * mix.weight[i] / mix.sum;
      }
      for (uint32_t i = 0; i < mix.count; i++) {
        double *sum = mean[mix.cell[i]];
        const double part = weight * mix.weight[i] / mix.sum;
        for (size_t c = 0; c < 3; c++) sum[c] += part * left[c];
        sum[3] += part;
      }
    }
    for (uint32_t i = 0; i < g->count; i++)
      for (size_t c = 0; c < 3; c++) cell[i][c] += mean[i][3] > 0 ? mean[i][c] / mean[i][3] : 0;
  }
}

static int16_t quantised(double value, int32_t step) {
  const double scaled = value / step;
  return (int16_t)clamp((int32_t)(scaled < 0 ? scaled - 0.5 : scaled + 0.5), -255, 255);
}

static fvv_status encode_grid(const cell_grid *g, const fvv_colours_header *header, const fvv_mesh *mesh,
                              const uint8_t *colours, const uint8_t *weights, fvv_bytes *payload) {
  double(*mean)[4] = fvv_allocate_array(&g->allocator, g->count, sizeof *mean);
  double(*cell)[3] = fvv_allocate_array(&g->allocator, g->count, sizeof *cell);
  coded_cells cells;
  fvv_status status = FVV_ERROR_MEMORY;
  if (open_cells(g, &cells) && mean && cell) {
    fit_cells(g, mesh, colours, weights, mean, cell);
    for (uint32_t i = 0; i < g->count; i++) {
      double rgb[3];
      for (size_t c = 0; c < 3; c++) rgb[c] = cell[i][c] < 0 ? 0 : cell[i][c] > 255 ? 255 : cell[i][c];
      cells.value[i][0] = quantised((rgb[0] + 2 * rgb[1] + rgb[2]) / 4, header->luma_step);
      cells.value[i][1] = quantised(rgb[0] - rgb[2], header->chroma_step);
      cells.value[i][2] = quantised(rgb[1] - (rgb[0] + rgb[2]) / 2, header->chroma_step);
    }
    uint8_t fixed[FVV_COLR_SIZE];
    fixed[FVV_COLR_LUMA_STEP] = header->luma_step;
    fixed[FVV_COLR_CHROMA_STEP] = header->chroma_step;
    fvv_put_u16(fixed + FVV_COLR_MESH_TRACK, header->mesh_track);
    fvv_put_u32(fixed + FVV_COLR_VERTEX_COUNT, mesh->vertex_count);
    fvv_put_u32(fixed + FVV_COLR_CELL_SIZE, header->cell_size);
    fvv_put_u32(fixed + FVV_COLR_CELL_COUNT, g->count);
    status = fvv_bytes_append(payload, fixed, sizeof fixed);
    if (status == FVV_OK) status = encode_cells(g, header, &cells, payload);
  }
  close_cells(g, &cells);
  fvv_release(&g->allocator, mean, g->count * sizeof *mean);
  fvv_release(&g->allocator, cell, g->count * sizeof *cell);
  return status;
}

fvv_status fvv_colours_encode(const fvv_mesh *mesh, const fvv_colours_header *header, const uint8_t *colours,
                              const uint8_t *weights, const fvv_allocator *allocator, fvv_bytes *payload,
                              fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (!payload->allocator.resize) payload->allocator = fvv_allocator_or_default(allocator);
  payload->size = 0;
  if (!header->luma_step || header->luma_step > FVV_COLOURS_MAX_STEP || !header->chroma_step ||
      header->chroma_step > FVV_COLOURS_MAX_STEP || !header->cell_size ||
      header->cell_size > FVV_COLOURS_MAX_CELL || !mesh->vertex_count)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, FVV_ISSUE_COLOURS_PAYLOAD, 0, 0,
                    "steps are %u and %u, cells have %lu lattice steps, and there are %lu vertices: expected "
                    "1 to %d, 1 to %d, and at least 1",
                    header->luma_step, header->chroma_step, (unsigned long)header->cell_size,
                    (unsigned long)mesh->vertex_count, FVV_COLOURS_MAX_STEP, FVV_COLOURS_MAX_CELL);
  const fvv_limits limits = fvv_limits_or_default(NULL);
  fvv_status status =
      fvv_readable_check(mesh->vertex_count, limits.max_vertices, "vertices", FVV_CHUNK_COLOURS, diagnostic);
  if (status != FVV_OK) return status;
  cell_grid grid;
  status = open_grid(&grid, mesh, header->cell_size, 0, allocator, FVV_ERROR_INPUT, diagnostic);
  if (status == FVV_OK && encode_grid(&grid, header, mesh, colours, weights, payload) != FVV_OK)
    status = no_memory(diagnostic);
  close_grid(&grid);
  return status;
}
