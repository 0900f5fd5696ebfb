/* mesh/draco_symbols.h: steps over entropy-coded parts of a Draco 2.2 bitstream without decoding their
 * values. Follows the bitstream specification of Draco, https://google.github.io/draco/spec/. */
#ifndef FVV_MESH_DRACO_SYMBOLS_H
#define FVV_MESH_DRACO_SYMBOLS_H

#include "base/bytes.h"

/* Edgebreaker symbols in Draco's numbering (Rossignac, IEEE TVCG 5(1), 1999). */
enum { FVV_DRACO_C, FVV_DRACO_S, FVV_DRACO_L, FVV_DRACO_R, FVV_DRACO_E, FVV_DRACO_SYMBOLS };

/* Each moves the cursor behind its part and answers 1, or 0 when the part is cut or malformed. */

/* A sequence of bits coded by rABS: probability, size, bytes. */
int fvv_draco_skip_bits(fvv_cursor *cursor);

/* count values in tuples of so many components, coded raw or tagged; no bytes at all for count 0. */
int fvv_draco_skip_symbols(fvv_cursor *cursor, uint64_t count, uint32_t components);

/* The same for count edgebreaker symbols, which go to symbols in the order of the stream. */
int fvv_draco_read_symbols(fvv_cursor *cursor, uint32_t count, uint8_t *symbols);

/* The same for the symbols of standard edgebreaker: their size, then 1 bit for C and 3 for each other. */
int fvv_draco_read_standard(fvv_cursor *cursor, uint32_t count, uint8_t *symbols);

#endif
