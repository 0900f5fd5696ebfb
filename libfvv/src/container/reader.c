/* container/reader.c: push bytes, pull events. Finds chunks, checks their CRCs, skips damage (clause 7.4);
 * which chunk may follow which is up to chunk_order.h. */
#include "container/reader.h"
#include "base/bytes.h"
#include "base/checked.h"
#include "base/diagnostic.h"
#include "container/chunk_order.h"

typedef enum reader_state {
  AT_FILE_HEADER,
  AT_CHUNK,
  PAYLOAD_BAD, /* the chunk at head has a good header and a bad payload */
  SCANNING,    /* for the next header; head moves on, lost_offset stays */
  STOPPED      /* a final error, or the end was reported */
} reader_state;

/* Good headers nested in bad payloads would make the CRCs quadratic in the bytes. Accidental damage wastes
 * each byte once. */
enum { WASTE_RATIO = 4 };
static const uint64_t WASTE_ALLOWED = UINT64_C(64) << 20;

struct fvv_reader {
  fvv_allocator allocator;
  fvv_chunk_order order;
  fvv_bytes buffer;
  size_t head;     /* first byte not yet consumed */
  size_t consumed; /* bytes of the last event that was returned: dropped at the next call */
  uint64_t offset; /* of head in the stream */
  uint64_t start;  /* offset of the first byte pushed */
  uint64_t wasted; /* payload bytes whose CRC was computed in vain */
  reader_state state;
  int finished, held, end_due;
  fvv_event loss;      /* SCANNING: the DAMAGE event to be reported when scanning ends */
  fvv_event chunk;     /* held: the CHUNK event after a DAMAGE event about it */
  fvv_diagnostic stop; /* STOPPED: the final error; status 0 after a regular end */
};

fvv_status fvv_reader_create(const fvv_limits *limits, const fvv_allocator *allocator, uint64_t start_offset,
                             fvv_reader **reader) {
  const fvv_allocator chosen = fvv_allocator_or_default(allocator);
  *reader = fvv_allocate_zeroed(&chosen, sizeof **reader);
  if (!*reader) return FVV_ERROR_MEMORY;
  fvv_reader *r = *reader;
  r->allocator = r->buffer.allocator = chosen;
  fvv_chunk_order_init(&r->order, limits, &chosen);
  r->offset = r->start = start_offset;
  if (start_offset) {
    r->state = AT_CHUNK;
    r->order.configuration = FVV_CONFIGURATION_UNSEEN;
    r->order.gaps = r->order.suspect = r->order.hole = 1;
  }
  return FVV_OK;
}

fvv_status fvv_reader_join(fvv_reader *reader) {
  if (reader->start || reader->offset || reader->buffer.size) return FVV_ERROR_STATE;
  reader->order.joined = reader->order.joining = 1;
  return FVV_OK;
}

void fvv_reader_inherit(fvv_reader *reader, fvv_reader *former) {
  fvv_chunk_order_inherit(&reader->order, &former->order);
}

int fvv_reader_lists_group(const fvv_reader *reader) {
  return reader->order.listed;
}

void fvv_reader_destroy(fvv_reader *reader) {
  if (!reader) return;
  const fvv_allocator allocator = reader->allocator;
  fvv_chunk_order_free(&reader->order);
  fvv_bytes_free(&reader->buffer);
  fvv_release(&allocator, reader, sizeof *reader);
}

static void consume(fvv_reader *r, uint64_t size) {
  r->head += (size_t)size;
  r->offset += size;
}

static void compact(fvv_reader *r) {
  if (r->head) memmove(r->buffer.data, r->buffer.data + r->head, r->buffer.size - r->head);
  r->buffer.size -= r->head;
  r->head = 0;
}

fvv_status fvv_reader_push(fvv_reader *reader, const void *bytes, size_t size) {
  if (reader->finished) return FVV_ERROR_STATE;
  consume(reader, reader->consumed);
  reader->consumed = 0;
  /* Moving when half is used up keeps the cost of pushing linear. */
  if (reader->head > reader->buffer.size / 2) compact(reader);
  return fvv_bytes_append(&reader->buffer, bytes, size);
}

void fvv_reader_finish(fvv_reader *reader) {
  reader->finished = 1;
}

static size_t available(const fvv_reader *r) {
  return r->buffer.size - r->head;
}
static const uint8_t *here(const fvv_reader *r) {
  return r->buffer.data + r->head;
}

/* Ends reading: every later call returns the same result. */
static fvv_status stop(fvv_reader *r, fvv_status status, uint32_t issue, uint64_t offset, const char *what) {
  r->state = STOPPED;
  if (r->stop.status >= 0) fvv_fail(&r->stop, status, issue, 0, offset, "%s", what);
  return r->stop.status;
}

static void damage_event(fvv_reader *r, fvv_event *event) {
  memset(event, 0, sizeof *event);
  event->kind = FVV_EVENT_DAMAGE;
  event->offset = r->offset;
}

/* Bytes are lost until a header is found. skip: bytes to skip at once. */
static void begin_scan(fvv_reader *r, const fvv_event *loss, size_t skip) {
  r->loss = *loss;
  r->loss.skipped = skip;
  consume(r, skip);
  r->state = SCANNING;
}

static fvv_status read_file_header(fvv_reader *r, fvv_event *event) {
  if (available(r) < FVV_FILE_HEADER_SIZE) {
    if (!r->finished) return FVV_NEED_DATA;
    return stop(r, FVV_ERROR_TRUNCATED, FVV_ISSUE_FILE_HEADER_TRUNCATED, available(r),
                available(r) ? "the stream ends inside its file header" : "the stream is empty");
  }
  damage_event(r, event);
  const fvv_status status = fvv_file_header_check(here(r), &event->diagnostic);
  event->diagnostic.chunk_offset = 0;
  if (event->diagnostic.issue == FVV_ISSUE_SIGNATURE || status == FVV_ERROR_UNSUPPORTED) {
    r->stop = event->diagnostic;
    return stop(r, status, 0, 0, "");
  }
  if (status == FVV_OK) {
    event->kind = FVV_EVENT_HEADER;
    event->written_major = fvv_get_u16(here(r) + FVV_FILE_HEADER_WRITTEN_MAJOR);
    event->written_minor = fvv_get_u16(here(r) + FVV_FILE_HEADER_WRITTEN_MINOR);
  }
  if (status == FVV_ERROR_DAMAGED) event->skipped = FVV_FILE_HEADER_SIZE;
  r->state = AT_CHUNK;
  consume(r, FVV_FILE_HEADER_SIZE);
  return FVV_OK;
}

/* The chunk at head, moved down to a multiple of 8: after odd gaps payloads are unaligned in the stream,
 * but not for the caller. What is overwritten was consumed before or is the chunk itself. */
static const uint8_t *aligned(fvv_reader *r, uint64_t extent) {
  uint8_t *chunk = r->buffer.data + r->head;
  const size_t shift = r->head & 7;
  return shift ? memmove(chunk - shift, chunk, (size_t)extent) : chunk;
}

/* The chunk at head is whole and its payload good. */
static fvv_status take_chunk(fvv_reader *r, const fvv_chunk_header *header, fvv_event *event) {
  const uint64_t extent = fvv_chunk_extent(header->size);
  const uint8_t *payload = aligned(r, extent) + FVV_CHUNK_HEADER_SIZE;
  fvv_diagnostic diagnostic = {0};
  fvv_status status = fvv_chunk_order_check(&r->order, header, payload, r->offset, &diagnostic);
  if (status == FVV_OK &&
      !fvv_all_zero(payload + header->size, (size_t)(fvv_padded(header->size) - header->size)))
    status = fvv_fail(&diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_PADDING, header->type,
                      r->offset + FVV_CHUNK_HEADER_SIZE + header->size, "padding is not 0");
  diagnostic.chunk_offset = r->offset;
  if (diagnostic.issue == FVV_ISSUE_GROUP_UNFINISHED) {
    /* The open group is broken, not this chunk, which is checked again: where it came from. */
    memmove(r->buffer.data + r->head, payload - FVV_CHUNK_HEADER_SIZE, (size_t)extent);
    fvv_chunk_order_abandon_group(&r->order);
    damage_event(r, event);
    event->diagnostic = diagnostic;
    return FVV_OK;
  }
  const int broken = status == FVV_ERROR_INVALID, missing = status == FVV_ERROR_DAMAGED;
  if (status < 0 && !broken && !missing) {
    r->stop = diagnostic;
    return stop(r, status, 0, r->offset, fvv_status_text(status));
  }
  status = fvv_chunk_order_apply(&r->order, header, payload, r->offset);
  if (status < 0)
    return stop(r, status, status == FVV_ERROR_LIMIT ? FVV_ISSUE_LIMIT : 0, r->offset,
                fvv_status_text(status));
  if (broken) fvv_chunk_order_broken(&r->order, header);
  if (missing) fvv_chunk_order_missing(&r->order);
  memset(&r->chunk, 0, sizeof r->chunk);
  r->chunk.kind = FVV_EVENT_CHUNK;
  r->chunk.offset = r->offset;
  r->chunk.chunk = *header;
  r->chunk.payload = payload;
  r->chunk.group_intact = fvv_chunk_order_group_intact(&r->order);
  r->consumed = (size_t)extent;
  if (broken || missing) {
    damage_event(r, event);
    event->diagnostic = diagnostic;
    r->held = 1;
    r->consumed = 0;
  } else {
    *event = r->chunk;
    r->end_due = header->type == FVV_CHUNK_FOOTER;
  }
  return FVV_OK;
}

static fvv_status read_chunk(fvv_reader *r, fvv_event *event) {
  fvv_event loss;
  damage_event(r, &loss);
  fvv_chunk_header header;
  if (available(r) < FVV_CHUNK_HEADER_SIZE || !fvv_header_read(&header, here(r))) {
    if (available(r) < FVV_CHUNK_HEADER_SIZE && !r->finished) return FVV_NEED_DATA;
    const int cut = available(r) < FVV_CHUNK_HEADER_SIZE;
    const int trailing = r->order.footer_seen;
    fvv_fail(&loss.diagnostic, cut && !trailing ? FVV_ERROR_TRUNCATED : FVV_ERROR_DAMAGED,
             trailing ? FVV_ISSUE_TRAILING
             : cut    ? FVV_ISSUE_CHUNK_TRUNCATED
                      : FVV_ISSUE_CHUNK_HEADER,
             0, r->offset, "%s",
             trailing ? "bytes follow the footer"
             : cut    ? "the stream ends inside a chunk header"
                      : "no chunk header where one is expected");
    fvv_chunk_order_lost(&r->order);
    begin_scan(r, &loss, cut ? available(r) : 1);
    return FVV_OK;
  }
  if (header.size >> 63) {
    /* Where the next chunk would begin has no offset in 64 bits. */
    const fvv_status status = fvv_header_check(&header, r->offset, &r->stop);
    r->stop.chunk_offset = r->offset;
    return stop(r, status, 0, 0, "");
  }
  const uint64_t most = fvv_payload_limit(&r->order.limits, header.type);
  if (header.size > most) {
    fvv_fail(&r->stop, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, header.type, r->offset,
             "payload of %llu bytes, limit %llu", (unsigned long long)header.size, (unsigned long long)most);
    return stop(r, FVV_ERROR_LIMIT, 0, 0, "");
  }
  loss.has_chunk = 1;
  loss.chunk = header;
  const uint64_t extent = fvv_chunk_extent(header.size);
  if (available(r) < extent) {
    if (!r->finished) return FVV_NEED_DATA;
    fvv_fail(&loss.diagnostic, FVV_ERROR_TRUNCATED, FVV_ISSUE_CHUNK_TRUNCATED, header.type, r->offset,
             "the stream ends inside a chunk: %zu of %llu bytes", available(r), (unsigned long long)extent);
    fvv_chunk_order_lost(&r->order);
    begin_scan(r, &loss, FVV_CHUNK_HEADER_SIZE);
    return FVV_OK;
  }
  if (fvv_crc32c(0, here(r) + FVV_CHUNK_HEADER_SIZE, (size_t)header.size) == header.payload_crc)
    return take_chunk(r, &header, event);
  fvv_fail(&loss.diagnostic, FVV_ERROR_DAMAGED, FVV_ISSUE_PAYLOAD_CRC, header.type, r->offset,
           "CRC of the payload does not match");
  r->wasted += header.size;
  if (r->wasted > WASTE_ALLOWED + WASTE_RATIO * (r->offset - r->start))
    return stop(r, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, r->offset,
                "too much damage: headers nested in damaged payloads");
  r->loss = loss;
  r->state = PAYLOAD_BAD;
  return FVV_OK;
}

/* If bytes of the payload changed, a header follows at the expected place; else bytes were removed or
 * inserted. */
static fvv_status pass_bad_payload(fvv_reader *r, fvv_event *event) {
  const uint64_t extent = fvv_chunk_extent(r->loss.chunk.size);
  const int enough = available(r) >= extent + FVV_CHUNK_HEADER_SIZE;
  if (!enough && !r->finished) return FVV_NEED_DATA;
  fvv_chunk_header next;
  if (!enough || !fvv_header_read(&next, here(r) + extent)) {
    fvv_chunk_order_lost(&r->order);
    begin_scan(r, &r->loss, FVV_CHUNK_HEADER_SIZE);
    return FVV_OK;
  }
  const fvv_status status = fvv_chunk_order_damaged(&r->order, &r->loss.chunk, r->offset);
  if (status < 0) return stop(r, status, 0, r->offset, fvv_status_text(status));
  consume(r, extent);
  *event = r->loss;
  event->skipped = extent;
  r->state = AT_CHUNK;
  return FVV_OK;
}

static fvv_status scan(fvv_reader *r, fvv_event *event) {
  fvv_chunk_header header;
  size_t passed = 0;
  int found = 0;
  const size_t bytes = available(r);
  while (!found && bytes - passed >= FVV_CHUNK_HEADER_SIZE) {
    found = fvv_header_read(&header, here(r) + passed) &&
            fvv_header_plausible(&header, fvv_payload_limit(&r->order.limits, header.type));
    passed += !found;
  }
  if (!found && r->finished) passed = bytes;
  consume(r, passed);
  r->loss.skipped += passed;
  if (!found && !r->finished) return FVV_NEED_DATA;
  *event = r->loss;
  r->state = AT_CHUNK;
  return FVV_OK;
}

/* A group that is open is reported once, unless a cut chunk was. */
static fvv_status end_of_stream(fvv_reader *r, fvv_event *event) {
  r->state = STOPPED;
  if (!r->order.in_group || r->order.suspect) return FVV_END;
  damage_event(r, event);
  fvv_fail(&event->diagnostic, FVV_ERROR_TRUNCATED, FVV_ISSUE_GROUP_UNFINISHED, 0, r->offset,
           "the stream ends inside group %u", r->order.table.sequence);
  return FVV_OK;
}

fvv_status fvv_reader_next(fvv_reader *reader, fvv_event *event, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  memset(event, 0, sizeof *event);
  if (reader->held) {
    reader->held = 0;
    *event = reader->chunk;
    reader->consumed = (size_t)fvv_chunk_extent(reader->chunk.chunk.size);
    return FVV_OK;
  }
  consume(reader, reader->consumed);
  reader->consumed = 0;
  if (reader->end_due) {
    reader->end_due = 0;
    event->kind = FVV_EVENT_END;
    event->offset = reader->offset;
  }
  while (!event->kind) {
    fvv_status status = FVV_OK;
    switch (reader->state) {
    case AT_FILE_HEADER:
      status = read_file_header(reader, event);
      break;
    case AT_CHUNK:
      if (reader->finished && !available(reader))
        status = end_of_stream(reader, event);
      else
        status = read_chunk(reader, event);
      break;
    case PAYLOAD_BAD:
      status = pass_bad_payload(reader, event);
      break;
    case SCANNING:
      status = scan(reader, event);
      break;
    case STOPPED:
      if (diagnostic) *diagnostic = reader->stop;
      return reader->stop.status < 0 ? reader->stop.status : FVV_END;
    }
    if (status == FVV_NEED_DATA) return status;
    if (status < 0 && diagnostic) *diagnostic = reader->stop;
    if (status != FVV_OK) return status;
  }
  return FVV_OK;
}
