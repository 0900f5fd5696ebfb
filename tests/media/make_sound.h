/* Sound for tests, and files of it, written by libavformat and libavcodec directly, without fvv_media. */
#ifndef FVV_TESTS_MEDIA_MAKE_SOUND_H
#define FVV_TESTS_MEDIA_MAKE_SOUND_H

#include <cstdint>
#include <string>
#include <vector>

/* Interleaved samples, alike in all channels: faint noise with a short click at each of these times. */
std::vector<float> clicks(int rate, int channels, double duration, const std::vector<double> &times);

/* Interleaved samples: other chords in each channel, with noise. */
std::vector<float> tones(int rate, int channels, double duration);

/* The sample at which a click begins in decoded sound, within 40 ms of about, by correlation of all channels'
 * sum. */
int64_t find_click(const std::vector<float> &samples, uint32_t channels, uint32_t rate, int64_t about);

/* encoder: FFmpeg's name; the container by the name's extension. */
void write_sound(const std::string &path, const char *encoder, const std::vector<float> &samples,
                 int channels, int rate);

/* Matroska with PCM and a picture of MPEG-4 each 40 ms, the first at picture_start seconds. */
void write_video_with_sound(const std::string &path, double picture_start, const std::vector<float> &samples,
                            int channels, int rate);

#endif
