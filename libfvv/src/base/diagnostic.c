#include "base/diagnostic.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/layout.h"

const char *fvv_status_text(fvv_status status) {
  switch (status) {
  case FVV_OK:
    return "done";
  case FVV_NEED_DATA:
    return "needs more data";
  case FVV_END:
    return "end of stream";
  case FVV_ERROR_ARGUMENT:
    return "argument out of range";
  case FVV_ERROR_MEMORY:
    return "out of memory";
  case FVV_ERROR_BUFFER_TOO_SMALL:
    return "buffer too small";
  case FVV_ERROR_IO:
    return "input or output failed";
  case FVV_ERROR_STATE:
    return "call not allowed in this state";
  case FVV_ERROR_INPUT:
    return "unusable input";
  case FVV_ERROR_DAMAGED:
    return "damaged";
  case FVV_ERROR_TRUNCATED:
    return "truncated";
  case FVV_ERROR_INVALID:
    return "against the specification";
  case FVV_ERROR_UNSUPPORTED:
    return "not supported by this version";
  case FVV_ERROR_LIMIT:
    return "beyond the limits of this reader";
  case FVV_ERROR_BUG:
    return "internal error, please report it";
  default:
    return "unknown status";
  }
}

fvv_status fvv_fail(fvv_diagnostic *diagnostic, fvv_status status, uint32_t issue, uint32_t chunk_type,
                    uint64_t offset, const char *format, ...) {
  if (!diagnostic || diagnostic->status < 0) return status;
  diagnostic->status = status;
  diagnostic->issue = issue;
  diagnostic->chunk_type = chunk_type;
  diagnostic->offset = diagnostic->chunk_offset = offset;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(diagnostic->message, sizeof diagnostic->message, format, arguments);
  va_end(arguments);
  return status;
}

void fvv_diagnostic_clear(fvv_diagnostic *diagnostic) {
  if (diagnostic) memset(diagnostic, 0, sizeof *diagnostic);
}

void fvv_diagnostic_rebase(fvv_diagnostic *diagnostic, uint64_t payload_offset, uint32_t chunk_type) {
  if (!diagnostic || diagnostic->status >= 0) return;
  diagnostic->offset += payload_offset;
  diagnostic->chunk_offset =
      payload_offset < FVV_CHUNK_HEADER_SIZE ? 0 : payload_offset - FVV_CHUNK_HEADER_SIZE;
  if (!diagnostic->chunk_type) diagnostic->chunk_type = chunk_type;
}

void fvv_type_text(uint32_t type, char out[5]) {
  for (int i = 0; i < 4; i++) {
    const unsigned c = type >> (8 * i) & 255;
    out[i] = c >= 0x20 && c <= 0x7e ? (char)c : '?';
  }
  out[4] = 0;
}

size_t fvv_diagnostic_format(const fvv_diagnostic *diagnostic, const char *name, char *out, size_t capacity) {
  char type[8] = "", issue[24] = "", place[32] = "";
  if (diagnostic->chunk_type) {
    fvv_type_text(diagnostic->chunk_type, type);
    strcat(type, ": ");
  }
  if (diagnostic->issue) snprintf(issue, sizeof issue, " [FVV-%04" PRIu32 "]", diagnostic->issue);
  /* Only errors of the stream have an offset, the caller's mistakes have none. */
  if (diagnostic->status <= FVV_ERROR_DAMAGED)
    snprintf(place, sizeof place, "0x%" PRIx64 ": ", diagnostic->offset);
  const char *text = diagnostic->message[0] ? diagnostic->message : fvv_status_text(diagnostic->status);
  const int length =
      snprintf(out, capacity, "%s%s%s%s%s%s", name ? name : "", name ? ": " : "", place, type, text, issue);
  return length < 0 ? 0 : (size_t)length;
}
