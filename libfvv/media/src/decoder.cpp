// Decoding sample by sample. See fvv_media/video.h.
#include "fvv_media/video.h"

#include "codecs.h"
#include "ffmpeg.h"

#include <algorithm>
#include <climits>
#include <cstring>
#include <iterator>
#include <utility>

namespace fvv::media {

class SampleDecoder {
public:
  virtual ~SampleDecoder() = default;
  virtual void decode(const uint8_t *bytes, size_t size, Image &out) = 0;
  virtual void decode(const uint8_t *bytes, size_t size, DeepImage &out) = 0;
  virtual void decode(const uint8_t *bytes, size_t size, LinearImage &out) {
    DeepImage display;
    decode(bytes, size, display);
    out = linear_of(display);
  }
};

namespace {

std::string size_text(uint32_t width, uint32_t height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

// A copy of a configuration, whose pointers are only borrowed.
struct Picture {
  uint32_t width, height;
  Colour colour;

  explicit Picture(const fvv_video_config &config)
      : width(config.width),
        height(config.height), colour{config.colour_primaries, config.transfer_characteristics,
                                      config.matrix_coefficients, config.full_range != 0} {
    check_dimensions(width, height, "a video frame");
    check_colour(colour);
  }

  void check_size(uint32_t found_width, uint32_t found_height) const {
    if (found_width != width || found_height != height)
      throw Error("the picture of a sample is " + size_text(found_width, found_height) +
                  ", its configuration says " + size_text(width, height));
  }
};

class JpegDecoder : public SampleDecoder {
public:
  using SampleDecoder::decode;
  explicit JpegDecoder(const fvv_video_config &config) : picture_(config) {
    if (config.record_size != 0) throw Error("JPEG video has a configuration record, expected none");
    if (config.matrix_coefficients == 1 || !config.full_range)
      throw Error("JPEG video must be BT.601 at full range (H.273 matrix 5 or 6): JFIF has no other");
  }

  void decode(const uint8_t *bytes, size_t size, Image &out) override { out = picture<uint8_t>(bytes, size); }
  void decode(const uint8_t *bytes, size_t size, DeepImage &out) override {
    out = picture<uint16_t>(bytes, size);
  }

private:
  template <class Wanted> BasicImage<Wanted> picture(const uint8_t *bytes, size_t size) const {
    const std::string name = "a JPEG sample";
    if (!is_jpeg(bytes, size)) throw Error("a JPEG sample does not begin with SOI");
    if (bytes[size - 2] != 0xff || bytes[size - 1] != 0xd9)
      throw Error("a JPEG sample does not end with EOI");
    const ImageInfo info = probe_jpeg(bytes, size, name);
    picture_.check_size(info.width, info.height);
    return decode_image<Wanted>(bytes, size, 3, name);
  }

  Picture picture_;
};

class ExrDecoder : public SampleDecoder {
public:
  explicit ExrDecoder(const fvv_video_config &config) : config_(config) {
    check_dimensions(config.width, config.height, "a video frame");
    if (config.record_size != 0) throw Error("OpenEXR video has a configuration record, expected none");
    const Colour &expected = colour_of_exr;
    if (config.colour_primaries != expected.primaries ||
        config.transfer_characteristics != expected.transfer ||
        config.matrix_coefficients != expected.matrix || !config.full_range)
      throw Error("OpenEXR video must be linear light of BT.709's primaries at full range (H.273: 1, 8, 0)");
    config_.record = nullptr;
    config_.codec_string = nullptr;
  }

  void decode(const uint8_t *bytes, size_t size, Image &out) override { display(bytes, size, out); }
  void decode(const uint8_t *bytes, size_t size, DeepImage &out) override { display(bytes, size, out); }
  void decode(const uint8_t *bytes, size_t size, LinearImage &out) override {
    fvv_diagnostic diagnostic;
    if (fvv_video_sample_check(&config_, 1, bytes, size, &diagnostic) != FVV_OK)
      throw Error(diagnostic.message);
    FloatImage file = decode_exr(bytes, size, "an OpenEXR sample");
    out.width = file.width;
    out.height = file.height;
    out.channels = 3;
    out.pixels = std::move(file.samples);
    check_finite(out, "an OpenEXR sample");
  }

private:
  template <class Wanted> void display(const uint8_t *bytes, size_t size, BasicImage<Wanted> &out) {
    LinearImage linear;
    decode(bytes, size, linear);
    out = display_of<Wanted>(linear);
  }

  fvv_video_config config_;
};

// A decoder of libavcodec, and whether the record is its extradata: VP9's record has nothing that it needs.
struct Library {
  uint32_t codec;
  const char *name;
  bool takes_record;
};
constexpr Library libraries[] = {{FVV_CODEC_AVC1, "h264", true},
                                 {FVV_CODEC_HVC1, "hevc", true},
                                 {FVV_CODEC_VP09, "vp9", false},
                                 {FVV_CODEC_AV01, "libdav1d", true}};

class VideoDecoder : public SampleDecoder {
public:
  using SampleDecoder::decode;
  explicit VideoDecoder(const fvv_video_config &config)
      : picture_(config), codec_(find_video_codec(config.codec)->name), config_(config) {
    check_record();
    const Library &library = *std::find_if(std::begin(libraries), std::end(libraries),
                                           [&](const Library &one) { return one.codec == config.codec; });
    quiet_log();
    clear_log();
    const AVCodec *codec = avcodec_find_decoder_by_name(library.name);
    if (!codec) throw Error(std::string("this build of FFmpeg has no decoder ") + library.name);
    context_ = make_decoder_context(codec);
    if (library.takes_record) {
      context_->extradata =
          static_cast<uint8_t *>(av_mallocz(config.record_size + AV_INPUT_BUFFER_PADDING_SIZE));
      if (!context_->extradata) throw std::bad_alloc();
      memcpy(context_->extradata, config.record, config.record_size);
      context_->extradata_size = int(config.record_size);
    }
    context_->flags |= AV_CODEC_FLAG_LOW_DELAY;
    // Headers may announce more than the configuration; coded sizes are whole blocks, of up to 64 pixels.
    context_->max_pixels = (int64_t(config.width) + 64) * (int64_t(config.height) + 64);
    const int code = avcodec_open2(context_.get(), codec, nullptr);
    if (code < 0) fail("the " + codec_ + " record cannot be used", code);
    packet_ = make_packet();
    frame_ = make_frame();
    // Borrowed, and no longer needed.
    config_.record = nullptr;
    config_.codec_string = nullptr;
  }

  void decode(const uint8_t *bytes, size_t size, Image &out) override { out = picture<uint8_t>(bytes, size); }
  void decode(const uint8_t *bytes, size_t size, DeepImage &out) override {
    out = picture<uint16_t>(bytes, size);
  }

private:
  template <class Wanted> BasicImage<Wanted> picture(const uint8_t *bytes, size_t size) {
    // Until this sample was decoded: libavcodec would predict from an older picture without an error.
    const bool need_key = std::exchange(need_key_, true);
    int key;
    fvv_diagnostic diagnostic;
    if (fvv_video_sample_inspect(&config_, bytes, size, &key, &diagnostic) != FVV_OK)
      throw Error(diagnostic.message);
    if (need_key) {
      if (!key) throw Error("the first sample, or the first after a damaged one, is not a key");
      avcodec_flush_buffers(context_.get());
    }
    receive(bytes, size);
    BasicImage<Wanted> image = config_.bit_depth == Frame::bit_depth
                                   ? to_rgb<Wanted>(planes<uint8_t>(), picture_.colour)
                                   : to_rgb<Wanted>(planes<uint16_t>(), picture_.colour);
    need_key_ = false;
    return image;
  }

  void check_record() const {
    char text[FVV_CODEC_STRING_CAPACITY];
    fvv_diagnostic diagnostic;
    if (config_.record_size > INT_MAX / 2) throw Error("the " + codec_ + " record is too large");
    if (fvv_video_codec_string(config_.codec, config_.record, config_.record_size, text, &diagnostic) !=
        FVV_OK)
      throw Error(diagnostic.message);
  }

  void receive(const uint8_t *bytes, size_t size) {
    if (size > INT_MAX / 2) throw Error(sample() + " is too large");
    clear_log();
    av_packet_unref(packet_.get());
    int code = av_new_packet(packet_.get(), int(size));
    if (code < 0) fail(sample() + " cannot be held", code);
    memcpy(packet_->data, bytes, size);
    code = avcodec_send_packet(context_.get(), packet_.get());
    if (code < 0) fail(sample() + " is damaged", code);
    code = avcodec_receive_frame(context_.get(), frame_.get());
    if (code == AVERROR(EAGAIN)) throw Error(sample() + " gives no picture of its own");
    if (code < 0) fail(sample() + " is damaged", code);
    if (is_broken(*frame_)) throw Error(sample() + " is damaged: its picture is not whole");
    // libavcodec replaces a missing reference picture and only logs a message, for any err_recognition.
    if (log_has_error()) fail(sample() + " is damaged", 0);
    const AvFrame second = make_frame();
    if (avcodec_receive_frame(context_.get(), second.get()) >= 0)
      throw Error(sample() + " gives more than one picture");
  }

  void check_stated(const char *what, int stated, int unspecified, int expected) const {
    if (stated != unspecified && stated != expected)
      throw Error("the " + codec_ + " stream states " + what + " " + std::to_string(stated) +
                  " (ITU-T H.273), its configuration " + std::to_string(expected));
  }

  template <class SampleType> BasicFrame<SampleType> planes() const {
    constexpr int bits = BasicFrame<SampleType>::bit_depth;
    if (frame_->format != pixel_format(bits) && (bits > 8 || frame_->format != AV_PIX_FMT_YUVJ420P))
      throw Error("the " + codec_ + " stream is not 4:2:0 with " + std::to_string(bits) + " bits");
    picture_.check_size(uint32_t(frame_->width), uint32_t(frame_->height));
    // 5 and 6 are two names for one matrix.
    const auto one_name = [](int matrix) {
      return matrix == AVCOL_SPC_SMPTE170M ? AVCOL_SPC_BT470BG : matrix;
    };
    check_stated("matrix coefficients", one_name(frame_->colorspace), AVCOL_SPC_UNSPECIFIED,
                 one_name(picture_.colour.matrix));
    const bool full = frame_->color_range == AVCOL_RANGE_JPEG || frame_->format == AV_PIX_FMT_YUVJ420P;
    check_stated("full range", full, frame_->color_range == AVCOL_RANGE_UNSPECIFIED ? full : -1,
                 picture_.colour.full_range);
    BasicFrame<SampleType> out;
    out.width = picture_.width;
    out.height = picture_.height;
    const size_t chroma_width = (size_t(out.width) + 1) / 2, chroma_height = (size_t(out.height) + 1) / 2;
    copy(0, out.width, out.height, out.y);
    copy(1, chroma_width, chroma_height, out.u);
    copy(2, chroma_width, chroma_height, out.v);
    return out;
  }

  template <class SampleType>
  void copy(int plane, size_t width, size_t height, std::vector<SampleType> &out) const {
    out.resize(width * height);
    for (size_t row = 0; row < height; row++)
      memcpy(&out[row * width], frame_->data[plane] + ptrdiff_t(row) * frame_->linesize[plane],
             width * sizeof(SampleType));
  }

  std::string sample() const { return "the " + codec_ + " sample"; }

  Picture picture_;
  std::string codec_;
  fvv_video_config config_;
  Context context_;
  Packet packet_;
  AvFrame frame_;
  bool need_key_ = true;
};

} // namespace

uint64_t decoding_memory(const fvv_video_config &config) {
  const uint64_t pixels = uint64_t(config.width) * config.height;
  // Half floats as they are unpacked and converted, with four channels at most.
  if (config.codec == FVV_CODEC_OEXR) return pixels * (4 * sizeof(float) + 3 * sizeof(float));
  const uint64_t sample = config.bit_depth > 8 ? 2 : 1, rgb = pixels * 3 * sizeof(uint16_t);
  if (config.codec == FVV_CODEC_JPEG) return pixels * 3 + rgb;
  // Reference pictures and the current one (spec/fvv.md clause 14), in whole blocks, 4:2:0.
  const bool of_itu = config.codec == FVV_CODEC_AVC1 || config.codec == FVV_CODEC_HVC1;
  const uint64_t coded = (uint64_t(config.width) + 64) * (uint64_t(config.height) + 64);
  return (of_itu ? 17 : 10) * (coded * 3 / 2 * sample) + pixels * 3 / 2 * sample + rgb;
}

Decoder::Decoder(const fvv_video_config &config) {
  const VideoCodec *codec = find_video_codec(config.codec);
  if (!codec) refuse_codec(config.codec);
  check_bit_depth(*codec, config.bit_depth);
  if (config.codec == FVV_CODEC_JPEG)
    decoder_ = std::make_unique<JpegDecoder>(config);
  else if (config.codec == FVV_CODEC_OEXR)
    decoder_ = std::make_unique<ExrDecoder>(config);
  else
    decoder_ = std::make_unique<VideoDecoder>(config);
}

Decoder::~Decoder() = default;
Decoder::Decoder(Decoder &&) noexcept = default;
Decoder &Decoder::operator=(Decoder &&) noexcept = default;

template <class SampleType> BasicImage<SampleType> Decoder::decode(const uint8_t *bytes, size_t size) {
  BasicImage<SampleType> out;
  decoder_->decode(bytes, size, out);
  return out;
}

template Image Decoder::decode(const uint8_t *, size_t);
template DeepImage Decoder::decode(const uint8_t *, size_t);
template LinearImage Decoder::decode(const uint8_t *, size_t);

} // namespace fvv::media
