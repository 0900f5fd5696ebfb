/* fvv_media/srgb.h: linear light and sRGB. It knows the curve of IEC 61966-2-1 and nothing of files. */
#ifndef FVV_MEDIA_SRGB_H
#define FVV_MEDIA_SRGB_H

#include <cstdint>
#include <vector>

namespace fvv::media {

/* The least float32 of linear light (1: white) that becomes code 1, 2, ... largest, ascending: a code is the
 * number of thresholds at or below the value, which clips at both ends. largest: 255 for 8 bits, 65535 for
 * 16. A code is the curve's value times largest, rounded to the nearest integer; no float lies half-way.
 *
 * The curve is inverted: its power 2.4 = 12 / 5 turns "curve(x) reaches v" into a comparison of x^5 with the
 * 12th power of a rational number, so products of doubles decide and no machine's pow() does. */
std::vector<float> srgb_thresholds(uint32_t largest);

/* The linear light of codes 0 ... largest, rounded once: sums and products alone, the same on every machine.
 */
std::vector<float> linear_of_codes(uint32_t largest);

/* The curve and its inverse, 1 for white, continued above 1 by the formula and below 0 by odd symmetry: for
 * pictures with light beyond white that are mixed with or measured like display values. */
double srgb_of_linear(double linear);
double linear_of_srgb(double display);

} // namespace fvv::media

#endif
