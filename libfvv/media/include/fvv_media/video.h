// Groups of video frames: encoding a whole group, decoding sample by sample, choosing the quality. The codecs
// are JPEG and OpenEXR for each frame, H.264, HEVC, VP9 and AV1, with samples and records as fvv carries
// them.
#pragma once

#include "fvv/video.h"
#include "fvv_media/colour.h"
#include "fvv_media/image.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace fvv::media {

struct VideoCodec {
  uint32_t code;           // FVV_CODEC_...
  const char *option;      // "h264", for command lines
  const char *name;        // "H.264", for people
  const char *scale;       // what its quality numbers are: "quality" by libjpeg, or "CRF"
  int finest, coarsest;    // their ends: best picture, fewest bytes; OpenEXR has 0 alone, lossless
  int shallowest, deepest; // bits a sample: 8 and 8 or 10; 16, half floats, of OpenEXR

  // Every sample a file of its own: any frames may be encoded apart.
  bool is_stills() const { return code == FVV_CODEC_JPEG || code == FVV_CODEC_OEXR; }
};

// All codecs; JPEG first.
const std::vector<VideoCodec> &video_codecs();
// NULL when there is none with this code.
const VideoCodec *find_video_codec(uint32_t code);
// Of a unit of its scale: 8 of H.264 and HEVC, 1 of others, whose encoders know whole numbers only.
int parts_of_quality(uint32_t code);
// Error, with the reason, unless bit_depth is the codec's shallowest or deepest.
void check_bit_depth(const VideoCodec &codec, int bit_depth);

// Returns work() for a sample of the type that video is coded from: uint8_t, uint16_t (more than 8 bits) or
// float (OpenEXR).
template <class Work> auto with_sample_type(uint32_t codec, int bit_depth, const Work &work) {
  if (codec == FVV_CODEC_OEXR) return work(float());
  return bit_depth > 8 ? work(uint16_t()) : work(uint8_t());
}

// Time that an encoder takes for fewer bytes at the same PSNR: full is what an archive wants. By H.264's
// tiles at 38 dB, fast takes two thirds of full's time for 7 % more bytes, and live a sixth for 17 % more.
// least is for streams that would fall behind: its groups may follow those of live in a stream, with the same
// record; only H.264 has it, others are as live. JPEG and OpenEXR know one effort.
enum class Effort { least, live, fast, full };

struct VideoSettings {
  uint32_t codec;          // one of video_codecs()
  uint32_t width, height;  // of every frame; even but for stills, at least 16 for HEVC
  int quality;             // between finest and coarsest of the codec
  fvv_rational frame_rate; // as a time base: seconds per frame, 1/25 for 25 Hz
  int bit_depth = 8;       // the codec's shallowest or deepest
  // Not 0: the bits a second that a group may take. Its quality is then searched, from quality on. Not of
  // OpenEXR.
  uint64_t bit_rate = 0;
  // Where the codec can (H.264): in a fifth of the time, some tenths of a dB worse and a good part larger.
  // For searches.
  bool draft = false;
  // Added to quality towards fewer bytes, 0 <= parts < 1, in parts_of_quality.
  double parts = 0;
  Effort effort = Effort::full;
};

struct Sample {
  std::vector<uint8_t> bytes;
  bool key; // decodable with the record alone
};

struct EncodedGroup {
  std::vector<Sample> samples; // one per frame, in order; the first is a key
  std::vector<uint8_t> record; // as fvv_video_config has it; empty for stills
  std::string codec_string;    // RFC 6381, "avc1.640028"; empty for stills
  double quality = 0;          // that it has, with parts of the scale's units
  bool over_rate = false;      // even this, the coarsest quality, exceeds bit_rate
};

// A frame of a group, shared by all who keep it.
template <class SampleType> struct GroupFrame {
  std::shared_ptr<const BasicImage<SampleType>> image;
  std::shared_ptr<const Image> mask; // NULL, or grey: pixels > 127 count in a comparison (see compose_masks)
};

// Lives as long as whatever borrows it.
inline const std::vector<Image> no_masks;

// The frames of a group, or of several, each loaded when it is needed. load is called on the calling thread.
template <class SampleType> class GroupSource {
public:
  GroupSource(size_t frames, std::function<GroupFrame<SampleType>(size_t frame)> loader,
              std::function<std::shared_ptr<void>(uint64_t bytes)> room = {})
      : count(frames), load(std::move(loader)), reserve(std::move(room)) {}
  // Frames that are in memory, and stay there. masks: none, or one a frame, else Error.
  static GroupSource borrowed(const std::vector<BasicImage<SampleType>> &frames,
                              const std::vector<Image> &masks = no_masks);

  size_t count;
  std::function<GroupFrame<SampleType>(size_t frame)> load;
  std::vector<size_t> groups = {}; // frames of each, for encode_measured; none: all are of one
  // Called before each encoder opens, with the bytes of memory that it takes, about; may wait until there is
  // room. What it returns lives as long as the encoder. None: there is room.
  std::function<std::shared_ptr<void>(uint64_t bytes)> reserve;
};

// The bytes that bit_rate leaves to all samples of a group with that number of frames.
uint64_t rate_budget(const VideoSettings &settings, size_t frames);

// Code points that encode_group gives to a codec's pictures.
Colour colour_of_codec(uint32_t codec);

// One closed group of RGB frames. Loads every frame once, in order, and holds no more than one, but for VP9
// and with a bit_rate, which keep all of them, without masks and where they can as 4:2:0. A pure function:
// the same settings and frames give the same bytes, on one thread, without looking at other groups; the same
// settings give the same record and codec_string. JPEG: every sample a JFIF file, 4:2:0, every one a key.
// OpenEXR: every sample a file of encode_half_exr, every one a key.
// All others: 4:2:0, one sample a frame in the order of display, the first the only key; no frame is hidden
// in a sample. All keep the rules of fvv_video_sample_check.
// H.264 (libx264, High profile) and HEVC (libx265, Main, or Main 10): slices after 4-byte big-endian
// lengths; parameter sets are in the record only; no access unit delimiters, no SEI. VP9 (libvpx, profile
// 0, or 2 for 10 bits): one frame a sample. AV1 (libaom, Main): no temporal delimiters; the sequence header
// is in the record and the key. Images are coded with 8 bits, DeepImages with 10, LinearImages as OpenEXR:
// Error when settings say otherwise. With a bit_rate the group takes at most rate_budget: the finest quality
// that keeps it, or a few per cent less; JPEG mixes two neighbouring qualities. Two to six encodings, the
// fewer the better settings.quality was.
template <class SampleType>
EncodedGroup encode_group(const VideoSettings &settings, const GroupSource<SampleType> &frames);
template <class SampleType = uint8_t>
EncodedGroup encode_group(const VideoSettings &settings, const std::vector<BasicImage<SampleType>> &frames) {
  return encode_group(settings, GroupSource<SampleType>::borrowed(frames));
}

class SampleDecoder;

// The most bytes that decoding a track's samples takes: pictures that its codec keeps, the planes of the
// one that it gives, and that one as RGB of 16 bits. A sample of a few hundred bytes can demand all of it.
uint64_t decoding_memory(const fvv_video_config &config);

// Decodes the samples of a track in order. Movable; one per thread of decoding.
class Decoder {
public:
  // Copies what it needs of config. Error when the codec, depth, colour or record cannot be decoded. Takes up
  // to decoding_memory; who reads strangers' files checks that first.
  explicit Decoder(const fvv_video_config &config);
  ~Decoder();
  Decoder(Decoder &&) noexcept;
  Decoder &operator=(Decoder &&) noexcept;

  // One sample in, its RGB picture out, at once, in the primaries and transfer of config. The first sample
  // and the first after an Error must be a key; a key may come at any time (seeking). Error when the bytes
  // are malformed or damaged in any way the codec can see, when the picture has another size than config
  // says, or when the stream states another matrix or range than config does. Damage that a codec cannot see
  // (most flipped bits that still parse, a VP9 frame that ends early, a sample left out) is the container's
  // to find: CRC and continuity. SampleType uint8_t or uint16_t, for any depth of the video: 10 bits are
  // rounded to 8 once, at the end, and 8 bits are computed with 16 (JPEG, whose decoder gives 8: times 257).
  // float: linear light, of OpenEXR as it is, of others from 16 bits. OpenEXR as uint8_t or uint16_t is
  // clipped to 0 ... 1 and brought to the sRGB curve; a sample with a value that is not finite is damaged.
  template <class SampleType = uint8_t> BasicImage<SampleType> decode(const uint8_t *bytes, size_t size);

private:
  std::unique_ptr<SampleDecoder> decoder_;
};

// fvv_video_config that decodes group: pointers are into group. shows is FVV_SHOWS_TILES.
fvv_video_config config_of(const VideoSettings &settings, const EncodedGroup &group);

// A group and its PSNR against its frames.
struct MeasuredGroup {
  EncodedGroup group;
  double psnr = 0; // dB of luma, squared errors pooled over all frames
};

// The frames encoded as their groups, decoded and compared. Loads every frame twice. All have masks or none.
// The result has the samples of all groups.
template <class SampleType>
MeasuredGroup encode_measured(const VideoSettings &settings, const GroupSource<SampleType> &frames);

// The same at the cheapest quality that reaches target_db (settings.quality is ignored). Found by
// interpolation, two to six encodings; of H.264 two to six drafts and mostly one encoding: the next cheaper
// quality is not tried where the drafts leave no doubt. If no quality reaches target_db, the cheapest that is
// no more than 0.1 dB worse than the best: its psnr is below target_db. in_parts: with VideoSettings::parts,
// for one or two more encodings.
template <class SampleType>
MeasuredGroup choose_quality(const VideoSettings &settings, const GroupSource<SampleType> &frames,
                             double target_db, bool in_parts = false);
template <class SampleType = uint8_t>
MeasuredGroup choose_quality(const VideoSettings &settings, const std::vector<BasicImage<SampleType>> &frames,
                             double target_db, const std::vector<Image> &masks = {}) {
  return choose_quality(settings, GroupSource<SampleType>::borrowed(frames, masks), target_db);
}

} // namespace fvv::media
