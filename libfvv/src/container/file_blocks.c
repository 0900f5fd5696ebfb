/* The configuration of a group. The digest in GRUP decides which block is used: the one that the index names,
 * or any repetition of it (clause 7.4). */
#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "container/file.h"

void fvv_file_release_block(fvv_file *f, fvv_file_block *block) {
  fvv_bytes_free(&block->chunks);
  fvv_bytes_free(&block->tracks);
  fvv_release(&f->allocator, block, sizeof *block);
}

/* Repetitions that are tried when the block of a group is damaged. */
enum { REPETITIONS = 16 };

/* Whether the block has declared the track with a kind that this version does not know. */
static int is_ignored(const fvv_file_block *block, uint16_t id) {
  const fvv_file_track *tracks = (const fvv_file_track *)block->tracks.data;
  for (size_t i = 0; i < block->tracks.size / sizeof *tracks; i++)
    if (tracks[i].id == id) return fvv_kind_is_foreign(tracks[i].kind);
  return 0;
}

/* size: of the block, 0 when it is not known. */
static fvv_status load_block(fvv_file *f, fvv_file_block *block, uint32_t size, fvv_diagnostic *diagnostic) {
  for (uint64_t offset = block->offset;;) {
    if (size && offset - block->offset == size) {
      block->ended = 1;
      return FVV_OK;
    }
    fvv_chunk_header header;
    const int first = offset == block->offset;
    fvv_status status = fvv_file_load(f, offset, &header, first ? diagnostic : &block->why);
    /* Perhaps only what follows the block is damaged: the digest shows it. */
    if (status <= FVV_ERROR_DAMAGED && !first) return FVV_OK;
    if (status < 0) return status;
    const fvv_place place = fvv_chunk_place(header.type, header.flags);
    if (first != (header.type == FVV_CHUNK_SCENE) ||
        (place != FVV_PLACE_CONFIGURATION && place != FVV_PLACE_UNKNOWN)) {
      block->ended = !first;
      if (!first) return FVV_OK;
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CHUNK_PLACE, header.type, offset,
                      "a configuration block begins with SCEN");
    }
    if (place == FVV_PLACE_UNKNOWN && header.flags & FVV_FLAG_CRITICAL && !is_ignored(block, header.track))
      return fvv_fail(diagnostic, FVV_ERROR_UNSUPPORTED, FVV_ISSUE_UNKNOWN_CRITICAL, header.type, offset,
                      "critical chunk of a type that this version does not know");
    const fvv_chunk_info info = {offset, header.size, header.time, header.type, header.track, header.flags};
    status = fvv_bytes_append(&block->chunks, &info, sizeof info);
    if (status == FVV_OK && header.type == FVV_CHUNK_TRACK && header.size >= FVV_TRAK_SIZE) {
      const uint8_t *payload = f->buffer.data;
      const fvv_file_track track = {header.track, payload[FVV_TRAK_KIND], payload[FVV_TRAK_FLAGS]};
      status = fvv_bytes_append(&block->tracks, &track, sizeof track);
    }
    if (status < 0) return status;
    block->crc = fvv_header_chain(block->crc, &header);
    offset += fvv_chunk_extent(header.size);
  }
}

static fvv_status find_block(fvv_file *f, uint64_t offset, uint32_t size, fvv_file_block **found,
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
  block->chunks.allocator = block->tracks.allocator = f->allocator;
  fvv_status status = load_block(f, block, size, diagnostic);
  if (status == FVV_OK) status = fvv_bytes_append(&f->blocks, &block, sizeof block);
  if (status < 0) {
    fvv_file_release_block(f, block);
    return fvv_fail(diagnostic, status, 0, 0, offset, "%s", fvv_status_text(status));
  }
  *found = block;
  return FVV_OK;
}

/* *known: 1 and *digest when the index has it, or the group's GRUP is intact. Fails when the input does. */
static fvv_status digest_of(fvv_file *f, const fvv_group_info *group, int *known, uint32_t *digest,
                            fvv_diagnostic *diagnostic) {
  const fvv_index_block *block = f->index_state == FVV_INDEX_PRESENT ? fvv_file_listed_block(f, group) : NULL;
  *known = 1;
  if (block) {
    *digest = block->digest;
    return FVV_OK;
  }
  fvv_chunk_header header;
  const fvv_status status = fvv_file_load(f, group->offset, &header, diagnostic);
  if (status == FVV_ERROR_MEMORY || status == FVV_ERROR_IO) return status;
  *known = status == FVV_OK && header.type == FVV_CHUNK_GROUP && header.size == FVV_GRUP_SIZE;
  if (*known) *digest = fvv_get_u32(f->buffer.data + FVV_GRUP_CONFIGURATION_CRC);
  return FVV_OK;
}

/* The nearest intact block with the digest, in either direction; *found NULL: none. Fails when the input
 * does. */
static fvv_status search_repetition(fvv_file *f, const fvv_group_info *group, uint32_t digest,
                                    fvv_file_block **found, fvv_diagnostic *diagnostic) {
  const fvv_index_block *blocks = (const fvv_index_block *)f->listed.data;
  const size_t count = f->listed.size / sizeof *blocks;
  size_t after = fvv_first_from(blocks, count, sizeof *blocks, group->configuration_offset), tried = 0;
  if (after < count && blocks[after].offset == group->configuration_offset) after++;
  size_t before = after;
  *found = NULL;
  while (tried < REPETITIONS && (before || after < count)) {
    for (int side = 0; side < 2; side++) {
      if (side ? !before : after == count) continue;
      const fvv_index_block *block = side ? &blocks[--before] : &blocks[after++];
      if (block->digest != digest || block->offset == group->configuration_offset) continue;
      fvv_file_block *loaded;
      const fvv_status status = find_block(f, block->offset, block->size, &loaded, diagnostic);
      if (status == FVV_ERROR_MEMORY || status == FVV_ERROR_IO) return status;
      tried++;
      if (status != FVV_OK || loaded->crc != digest) continue;
      *found = loaded;
      return FVV_OK;
    }
  }
  return FVV_OK;
}

/* Lists damage of a block once, although many groups name it. */
static fvv_status note_damage(fvv_file *f, const fvv_diagnostic *why) {
  const fvv_diagnostic *noted = (const fvv_diagnostic *)f->damage.data;
  for (size_t i = 0; i < f->damage.size / sizeof *noted; i++)
    if (noted[i].offset == why->offset && noted[i].issue == why->issue) return FVV_OK;
  return fvv_bytes_append(&f->damage, why, sizeof *why);
}

/* An intact repetition of the block at offset, NULL: none. why: what is wrong with that block. The damage is
 * listed when the repetition hides it. */
static fvv_status replace_block(fvv_file *f, const fvv_group_info *info, uint32_t digest, fvv_diagnostic *why,
                                fvv_file_block **block, fvv_diagnostic *diagnostic) {
  const fvv_status status = search_repetition(f, info, digest, block, diagnostic);
  if (status < 0 || !*block || f->index_state == FVV_INDEX_REBUILT) return status;
  if (why->status >= 0)
    fvv_fail(why, FVV_ERROR_DAMAGED, FVV_ISSUE_GROUP_CONFIGURATION, FVV_CHUNK_GROUP, info->offset,
             "group %u does not belong to the configuration before it", info->sequence);
  return note_damage(f, why);
}

static fvv_status block_of(fvv_file *file, size_t group, fvv_file_block **found, fvv_diagnostic *diagnostic) {
  const size_t groups = fvv_file_group_count(file);
  if (group >= groups)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "group %zu of %zu", group, groups);
  const fvv_group_info *info = fvv_file_group(file, group);
  uint32_t digest = 0;
  int known;
  fvv_status status = digest_of(file, info, &known, &digest, diagnostic);
  if (status < 0) return status;
  fvv_file_block *block = NULL;
  fvv_diagnostic why = {0};
  status = find_block(file, info->configuration_offset, info->configuration_size, &block, &why);
  if (status == FVV_ERROR_MEMORY || status == FVV_ERROR_IO || status == FVV_ERROR_UNSUPPORTED) {
    if (diagnostic) *diagnostic = why;
    return status;
  }
  /* Without the digest only the end of the block shows that it is whole. */
  if (status < 0 || (known ? block->crc != digest : !block->ended)) {
    if (status >= 0) why = block->why;
    block = NULL;
    status = known ? replace_block(file, info, digest, &why, &block, diagnostic) : FVV_OK;
    if (status < 0) return fvv_fail(diagnostic, status, 0, 0, info->offset, "out of memory");
  }
  if (!block)
    return fvv_fail(diagnostic, FVV_ERROR_DAMAGED, FVV_ISSUE_GROUP_CONFIGURATION, FVV_CHUNK_GROUP,
                    info->offset, "the configuration of group %u is lost", info->sequence);
  *found = block;
  return FVV_OK;
}

fvv_status fvv_file_configuration(fvv_file *file, size_t group, const fvv_chunk_info **chunks, size_t *count,
                                  fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_file_block *block = NULL;
  const fvv_status status = block_of(file, group, &block, diagnostic);
  if (status < 0) return status;
  fvv_diagnostic_clear(diagnostic);
  *chunks = (const fvv_chunk_info *)block->chunks.data;
  *count = block->chunks.size / sizeof **chunks;
  return FVV_OK;
}

int fvv_file_makes_frame(fvv_frame_rule *rule, const fvv_chunk_info *chunk) {
  const int by_type = fvv_type_makes_frame(chunk->type);
  if (by_type >= 0 || !chunk->track) return by_type == 1;
  if (!rule->looked && block_of(rule->file, rule->group, &rule->block, NULL) != FVV_OK) rule->block = NULL;
  rule->looked = 1;
  if (!rule->block) return 0;
  const fvv_file_track *tracks = (const fvv_file_track *)rule->block->tracks.data;
  for (size_t i = 0; i < rule->block->tracks.size / sizeof *tracks; i++)
    if (tracks[i].id == chunk->track) return fvv_makes_frame(chunk->type, tracks[i].kind, tracks[i].flags);
  return 0;
}
