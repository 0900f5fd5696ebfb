/* Linear light from display values and back. Internal to fvv_media. */
#ifndef FVV_MEDIA_LINEAR_H
#define FVV_MEDIA_LINEAR_H

#include "fvv_media/image.h"

namespace fvv::media {

/* By the inverse of the sRGB curve. */
LinearImage linear_of(const DeepImage &image);
/* Clipped to 0 ... 1 and by the sRGB curve, for uint8_t or uint16_t. */
template <class SampleType> BasicImage<SampleType> display_of(const LinearImage &image);

/* srgb_of_linear of a value rounded to a half float, quickly; infinite where halves are. */
float srgb_of_half(float linear);

/* The first value that is not finite: Error that names channel and pixel. */
void check_finite(const LinearImage &image, const std::string &name);

} // namespace fvv::media

#endif
