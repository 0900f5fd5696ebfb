/* container/writer.c: append-only. Every chunk passes the same rules that a reader applies (chunk_order.h),
 * so that what is written can be read. The writer never seeks back. */
#include "base/bytes.h"
#include "base/checked.h"
#include "base/diagnostic.h"
#include "container/chunk_order.h"

struct fvv_writer {
  fvv_allocator allocator;
  fvv_output output;
  fvv_chunk_order order;
  fvv_bytes block;  /* the current configuration block, to be repeated */
  uint32_t cameras; /* of the block */
  fvv_bytes scratch;
  uint64_t position;
  fvv_status failed; /* the output failed: what it holds is unknown, nothing may follow */
};

static fvv_status put(fvv_writer *w, const void *bytes, size_t size, fvv_diagnostic *diagnostic) {
  if (!size) return FVV_OK;
  if (w->output.write(w->output.user, bytes, size) != FVV_OK) {
    w->failed = FVV_ERROR_IO;
    return fvv_fail(diagnostic, FVV_ERROR_IO, 0, 0, w->position, "the output cannot be written");
  }
  w->position += size;
  return FVV_OK;
}

fvv_status fvv_writer_create(const fvv_output *output, const fvv_allocator *allocator, fvv_writer **writer,
                             fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_allocator chosen = fvv_allocator_or_default(allocator);
  *writer = fvv_allocate_zeroed(&chosen, sizeof **writer);
  if (!*writer) return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory");
  fvv_writer *w = *writer;
  w->allocator = w->block.allocator = w->scratch.allocator = chosen;
  w->output = *output;
  fvv_chunk_order_init(&w->order, NULL, &chosen);
  uint8_t header[FVV_FILE_HEADER_SIZE] = {0};
  memcpy(header, FVV_SIGNATURE, 8);
  fvv_put_u16(header + FVV_FILE_HEADER_WRITTEN_MAJOR, FVV_FORMAT_MAJOR);
  fvv_put_u16(header + FVV_FILE_HEADER_WRITTEN_MINOR, FVV_FORMAT_MINOR);
  fvv_put_u16(header + FVV_FILE_HEADER_READER_MAJOR, FVV_FORMAT_READER_MAJOR);
  fvv_put_u16(header + FVV_FILE_HEADER_READER_MINOR, FVV_FORMAT_READER_MINOR);
  fvv_put_u32(header + FVV_FILE_HEADER_CRC, fvv_crc32c(0, header, FVV_FILE_HEADER_CRC));
  const fvv_status status = put(w, header, sizeof header, diagnostic);
  if (status < 0) {
    fvv_writer_destroy(w);
    *writer = NULL;
  }
  return status;
}

void fvv_writer_destroy(fvv_writer *writer) {
  if (!writer) return;
  const fvv_allocator allocator = writer->allocator;
  fvv_chunk_order_free(&writer->order);
  fvv_bytes_free(&writer->block);
  fvv_bytes_free(&writer->scratch);
  fvv_release(&allocator, writer, sizeof *writer);
}

uint64_t fvv_writer_position(const fvv_writer *writer) {
  return writer->position;
}

static const uint8_t zeros[8] = {0};

static fvv_status put_chunk(fvv_writer *w, fvv_chunk_header *header, const void *payload,
                            fvv_diagnostic *diagnostic) {
  if (w->failed) return fvv_fail(diagnostic, FVV_ERROR_STATE, 0, 0, 0, "the output failed before");
  if (header->size > w->order.limits.max_payload)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, header->type, 0,
                    "payload has %llu bytes, readers accept %llu", (unsigned long long)header->size,
                    (unsigned long long)w->order.limits.max_payload);
  header->counter = fvv_chunk_order_counter(&w->order, header->type);
  header->payload_crc = fvv_crc32c(0, payload, (size_t)header->size);
  uint8_t bytes[FVV_CHUNK_HEADER_SIZE];
  fvv_header_write(header, bytes);
  fvv_status status = fvv_chunk_order_check(&w->order, header, payload, w->position, diagnostic);
  if (status < 0) {
    /* A rule of the stream broken by its writer is the caller's mistake; nothing was written. */
    const fvv_status own =
        status == FVV_ERROR_INVALID || status == FVV_ERROR_UNSUPPORTED ? FVV_ERROR_STATE : status;
    if (diagnostic) diagnostic->status = own;
    return own;
  }
  const uint64_t offset = w->position;
  status = put(w, bytes, sizeof bytes, diagnostic);
  if (status == FVV_OK) status = put(w, payload, (size_t)header->size, diagnostic);
  if (status == FVV_OK) status = put(w, zeros, (size_t)(fvv_padded(header->size) - header->size), diagnostic);
  if (status < 0) return status;
  status = fvv_chunk_order_apply(&w->order, header, payload, offset);
  if (status < 0) {
    w->failed = status;
    return fvv_fail(diagnostic, status, 0, header->type, offset, "%s", fvv_status_text(status));
  }
  return FVV_OK;
}

fvv_status fvv_writer_join(fvv_writer *writer, uint32_t sequence) {
  if (writer->order.in_group || writer->order.groups.size) return FVV_ERROR_STATE;
  writer->order.next_sequence = sequence;
  return FVV_OK;
}

static fvv_status beyond(uint32_t type, uint64_t count, const char *what, uint64_t most,
                         fvv_diagnostic *diagnostic) {
  return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, type, 0,
                  "%llu %s, readers accept at most %llu", (unsigned long long)count, what,
                  (unsigned long long)most);
}

/* Limits of a block that the order of chunks does not know (clause 13). */
static fvv_status check_block(const fvv_writer *w, uint32_t type, size_t size, fvv_diagnostic *diagnostic) {
  const fvv_limits *limits = &w->order.limits;
  if (type == FVV_CHUNK_CAMERA && w->cameras >= limits->max_cameras)
    return beyond(type, (uint64_t)w->cameras + 1, "cameras", limits->max_cameras, diagnostic);
  if (type == FVV_CHUNK_METADATA && size > limits->max_text)
    return beyond(type, size, "bytes of metadata", limits->max_text, diagnostic);
  return FVV_OK;
}

fvv_status fvv_writer_configuration(fvv_writer *writer, uint32_t type, uint16_t track, uint8_t flags,
                                    const void *payload, size_t size, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_place place = fvv_chunk_place(type, flags);
  if (place != FVV_PLACE_CONFIGURATION && place != FVV_PLACE_UNKNOWN)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, FVV_ISSUE_CHUNK_PLACE, type, 0,
                    "not a chunk of a configuration");
  if (writer->order.in_group)
    return fvv_fail(diagnostic, FVV_ERROR_STATE, FVV_ISSUE_GROUP_UNFINISHED, type, 0, "a group is open");
  fvv_chunk_header header = {type, (uint8_t)(flags | fvv_chunk_flags(type)), 0, track, 0, size, 0, 0};
  fvv_status status = check_block(writer, type, size, diagnostic);
  if (status < 0) return status;
  const uint64_t extent = fvv_chunk_extent(size);
  if (fvv_bytes_reserve(&writer->block, (size_t)extent) < 0)
    return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, type, 0, "out of memory");
  status = put_chunk(writer, &header, payload, diagnostic);
  if (status < 0) return status;
  if (type == FVV_CHUNK_SCENE) writer->block.size = writer->cameras = 0;
  writer->cameras += type == FVV_CHUNK_CAMERA;
  uint8_t *copy = writer->block.data + writer->block.size;
  memset(copy, 0, (size_t)extent);
  fvv_header_write(&header, copy);
  if (size) memcpy(copy + FVV_CHUNK_HEADER_SIZE, payload, size);
  writer->block.size += (size_t)extent;
  return FVV_OK;
}

fvv_status fvv_writer_repeat_configuration(fvv_writer *writer, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  for (size_t at = 0; at < writer->block.size;) {
    fvv_chunk_header header;
    if (!fvv_header_read(&header, writer->block.data + at))
      return fvv_fail(diagnostic, FVV_ERROR_BUG, 0, 0, 0, "the stored configuration is broken");
    const fvv_status status =
        put_chunk(writer, &header, writer->block.data + at + FVV_CHUNK_HEADER_SIZE, diagnostic);
    if (status < 0) return status;
    at += (size_t)fvv_chunk_extent(header.size);
  }
  return FVV_OK;
}

fvv_status fvv_writer_begin_group(fvv_writer *writer, int64_t start, int64_t end,
                                  fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const uint64_t groups = writer->order.groups.size / sizeof(fvv_index_entry);
  if (groups >= writer->order.limits.max_groups)
    return beyond(FVV_CHUNK_GROUP, groups + 1, "groups", writer->order.limits.max_groups, diagnostic);
  uint8_t payload[FVV_GRUP_SIZE];
  fvv_put_u32(payload + FVV_GRUP_SEQUENCE, writer->order.next_sequence);
  fvv_put_u32(payload + FVV_GRUP_CONFIGURATION_CRC, writer->order.configuration_crc);
  fvv_put_i64(payload + FVV_GRUP_START, start);
  fvv_put_i64(payload + FVV_GRUP_END, end);
  fvv_chunk_header header = {
      FVV_CHUNK_GROUP, fvv_chunk_flags(FVV_CHUNK_GROUP), 0, 0, start, sizeof payload, 0, 0};
  return put_chunk(writer, &header, payload, diagnostic);
}

fvv_status fvv_writer_chunk(fvv_writer *writer, uint32_t type, uint16_t track, uint8_t flags, int64_t time,
                            const void *payload, size_t size, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_place place = fvv_chunk_place(type, flags);
  if (place != FVV_PLACE_FRAME && place != FVV_PLACE_UNKNOWN)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, FVV_ISSUE_CHUNK_PLACE, type, 0, "not a chunk of a frame");
  if (!writer->order.in_group)
    return fvv_fail(diagnostic, FVV_ERROR_STATE, FVV_ISSUE_CHUNK_PLACE, type, 0, "no group is open");
  fvv_chunk_header header = {type, (uint8_t)(flags | fvv_chunk_flags(type)), 0, track, time, size, 0, 0};
  return put_chunk(writer, &header, payload, diagnostic);
}

fvv_status fvv_writer_end_group(fvv_writer *writer, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (!writer->order.in_group)
    return fvv_fail(diagnostic, FVV_ERROR_STATE, FVV_ISSUE_CHUNK_PLACE, 0, 0, "no group is open");
  const fvv_status status = fvv_group_table_encode(&writer->order.table, &writer->scratch);
  if (status < 0) return fvv_fail(diagnostic, status, 0, 0, 0, "out of memory");
  fvv_chunk_header header = {FVV_CHUNK_GROUP_END,
                             fvv_chunk_flags(FVV_CHUNK_GROUP_END),
                             0,
                             0,
                             writer->order.group_end,
                             writer->scratch.size,
                             0,
                             0};
  return put_chunk(writer, &header, writer->scratch.data, diagnostic);
}

fvv_status fvv_writer_finish(fvv_writer *writer, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_status status = fvv_chunk_order_index(&writer->order, &writer->scratch);
  if (status < 0) return fvv_fail(diagnostic, status, 0, 0, 0, "out of memory");
  fvv_chunk_header index = {FVV_CHUNK_INDEX, 0, 0, 0, 0, writer->scratch.size, 0, 0};
  const uint64_t index_offset = writer->position;
  status = put_chunk(writer, &index, writer->scratch.data, diagnostic);
  if (status < 0) return status;
  uint8_t payload[FVV_FOOT_SIZE];
  fvv_footer_write(index_offset, writer->position + fvv_chunk_extent(FVV_FOOT_SIZE), index.payload_crc,
                   payload);
  fvv_chunk_header footer = {
      FVV_CHUNK_FOOTER, fvv_chunk_flags(FVV_CHUNK_FOOTER), 0, 0, 0, sizeof payload, 0, 0};
  return put_chunk(writer, &footer, payload, diagnostic);
}
