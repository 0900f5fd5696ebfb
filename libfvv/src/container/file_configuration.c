/* container/file_configuration.c: the configuration of a group. Its digest in GRUP decides which block
 * serves: the one that the index names, or any repetition of it (clause 7.4). */
#include "container/file.h"

#include "base/bytes.h"
#include "base/diagnostic.h"

/* Neighbouring groups on either side whose blocks are tried when a group's own is damaged. */
enum { NEIGHBOURS = 32 };

static fvv_status load_block(fvv_file *f, fvv_file_block *block, fvv_diagnostic *diagnostic) {
  for (uint64_t offset = block->offset;;) {
    fvv_chunk_header header;
    const int first = offset == block->offset;
    fvv_status status = fvv_file_load(f, offset, &header, first ? diagnostic : NULL);
    /* Perhaps only what follows the block is damaged: digests decide. */
    if (status <= FVV_ERROR_DAMAGED && !first) return FVV_OK;
    if (status < 0) return status;
    const fvv_place place = fvv_chunk_place(header.type);
    if (first != (header.type == FVV_CHUNK_SCENE) ||
        (place != FVV_PLACE_CONFIGURATION && place != FVV_PLACE_UNKNOWN)) {
      block->ended = !first;
      if (!first) return FVV_OK;
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CHUNK_PLACE, header.type, offset,
                      "a configuration block begins with SCEN");
    }
    if (place == FVV_PLACE_UNKNOWN && header.flags & FVV_FLAG_CRITICAL)
      return fvv_fail(diagnostic, FVV_ERROR_UNSUPPORTED, FVV_ISSUE_UNKNOWN_CRITICAL, header.type, offset,
                      "critical chunk of a type that this version does not know");
    const fvv_chunk_info info = {offset, header.size, header.time, header.type, header.track, header.flags};
    status = fvv_bytes_append(&block->chunks, &info, sizeof info);
    if (status < 0) return status;
    block->crc = fvv_header_chain(block->crc, &header);
    offset += fvv_chunk_extent(header.size);
  }
}

static fvv_status find_block(fvv_file *f, uint64_t offset, fvv_file_block **found,
                             fvv_diagnostic *diagnostic) {
  fvv_file_block **blocks = (fvv_file_block **)f->blocks.data;
  for (size_t i = 0; i < f->blocks.size / sizeof *blocks; i++)
    if (blocks[i]->offset == offset) {
      *found = blocks[i];
      return FVV_OK;
    }
  fvv_file_block *block = fvv_allocate_zeroed(&f->allocator, sizeof *block);
  if (!block) return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, offset, "out of memory");
  block->offset = offset;
  block->chunks.allocator = f->allocator;
  fvv_status status = load_block(f, block, diagnostic);
  if (status == FVV_OK) status = fvv_bytes_append(&f->blocks, &block, sizeof block);
  if (status < 0) {
    fvv_bytes_free(&block->chunks);
    fvv_release(&f->allocator, block, sizeof *block);
    return fvv_fail(diagnostic, status, 0, 0, offset, "%s", fvv_status_text(status));
  }
  *found = block;
  return FVV_OK;
}

static const fvv_group_info *group_at(const fvv_file *f, size_t i) {
  return &((const fvv_index_entry *)f->entries.data + i)->group;
}

/* 1 and *digest when the group's GRUP is intact. */
static int digest_of(fvv_file *f, const fvv_group_info *group, uint32_t *digest) {
  fvv_chunk_header header;
  if (fvv_file_load(f, group->offset, &header, NULL) != FVV_OK || header.type != FVV_CHUNK_GROUP ||
      header.size != FVV_GRUP_SIZE)
    return 0;
  *digest = fvv_get_u32(f->buffer.data + FVV_GRUP_CONFIGURATION_CRC);
  return 1;
}

/* The first block with the digest among those of the groups around; NULL: none. */
static fvv_file_block *search_repetition(fvv_file *f, size_t group, uint32_t digest) {
  const size_t count = f->entries.size / sizeof(fvv_index_entry);
  for (size_t distance = 1; distance <= NEIGHBOURS; distance++)
    for (int side = 0; side < 2; side++) {
      if (side ? distance > group : group + distance >= count) continue;
      const fvv_group_info *other = group_at(f, side ? group - distance : group + distance);
      fvv_file_block *block;
      if (find_block(f, other->configuration_offset, &block, NULL) == FVV_OK && block->crc == digest)
        return block;
    }
  return NULL;
}

fvv_status fvv_file_configuration(fvv_file *file, size_t group, const fvv_chunk_info **chunks, size_t *count,
                                  fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const size_t groups = file->entries.size / sizeof(fvv_index_entry);
  if (group >= groups)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "group %zu of %zu", group, groups);
  const fvv_group_info *info = group_at(file, group);
  uint32_t digest = 0;
  const int known = digest_of(file, info, &digest);
  fvv_file_block *block = NULL;
  const fvv_status status = find_block(file, info->configuration_offset, &block, diagnostic);
  if (status == FVV_ERROR_MEMORY || status == FVV_ERROR_IO || status == FVV_ERROR_UNSUPPORTED) return status;
  /* Without the digest only the end of the block tells that it is whole. */
  if (status < 0 || (known ? block->crc != digest : !block->ended))
    block = known ? search_repetition(file, group, digest) : NULL;
  if (!block)
    return fvv_fail(diagnostic, FVV_ERROR_DAMAGED, FVV_ISSUE_GROUP_CONFIGURATION, FVV_CHUNK_GROUP,
                    info->offset, "the configuration of group %u is lost", info->sequence);
  fvv_diagnostic_clear(diagnostic);
  *chunks = (const fvv_chunk_info *)block->chunks.data;
  *count = block->chunks.size / sizeof **chunks;
  return FVV_OK;
}
