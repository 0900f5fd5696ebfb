// Random access by the index, and rebuilding it: every chunk of every group is read.
#include "../fuzz.h"

#include "fvv/stream.h"

#include <algorithm>

FVV_FUZZ_TARGET(file, fuzz::Form::stream) {
  fuzz::Memory memory = {data, size};
  const fvv_input input = memory.input();
  fvv_stream *file = nullptr;
  fvv_diagnostic diagnostic;
  const fvv_status opened = fvv_stream_open(&input, nullptr, nullptr, &file, &diagnostic);
  fuzz::expect_status(opened);
  if (opened != FVV_OK) {
    fuzz::expect(!file, "a file that was not opened is NULL");
    return;
  }
  const size_t groups = fvv_stream_group_count(file);
  for (size_t g = 0; g < std::min<size_t>(groups, 50); g++) {
    const fvv_group_info *group = fvv_stream_group(file, g);
    fuzz::expect(group->offset <= size && group->size <= size - group->offset, "groups are in the file");
    for (const bool configuration : {false, true}) {
      const fvv_chunk_info *chunks = nullptr;
      size_t count = 0;
      const fvv_status status = configuration
                                    ? fvv_stream_configuration_chunks(file, g, &chunks, &count, &diagnostic)
                                    : fvv_stream_group_chunks(file, g, &chunks, &count, &diagnostic);
      fuzz::expect_status(status);
      for (size_t i = 0; status == FVV_OK && i < std::min<size_t>(count, 200); i++) {
        const uint8_t *payload = nullptr;
        const fvv_status read = fvv_stream_read_chunk(file, &chunks[i], &payload, &diagnostic);
        fuzz::expect_status(read);
        if (read == FVV_OK) (void)fvv_crc32c(0, payload, size_t(chunks[i].size));
      }
    }
  }
  fuzz::expect(!fvv_stream_group(file, groups), "there is no group after the last one");
  for (size_t i = 0; i < fvv_stream_damage_count(file); i++)
    fuzz::expect(fvv_stream_damage(file, i)->status < 0, "damage has a status");
  fvv_stream_close(file);
}
