/* See encoder_options.h. */
#include "encoder_options.h"

extern "C" {
#include <libavutil/opt.h>
}

#include <algorithm>
#include <climits>
#include <cstdio>

namespace fvv::media {
namespace {

/* What the options do. Pictures are texture for a surface: accurate codes matter, not the look of one frame,
 * hence tune=psnr (the default of libvpx and libaom). At the same PSNR of the foreground this saves about a
 * tenth of the bytes.
 *
 * x264's slower takes 10 % fewer bytes than slow for tiles with a flat background, at 36 dB and at 42. me,
 * subme and weightp save a fifth of its time and add no bytes (-0.06 % at 42 dB, +0.09 % at 36); trellis=1
 * would save as much again for 1 % more, ref=5 as well. A draft has the PSNR of the same CRF less 0.3 to 0.4
 * dB, and the same fall from one CRF to the next within 0.01 dB.
 *
 * x265's slow decides by rate and distortion and tries rectangular partitions, which at 42 dB saves a quarter
 * of medium's bytes. A first pass tells libvpx how much of every picture the next ones need, which saves a
 * fifth even without pictures ahead.
 *
 * An encoder lives for one group, so its first picture is the only key: libx264 and libx265 get an infinite
 * keyint, as a keyint equal to the number of frames would leak into the parameter sets and make records
 * differ between groups. No look ahead in libvpx and libaom: with it they hide frames in packets. One thread
 * everywhere: the same bytes in every run. x264 is set to be independent of the CPU; the other libraries have
 * no such option, so their bytes may differ between machines.
 *
 * x264 looks ahead over a whole group, and keeps what it looks at: of large frames fewer, so that a group of
 * 20 HD cameras fits into memory.
 *
 * The memory for a pixel was measured with frames of 4272 x 1408, all buffers above 64 KiB, the group's
 * pictures at the encoder's input included.
 *
 * stitchable: parameter sets that do not depend on the CRF, as groups of one stream may differ in it.
 * force-cfr: the rate in the parameter sets is the one that was given. chromaloc=1: chroma in the middle, as
 * to_yuv makes it. aud, info and repeat-headers: off, as fvv samples do not contain them. */
#define FVV_X264_GROUP                                                                                       \
  "keyint=infinite:scenecut=0:open-gop=0:bframes=0:threads=1:lookahead-threads=1:sliced-threads=0:"          \
  "cpu-independent=1:"
#define FVV_X264_SETS "stitchable=1:force-cfr=1:chromaloc=1:aud=0:repeat-headers=0:"

const std::vector<VideoEncoder> encoders = {
    {FVV_CODEC_AVC1,
     "libx264",
     {{"preset", "slower"},
      {"tune", "psnr"},
      {"profile", "high"},
      {"x264-params", FVV_X264_GROUP FVV_X264_SETS "me=hex:subme=8:weightp=1"}},
     avc_bitstream,
     8,
     false,
     {{"preset", "veryfast"}, {"x264-params", FVV_X264_GROUP "trellis=1"}},
     {{"preset", "slow"}, {"x264-params", FVV_X264_GROUP FVV_X264_SETS "me=hex:subme=7:weightp=1"}},
     {{"preset", "veryfast"}, {"x264-params", FVV_X264_GROUP FVV_X264_SETS "trellis=1:subme=4"}},
     {{"preset", "veryfast"}, {"x264-params", FVV_X264_GROUP FVV_X264_SETS "trellis=0:subme=1:me=dia"}},
     12,
     2.7,
     4.8,
     0,
     8},
    {FVV_CODEC_HVC1,
     "libx265",
     {{"preset", "slow"},
      {"tune", "psnr"},
      {"profile", "main"}, // and the depth where it is not 8
      {"x265-params",
       "log-level=none:keyint=-1:scenecut=0:open-gop=0:bframes=0:b-adapt=0:pools=none:"
       "frame-threads=1:wpp=0:chromaloc=1:aud=0:info=0:hrd=0:repeat-headers=0:ctu="}}, // the side follows
     hevc_bitstream,
     8,
     false,
     {},
     {{"preset", "medium"}},
     {{"preset", "superfast"}},
     {},
     12,
     3.3,
     13,
     28,
     6},
    {FVV_CODEC_VP09,
     "libvpx-vp9",
     {{"deadline", "good"},
      {"cpu-used", "2"},
      {"lag-in-frames", "0"},
      {"auto-alt-ref", "0"},
      {"row-mt", "0"}},
     vp9_bitstream,
     1,
     true,
     {},
     {{"cpu-used", "4"}},
     {{"cpu-used", "5"}},
     {},
     75,
     1.5,
     0,
     INT_MAX, // both passes need all
     0},
    {FVV_CODEC_AV01,
     "libaom-av1",
     {{"usage", "good"}, {"cpu-used", "6"}, {"lag-in-frames", "0"}, {"auto-alt-ref", "0"}, {"row-mt", "0"}},
     av1_bitstream,
     1,
     false,
     {},
     {{"cpu-used", "7"}},
     {{"usage", "realtime"}, {"cpu-used", "8"}},
     {},
     50,
     0,
     0,
     1,
     0}};

void set_option(AVCodecContext *context, const VideoEncoder &encoder, const char *name,
                const std::string &value) {
  const int code = av_opt_set(context->priv_data, name, value.c_str(), 0);
  if (code < 0) fail(std::string(encoder.library) + " does not take the option " + name, code);
}

/* A picture of libx265 has to hold one coding tree unit, by default of 64 pixels a side. */
std::string tree_unit(const VideoSettings &settings) {
  const uint32_t side = std::min(settings.width, settings.height);
  if (side < 16)
    throw Error("a frame of HEVC is " + std::to_string(settings.width) + " x " +
                std::to_string(settings.height) + ", expected at least 16 x 16");
  return side >= 64 ? "64" : side >= 32 ? "32" : "16";
}

std::string value_of(const EncoderOption &option, const VideoSettings &settings) {
  const std::string name = option.name, value = option.value;
  if (name == "x265-params") return value + tree_unit(settings);
  // Only HEVC gets here with more than 8 bits: libvpx and libaom go by the pixel format alone.
  if (name == "profile" && settings.bit_depth > 8) return value + std::to_string(settings.bit_depth);
  return value;
}

/* Frames that x264 may look ahead; its preset's number for all but large frames. */
int look_ahead(const VideoSettings &settings) {
  constexpr double most_bytes = 128 << 20;
  constexpr int least = 10, of_preset = 60;
  const double frame = 1.5 * settings.width * settings.height;
  return std::clamp(int(most_bytes / frame), least, of_preset);
}

/* Those that replace some of the encoder's. */
const std::vector<EncoderOption> &options_in_place(const VideoEncoder &encoder,
                                                   const VideoSettings &settings) {
  static const std::vector<EncoderOption> none;
  if (settings.draft) return encoder.draft;
  if (settings.effort == Effort::least && !encoder.least.empty()) return encoder.least;
  return settings.effort == Effort::fast  ? encoder.fast
         : settings.effort < Effort::fast ? encoder.live
                                          : none;
}

/* As the presets for drafts and live have it. */
bool looks_little_ahead(const VideoSettings &settings) {
  return settings.draft || settings.effort < Effort::fast;
}

/* "23", "22.625". */
std::string number_text(double value) {
  char text[32];
  snprintf(text, sizeof text, "%g", value);
  return text;
}

void check(const VideoSettings &settings, double crf) {
  const VideoCodec &codec = *find_video_codec(settings.codec);
  if (settings.width % 2 || settings.height % 2)
    throw Error(std::string("a frame of ") + codec.name + " is " + std::to_string(settings.width) + " x " +
                std::to_string(settings.height) + ", expected even numbers");
  if (crf < codec.finest || crf > codec.coarsest)
    throw Error(std::string(codec.name) + " quality is CRF " + number_text(crf) + ", expected " +
                std::to_string(codec.finest) + " to " + std::to_string(codec.coarsest));
  const fvv_rational &rate = settings.frame_rate;
  if (rate.numerator == 0 || rate.denominator == 0 || rate.numerator > INT_MAX || rate.denominator > INT_MAX)
    throw Error("the frame rate is " + std::to_string(rate.numerator) + "/" +
                std::to_string(rate.denominator) + " s per frame, expected positive 31-bit numbers");
}

} // namespace

const VideoEncoder *find_encoder(uint32_t codec) {
  for (const VideoEncoder &encoder : encoders)
    if (encoder.codec == codec) return &encoder;
  return nullptr;
}

int parts_of_quality(uint32_t code) {
  const VideoEncoder *encoder = find_encoder(code);
  return encoder ? encoder->steps_per_unit : 1;
}

uint64_t encoding_memory(const VideoSettings &settings, size_t frames) {
  constexpr double still = 15; // a picture, at most in floats
  constexpr int draft_ahead = 10, draft_kept = 1;
  constexpr int beyond = 3; // frames that x264 has besides those ahead
  const auto few = [&](int most) { return std::min(double(most), double(frames)); };
  const VideoEncoder *encoder = find_encoder(settings.codec);
  double bytes = still; // a pixel
  if (encoder) {
    const int ahead = looks_little_ahead(settings) ? draft_ahead : look_ahead(settings);
    bytes = encoder->memory +
            encoder->waiting_memory * few(encoder->waiting ? encoder->waiting : ahead + beyond) +
            encoder->kept_memory * few(settings.draft ? draft_kept : encoder->kept);
    if (settings.bit_depth > 8) bytes *= 2;
  }
  if (settings.bit_rate) bytes += 1.5 * double(frames); // the pictures, for the next try
  return uint64_t(bytes * settings.width * settings.height);
}

static std::string why_no_encoder(const VideoEncoder &missing) {
  std::string others;
  for (const VideoEncoder &encoder : encoders)
    if (avcodec_find_encoder_by_name(encoder.library))
      others += std::string(find_video_codec(encoder.codec)->option) + ", ";
  return std::string("this build of FFmpeg has no ") + missing.library + ", which encodes " +
         find_video_codec(missing.codec)->name + "; expected one of its codecs: " + others + "jpeg";
}

Context open_encoder(const VideoEncoder &encoder, const VideoSettings &settings, double crf, int pass,
                     const std::string &statistics) {
  check(settings, crf);
  quiet_log();
  clear_log();
  const AVCodec *codec = avcodec_find_encoder_by_name(encoder.library);
  if (!codec) throw Error(why_no_encoder(encoder));
  Context context = make_context(codec);
  const Colour colour = colour_of_codec(settings.codec);
  context->width = int(settings.width);
  context->height = int(settings.height);
  context->time_base = {int(settings.frame_rate.numerator), int(settings.frame_rate.denominator)};
  context->framerate = {int(settings.frame_rate.denominator), int(settings.frame_rate.numerator)};
  context->pix_fmt = pixel_format(settings.bit_depth);
  context->color_primaries = AVColorPrimaries(colour.primaries);
  context->color_trc = AVColorTransferCharacteristic(colour.transfer);
  context->colorspace = AVColorSpace(colour.matrix);
  context->color_range = colour.full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  context->max_b_frames = 0;
  context->gop_size = INT_MAX;                           // libx264 and libx265 go by keyint
  if (encoder.two_passes) context->keyint_min = INT_MAX; // else the first pass finds cuts and asks for keys
  context->bit_rate = 0;                                 // constant quality
  context->thread_count = 1;
  // Global header: parameter sets go to extradata, where the record takes them from.
  context->flags |= AV_CODEC_FLAG_CLOSED_GOP | AV_CODEC_FLAG_GLOBAL_HEADER;
  context->flags |= pass;
  // Borrowed and only read, though libavcodec's field is not const.
  if (pass == AV_CODEC_FLAG_PASS2) context->stats_in = const_cast<char *>(statistics.c_str());
  for (const EncoderOption &option : encoder.options)
    set_option(context.get(), encoder, option.name, value_of(option, settings));
  for (const EncoderOption &option : options_in_place(encoder, settings))
    set_option(context.get(), encoder, option.name, value_of(option, settings));
  if (settings.codec == FVV_CODEC_AVC1 && !looks_little_ahead(settings))
    set_option(context.get(), encoder, "rc-lookahead", std::to_string(look_ahead(settings)));
  set_option(context.get(), encoder, "crf", number_text(crf));
  const int code = avcodec_open2(context.get(), codec, nullptr);
  if (code < 0) fail(std::string(encoder.library) + " refuses the settings", code);
  return context;
}

} // namespace fvv::media
