/* What the codecs behind image.h and video.h share, and the still-picture codecs. Internal to fvv_media. */
#ifndef FVV_MEDIA_CODECS_H
#define FVV_MEDIA_CODECS_H

#include "fvv_media/image.h"

namespace fvv::media {

/* Error unless both sides are 1 ... max_dimension. */
void check_dimensions(uint32_t width, uint32_t height, const std::string &name);
/* Error unless the picture is what image.h says an Image is. */
template <class SampleType> void check_image(const BasicImage<SampleType> &image);
/* Error when size bytes cannot hold so many samples even at the best rate that the format can reach: a few
 * bytes must not ask for gigabytes. */
void check_justified(uint64_t samples, uint64_t samples_per_byte, size_t size, const std::string &name);

/* A whole file. Error when it cannot be read or is larger than any picture needs. */
std::vector<uint8_t> read_file(const std::string &path);

/* Eight bits brought to a sample type: times 257 for 16. */
template <class SampleType> BasicImage<SampleType> with_samples(Image image);
/* In 1 or 3 channels, as read_image says. */
template <class SampleType> BasicImage<SampleType> with_channels(BasicImage<SampleType> image, int channels);

/* Throws Error: a code that is none of video_codecs(). */
[[noreturn]] void refuse_codec(uint32_t code);

bool is_png(const uint8_t *bytes, size_t size);
bool is_jpeg(const uint8_t *bytes, size_t size);
bool is_exr(const uint8_t *bytes, size_t size);

/* The header alone; bytes may end anywhere behind it. Error when they end before. */
ImageInfo probe_png(const uint8_t *bytes, size_t size, const std::string &name);
ImageInfo probe_jpeg(const uint8_t *bytes, size_t size, const std::string &name);
ImageInfo probe_exr(const uint8_t *bytes, size_t size, const std::string &name);

/* In the channels of the file. */
template <class SampleType>
BasicImage<SampleType> decode_png(const uint8_t *bytes, size_t size, const std::string &name);
Image decode_jpeg(const uint8_t *bytes, size_t size, const std::string &name);
template <class SampleType>
BasicImage<SampleType> decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name);

} // namespace fvv::media

#endif
