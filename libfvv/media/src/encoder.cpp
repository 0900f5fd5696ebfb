/* Encoding a group: JPEG by TurboJPEG, H.264 by libx264 through libavcodec. See fvv_media/video.h. */
#include "fvv_media/video.h"

#include "avc.h"
#include "codecs.h"
#include "ffmpeg.h"

extern "C" {
#include <libavutil/opt.h>
}

#include <climits>
#include <cstring>

namespace fvv::media {
namespace {

void check_settings(const VideoSettings &settings, const std::vector<Image> &frames) {
  check_dimensions(settings.width, settings.height, "a video frame");
  if (frames.empty()) throw Error("a group needs at least one frame");
  for (size_t i = 0; i < frames.size(); i++) {
    check_image(frames[i]);
    if (frames[i].width != settings.width || frames[i].height != settings.height || frames[i].channels != 3)
      throw Error("frame " + std::to_string(i) + " of the group is " + std::to_string(frames[i].width) +
                  " x " + std::to_string(frames[i].height) + " x " + std::to_string(frames[i].channels) +
                  ", expected " + std::to_string(settings.width) + " x " + std::to_string(settings.height) +
                  " x 3");
  }
}

EncodedGroup encode_jpeg_group(const VideoSettings &settings, const std::vector<Image> &frames) {
  EncodedGroup group;
  for (const Image &frame : frames)
    group.samples.push_back({encode_jpeg(frame, settings.quality, Subsampling::yuv420), true});
  return group;
}

/* What the options do. Infinite keyint: an encoder lives for one group, so its first picture is the only IDR;
 * a keyint equal to the number of frames would leak into the parameter sets and make records differ between
 * groups. cpu-independent and threads=1: the same bytes on every machine with the same x264. force-cfr: the
 * rate in the parameter sets is the one that was given. chromaloc=1: chroma in the middle, as to_yuv makes
 * it. aud and repeat-headers: what an fvv sample leaves out is better not made. */
constexpr char x264_parameters[] =
    "keyint=infinite:scenecut=0:open-gop=0:bframes=0:threads=1:lookahead-threads=1:"
    "sliced-threads=0:cpu-independent=1:force-cfr=1:chromaloc=1:aud=0:"
    "repeat-headers=0";

void set_option(AVCodecContext *context, const char *name, const char *value) {
  const int code = av_opt_set(context->priv_data, name, value, 0);
  if (code < 0) fail(std::string("libx264 does not take the option ") + name, code);
}

Context open_encoder(const VideoSettings &settings) {
  if (settings.width % 2 || settings.height % 2)
    throw Error("a frame of H.264 is " + std::to_string(settings.width) + " x " +
                std::to_string(settings.height) + ", expected even numbers");
  if (settings.quality < 1 || settings.quality > 51)
    throw Error("H.264 quality is CRF " + std::to_string(settings.quality) + ", expected 1 to 51");
  const fvv_rational &rate = settings.frame_rate;
  if (rate.numerator == 0 || rate.denominator == 0 || rate.numerator > INT_MAX || rate.denominator > INT_MAX)
    throw Error("the frame rate is " + std::to_string(rate.numerator) + "/" +
                std::to_string(rate.denominator) + " s per frame, expected positive 31-bit numbers");
  quiet_log();
  clear_log();
  const AVCodec *codec = avcodec_find_encoder_by_name("libx264");
  if (!codec) throw Error("this build of FFmpeg has no libx264");
  Context context = make_context(codec);
  context->width = int(settings.width);
  context->height = int(settings.height);
  context->time_base = {int(rate.numerator), int(rate.denominator)};
  context->framerate = {int(rate.denominator), int(rate.numerator)};
  context->pix_fmt = AV_PIX_FMT_YUV420P;
  context->color_primaries = AVColorPrimaries(colour_of_avc1.primaries);
  context->color_trc = AVColorTransferCharacteristic(colour_of_avc1.transfer);
  context->colorspace = AVColorSpace(colour_of_avc1.matrix);
  context->color_range = colour_of_avc1.full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  context->max_b_frames = 0;
  context->thread_count = 1;
  // Global header: parameter sets go to extradata, where avc_record finds them.
  context->flags |= AV_CODEC_FLAG_CLOSED_GOP | AV_CODEC_FLAG_GLOBAL_HEADER;
  // Pictures are texture for a surface: codes near the truth count, not the look of one frame. At the same
  // PSNR of the foreground this tuning saves about a tenth of the bytes. medium holds 25 frames/s on one
  // core.
  set_option(context.get(), "preset", "medium");
  set_option(context.get(), "tune", "psnr");
  set_option(context.get(), "profile", "high");
  set_option(context.get(), "crf", std::to_string(settings.quality).c_str());
  set_option(context.get(), "x264-params", x264_parameters);
  const int code = avcodec_open2(context.get(), codec, nullptr);
  if (code < 0) fail("libx264 refuses the settings", code);
  return context;
}

void copy_plane(AVFrame *frame, int plane, const std::vector<uint8_t> &samples, size_t width) {
  const size_t stride = size_t(frame->linesize[plane]);
  for (size_t row = 0; row * width < samples.size(); row++)
    memcpy(frame->data[plane] + row * stride, &samples[row * width], width);
}

AvFrame make_picture(const AVCodecContext *context, const Image &image, int64_t index) {
  const Frame yuv = to_yuv(image, colour_of_avc1);
  AvFrame frame = make_frame();
  frame->format = AV_PIX_FMT_YUV420P;
  frame->width = context->width;
  frame->height = context->height;
  const int code = av_frame_get_buffer(frame.get(), 0);
  if (code < 0) fail("a frame cannot be made", code);
  copy_plane(frame.get(), 0, yuv.y, yuv.width);
  copy_plane(frame.get(), 1, yuv.u, yuv.width / 2);
  copy_plane(frame.get(), 2, yuv.v, yuv.width / 2);
  frame->pts = index;
  return frame;
}

void receive_samples(AVCodecContext *context, AVPacket *packet, std::vector<Sample> &samples) {
  int code;
  while ((code = avcodec_receive_packet(context, packet)) >= 0) {
    if (packet->pts != int64_t(samples.size()) || packet->size <= 0)
      throw Error("libx264 gave frame " + std::to_string(packet->pts) + " in place of frame " +
                  std::to_string(samples.size()));
    samples.push_back(
        {avc_sample(packet->data, size_t(packet->size)), (packet->flags & AV_PKT_FLAG_KEY) != 0});
    av_packet_unref(packet);
  }
  if (code != AVERROR(EAGAIN) && code != AVERROR_EOF) fail("libx264 cannot encode", code);
}

EncodedGroup encode_avc_group(const VideoSettings &settings, const std::vector<Image> &frames) {
  const Context context = open_encoder(settings);
  EncodedGroup group;
  group.record = avc_record(context->extradata, size_t(context->extradata_size));
  group.codec_string = avc_codec_string(group.record);
  const Packet packet = make_packet();
  for (size_t i = 0; i < frames.size(); i++) {
    const AvFrame picture = make_picture(context.get(), frames[i], int64_t(i));
    const int code = avcodec_send_frame(context.get(), picture.get());
    if (code < 0) fail("libx264 cannot encode frame " + std::to_string(i), code);
    receive_samples(context.get(), packet.get(), group.samples);
  }
  const int code = avcodec_send_frame(context.get(), nullptr);
  if (code < 0) fail("libx264 cannot finish the group", code);
  receive_samples(context.get(), packet.get(), group.samples);
  if (group.samples.size() != frames.size())
    throw Error("libx264 gave " + std::to_string(group.samples.size()) + " samples for " +
                std::to_string(frames.size()) + " frames");
  for (size_t i = 0; i < group.samples.size(); i++)
    if (avc_check_sample(group.samples[i].bytes.data(), group.samples[i].bytes.size()) != (i == 0))
      throw Error("libx264 gave a group with an IDR picture missing or in the wrong place, at frame " +
                  std::to_string(i));
  return group;
}

[[noreturn]] void refuse_codec() {
  throw Error("the codec is neither JPEG nor H.264 (avc1)");
}

} // namespace

Colour colour_of_codec(uint32_t codec) {
  if (codec == FVV_CODEC_JPEG) return colour_of_jpeg;
  if (codec == FVV_CODEC_AVC1) return colour_of_avc1;
  refuse_codec();
}

EncodedGroup encode_group(const VideoSettings &settings, const std::vector<Image> &frames) {
  check_settings(settings, frames);
  if (settings.codec == FVV_CODEC_JPEG) return encode_jpeg_group(settings, frames);
  if (settings.codec == FVV_CODEC_AVC1) return encode_avc_group(settings, frames);
  refuse_codec();
}

fvv_video_config config_of(const VideoSettings &settings, const EncodedGroup &group) {
  const Colour colour = colour_of_codec(settings.codec);
  fvv_video_config config = {};
  config.codec = settings.codec;
  config.width = settings.width;
  config.height = settings.height;
  config.shows = FVV_SHOWS_TILES;
  config.bit_depth = 8;
  config.camera_id = FVV_NO_CAMERA;
  config.colour_primaries = colour.primaries;
  config.transfer_characteristics = colour.transfer;
  config.matrix_coefficients = colour.matrix;
  config.full_range = colour.full_range;
  config.record = group.record.data();
  config.record_size = group.record.size();
  config.codec_string = group.codec_string.data();
  config.codec_string_size = group.codec_string.size();
  return config;
}

} // namespace fvv::media
