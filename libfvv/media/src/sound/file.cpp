// The sound of files: packets that are passed on, or samples that are encoded.
#include "fvv_media/sound.h"
#include "media/src/demuxer.h"
#include "media/src/sound/frames.h"

extern "C" {
#include <libavcodec/bsf.h>
#include <libavutil/intreadwrite.h>
}

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace fvv::media {

namespace {

// Below, a second of sound at 48 kHz would come from a few bytes of a file.
constexpr uint32_t least_rate = 1000, most_rate = 768000;
constexpr int64_t longest_gap = int64_t(3600); // seconds of silence that may be put in

// Samples of an Opus packet at 48 kHz (RFC 6716 clause 3.1); 0 for none.
uint32_t opus_duration(const AVPacket &packet) {
  const uint32_t configuration = packet.data[0] >> 3, code = packet.data[0] & 3;
  constexpr uint32_t silk[] = {480, 960, 1920, 2880}, hybrid[] = {480, 960}, celt[] = {120, 240, 480, 960};
  const uint32_t frame = configuration < 12   ? silk[configuration & 3]
                         : configuration < 16 ? hybrid[configuration & 1]
                                              : celt[configuration & 3];
  const uint32_t count = code == 0 ? 1 : code < 3 ? 2 : packet.size > 1 ? packet.data[1] & 63 : 0;
  return frame * count <= 5760 ? frame * count : 0;
}

class Filter {
public:
  Filter(const char *name, const AVCodecParameters &parameters, AVRational time_base) {
    const AVBitStreamFilter *filter = av_bsf_get_by_name(name);
    int code = filter ? av_bsf_alloc(filter, &context_) : AVERROR_BSF_NOT_FOUND;
    if (code >= 0) code = avcodec_parameters_copy(context_->par_in, &parameters);
    if (code >= 0) {
      context_->time_base_in = time_base;
      code = av_bsf_init(context_);
    }
    if (code >= 0) return;
    av_bsf_free(&context_);
    fail(std::string("the filter ") + name + " of FFmpeg cannot be used", code);
  }
  Filter(const Filter &) = delete;
  ~Filter() { av_bsf_free(&context_); }

  // In place. false: the packet is not as the filter expects.
  bool apply(AVPacket *packet) {
    return av_bsf_send_packet(context_, packet) >= 0 && av_bsf_receive_packet(context_, packet) >= 0;
  }

private:
  AVBSFContext *context_ = nullptr;
};

class SoundFile {
public:
  SoundFile(const std::string &path, const SoundRequest &request)
      : path_(path), request_(request), demuxer_(path, Demuxer::sound, request.stream) {
    const AVStream &stream = demuxer_.stream();
    info_ = {avcodec_get_name(stream.codecpar->codec_id), uint32_t(std::max(stream.codecpar->sample_rate, 0)),
             uint32_t(std::max(stream.codecpar->ch_layout.nb_channels, 0))};
    if (!avcodec_find_decoder(stream.codecpar->codec_id))
      throw Error(path_, std::string("this build of FFmpeg has no decoder for ") + info_.codec);
    if (info_.rate < least_rate || info_.rate > most_rate || !info_.channels || info_.channels > 64)
      throw Error(path_, "has sound of " + std::to_string(info_.channels) + " channels at " +
                             std::to_string(info_.rate) + " Hz, expected 1 to 64 channels at " +
                             std::to_string(least_rate) + " to " + std::to_string(most_rate) + " Hz");
    if (stream.time_base.num <= 0 || stream.time_base.den <= 0)
      throw Error(path_, "has the time base " + std::to_string(stream.time_base.num) + "/" +
                             std::to_string(stream.time_base.den) + ", expected a number > 0");
    first_picture_ = demuxer_.first_picture();
    zero_ = first_picture_.value_or(0);
  }

  const SoundInfo &info() const { return info_; }

  // The packets of the file, if they can be passed on; otherwise nothing; why: a warning, if that is unusual.
  std::optional<SoundPackets> pass_on(std::string &why) {
    const AVStream &stream = demuxer_.stream();
    const AVCodecParameters &codec = *stream.codecpar;
    const bool is_opus = codec.codec_id == AV_CODEC_ID_OPUS;
    if (!is_opus && codec.codec_id != AV_CODEC_ID_AAC) return {};
    if (!is_opus && codec.profile != FF_PROFILE_AAC_LOW && codec.profile != FF_PROFILE_UNKNOWN) return {};
    if (info_.channels > max_sound_channels) return {};
    SoundPackets out;
    SoundFormat &format = out.format;
    format.codec = is_opus ? SoundCodec::opus : SoundCodec::aac;
    format.rate = is_opus ? opus_rate : info_.rate;
    format.channels = info_.channels;
    format.record.assign(codec.extradata, codec.extradata + codec.extradata_size);
    std::optional<Filter> filter;
    if (!is_opus && format.record.empty()) filter.emplace("aac_adtstoasc", codec, stream.time_base);
    const Packet packet = make_packet();
    int64_t expected = 0; // time of the next packet
    size_t count = 0;     // of those read
    std::vector<std::vector<uint8_t>> first;
    int64_t from = 0, to = 0;
    for (; demuxer_.read(packet.get()); count++) {
      if (filter && !filter->apply(packet.get())) return {};
      if (packet->pts == AV_NOPTS_VALUE || !is_in_range(packet->pts)) return {};
      if (!count) {
        // What an encoder put before the sound (iTunes says how much) is before the first sample.
        if (!first_picture_ && !is_opus)
          zero_ =
              packet->pts + av_rescale_q(skipped_samples(*packet), {1, int(format.rate)}, stream.time_base);
        if (filter) take_record(*packet, format);
        if (!set_format(*packet, format)) return {};
        out.start = expected = first_time(packet->pts, format);
        from = int64_t(std::floor(request_.from * format.rate)) -
               int64_t(format.preroll) * format.packet_duration;
        to = int64_t(std::ceil(request_.to * format.rate));
      }
      if (std::llabs(time_of(packet->pts, format.rate) - expected) > tolerance(format.rate)) {
        return {};
      }
      if ((is_opus && opus_duration(*packet) != format.packet_duration) || packet->size > 65535) {
        why = "has packets of several durations, so its sound is encoded again";
        return {};
      }
      if (first.size() < 8) first.emplace_back(packet->data, packet->data + packet->size);
      const int64_t begin = expected;
      expected += format.packet_duration;
      if (begin >= to) {
        out.goes_on = begin > to + format.rate / 10;
        if (out.goes_on) break;
        continue;
      }
      if (expected <= from) continue;
      if (out.packets.empty()) {
        const auto requested = int64_t(request_.from * format.rate);
        const int64_t delay =
            is_opus ? format.delay() : format.packet_duration; // of AAC: as most encoders have it
        out.before = double(std::max<int64_t>(requested - (out.start + delay), 0)) / format.rate;
        out.start = begin;
      }
      out.packets.emplace_back(packet->data, packet->data + packet->size);
    }
    if (!count) throw Error(path_, "holds no sound");
    if (!decodes(format, first)) return {};
    return out;
  }

  SoundPackets encode() {
    const AVStream &stream = demuxer_.stream();
    const uint32_t channels = std::min({info_.channels, request_.max_channels, max_sound_channels});
    OpusEncoder encoder(channels, request_.bit_rate);
    SampleConverter converter(channels, opus_rate, true);
    open_decoder();
    const Packet packet = make_packet();
    const AvFrame frame = make_frame();
    std::vector<float> samples;
    // Samples at 48 kHz: of the part that is wanted, and of what was decoded.
    const int64_t from = std::llround(request_.from * opus_rate), to = std::llround(request_.to * opus_rate);
    std::optional<int64_t> start, first; // of the sound, of what is encoded
    int64_t at = 0;                      // of the next decoded sample
    int64_t heard = 0;                   // samples of the file, since its first
    bool drained = false, filled = false;
    const auto flush = [&] {
      const int64_t count = int64_t(samples.size() / channels);
      const int64_t skip = std::clamp<int64_t>(from - at, 0, count),
                    end = std::clamp<int64_t>(to - at, skip, count);
      if (end > skip) {
        if (!first) {
          // Silence, so that a packet begins where the requested part begins.
          encoder.add_silence(size_t((at + skip - from) % opus_packet));
          first = at + skip - (at + skip - from) % opus_packet;
        }
        encoder.add(samples.data() + skip * channels, size_t(end - skip) * channels);
      }
      at += count;
      samples.clear();
    };
    while (!(start && at > to + opus_rate / 10)) {
      clear_log();
      int code = avcodec_receive_frame(context_.get(), frame.get());
      if (code == AVERROR_EOF) break;
      if (code == AVERROR(EAGAIN)) {
        if (drained) break;
        drained = !demuxer_.read(packet.get());
        clear_log();
        code = avcodec_send_packet(context_.get(), drained ? nullptr : packet.get());
        if (code < 0 && code != AVERROR_EOF) fail(path_ + ": sound is damaged", code);
        continue;
      }
      if (code < 0) fail(path_ + ": sound is damaged", code);
      if (frame->nb_samples <= 0) continue;
      const int64_t pts = frame->pts != AV_NOPTS_VALUE ? frame->pts : frame->best_effort_timestamp;
      if (!start) {
        start = 0;
        if (first_picture_ && pts != AV_NOPTS_VALUE && is_in_range(pts)) {
          const int64_t time = time_of(pts, opus_rate), tick = tolerance(opus_rate) / 2;
          start = std::llabs(time) <= tick ? 0 : time;
        }
        at = *start;
        start_pts_ = pts;
      } else if (pts != AV_NOPTS_VALUE && start_pts_ != AV_NOPTS_VALUE) {
        if (!is_in_range(pts)) throw Error(path_, "has times of sound that are out of range");
        const int64_t rate = frame->sample_rate;
        const int64_t gap = av_rescale_q(pts - start_pts_, stream.time_base, {1, int(rate)}) - heard;
        if (gap < -rate / 20)
          throw Error(path_, "has sound whose times go back after " + seconds(heard, rate));
        if (gap > longest_gap * rate)
          throw Error(path_, "has sound with a gap of more than an hour after " + seconds(heard, rate));
        if (gap > rate / 20) {
          for (int64_t left = gap; left > 0; left -= rate) {
            converter.add_silence(std::min(left, rate), samples);
            flush();
          }
          heard += gap;
          filled = true;
        }
      }
      try {
        converter.add(*frame, samples);
      } catch (const Error &error) {
        throw Error(path_, error.what());
      }
      heard += frame->nb_samples;
      flush();
    }
    if (!start) throw Error(path_, "holds no sound");
    if (at < to) converter.finish(samples);
    flush();
    SoundPackets out = encoder.finish(first.value_or(0));
    out.before = double(std::max<int64_t>(from - *start, 0)) / opus_rate;
    out.goes_on = at > to + opus_rate / 10;
    if (filled) out.warnings.push_back("has gaps in its sound, which become silence");
    if (channels < info_.channels)
      out.warnings.push_back("has " + std::to_string(info_.channels) + " channels, which are mixed to " +
                             std::to_string(channels));
    return out;
  }

private:
  static bool is_in_range(int64_t pts) { return std::llabs(pts) < INT64_MAX / 4; }
  static std::string seconds(int64_t samples, int64_t rate) {
    return std::to_string(double(samples) / double(rate)) + " s";
  }

  int64_t time_of(int64_t pts, uint32_t rate) const {
    return av_rescale_q(pts - zero_, demuxer_.stream().time_base, {1, int(rate)});
  }
  // Of times that a container rounds to its ticks: two of them, and at least two samples.
  int64_t tolerance(uint32_t rate) const {
    const AVRational &tick = demuxer_.stream().time_base;
    return 2 * std::max<int64_t>(1, av_rescale_rnd(rate, tick.num, tick.den, AV_ROUND_UP));
  }

  int64_t first_time(int64_t pts, const SoundFormat &format) const {
    const int64_t time = time_of(pts, format.rate), delay = format.delay();
    return std::llabs(time + delay) <= tolerance(format.rate) ? -delay : time;
  }

  // At the beginning of a packet, that no player lets be heard.
  static int64_t skipped_samples(const AVPacket &packet) {
    size_t size = 0;
    const uint8_t *skipped = av_packet_get_side_data(&packet, AV_PKT_DATA_SKIP_SAMPLES, &size);
    return skipped && size >= 4 ? int64_t(AV_RL32(skipped)) : 0;
  }

  // Of ADTS, which has the values of the record in every packet.
  static void take_record(const AVPacket &packet, SoundFormat &format) {
    size_t size = 0;
    const uint8_t *record = av_packet_get_side_data(&packet, AV_PKT_DATA_NEW_EXTRADATA, &size);
    if (record) format.record.assign(record, record + size);
  }

  // false: not to be passed on.
  static bool set_format(const AVPacket &packet, SoundFormat &format) {
    if (format.codec == SoundCodec::aac) {
      format.packet_duration = 1024; // as decodes() confirms
      format.preroll = 2;
      return !format.record.empty();
    }
    if (format.record.size() < 19 || memcmp(format.record.data(), "OpusHead", 8)) return false;
    format.packet_duration = opus_duration(packet);
    if (!format.packet_duration) return false;
    constexpr uint32_t settles = opus_rate * 80 / 1000; // RFC 7845 clause 4.6
    format.preroll = (settles + format.packet_duration - 1) / format.packet_duration;
    return true;
  }

  // Whether packets are what their headers say: implicit SBR, for example, shows only in decoding.
  static bool decodes(const SoundFormat &format, const std::vector<std::vector<uint8_t>> &packets) {
    try {
      SoundDecoder decoder(format);
      std::vector<float> samples;
      for (const std::vector<uint8_t> &packet : packets) decoder.decode(packet, samples);
      return true;
    } catch (const Error &) {
      return false;
    }
  }

  void open_decoder() {
    const AVCodecParameters &parameters = *demuxer_.stream().codecpar;
    const AVCodec *codec = avcodec_find_decoder(parameters.codec_id);
    context_ = make_decoder_context(codec);
    int code = avcodec_parameters_to_context(context_.get(), &parameters);
    context_->pkt_timebase = demuxer_.stream().time_base;
    clear_log();
    if (code >= 0) code = avcodec_open2(context_.get(), codec, nullptr);
    if (code < 0) fail(path_ + ": cannot be decoded", code);
  }

  const std::string path_;
  const SoundRequest request_;
  Demuxer demuxer_;
  SoundInfo info_;
  std::optional<int64_t> first_picture_; // of a video file, in ticks of the stream of sound
  int64_t zero_ = 0;                     // the file's time 0, likewise
  int64_t start_pts_ = AV_NOPTS_VALUE;
  Context context_;
};

} // namespace

SoundInfo sound_info(const std::string &path, std::optional<uint32_t> stream) {
  SoundRequest request;
  request.stream = stream;
  return SoundFile(path, request).info();
}

SoundPackets load_sound(const std::string &path, const SoundRequest &request) {
  std::string why;
  if (!request.bit_rate)
    if (std::optional<SoundPackets> packets = SoundFile(path, request).pass_on(why))
      return std::move(*packets);
  SoundPackets out = SoundFile(path, request).encode();
  if (!why.empty()) out.warnings.push_back(why);
  return out;
}

} // namespace fvv::media
