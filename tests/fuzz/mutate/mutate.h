// Mutations that keep inputs readable: a stream whose chunks were changed gets sizes, CRCs, counters, tables
// and index that fit again, so that what is wrong in it is found where it is and not by the first checksum.
#pragma once

#include "../fuzz.h"

namespace fuzz {

// Changes at most `capacity` bytes in place, returns the new size: LLVMFuzzerMutate, or mutate_bytes.
using MutateBytes = size_t (*)(uint8_t *data, size_t size, size_t capacity);

// How much of a stream is made right after a mutation.
enum class Repair {
  none,
  checksums, // sizes and CRCs of headers and payloads
  all,       // counters, digests of groups, GEND, INDX and FOOT besides
};

Bytes mutate_stream(const Bytes &stream, size_t capacity, Random &random, MutateBytes mutate);
// The beginning of one and the end of the other, cut between chunks.
Bytes cross_streams(const Bytes &first, const Bytes &second, Random &random);
Bytes repair_stream(const Bytes &stream, Repair how);

// Chunks with a CRC-32 (PNG), chunks with a length (GLB).
Bytes mutate_png(const Bytes &file, size_t capacity, Random &random, MutateBytes mutate);
Bytes mutate_glb(const Bytes &file, size_t capacity, Random &random, MutateBytes mutate);

// Simple mutations of our own, for builds without libFuzzer; the seed is set by seed_mutations.
void seed_mutations(uint64_t seed);
size_t mutate_bytes(uint8_t *data, size_t size, size_t capacity);

// Any of these by the form of a target. Never longer than capacity.
Bytes mutate(Form form, const Bytes &input, size_t capacity, Random &random, MutateBytes mutate);

} // namespace fuzz
