// The table of video codecs, and their samples and configuration records made of what libavcodec's encoders
// give.
#include "codecs.h"

#include "fvv_cxx/error.h"
#include "fvv_media/exr.h"
#include "fvv_media/video.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace fvv::media {

const std::vector<VideoCodec> &video_codecs() {
  // CRF 0 would be lossless in libx264, libvpx and libaom: another profile, which browsers need not know.
  static const std::vector<VideoCodec> all = {{FVV_CODEC_JPEG, "jpeg", "JPEG", "quality", 100, 1, 8, 8},
                                              {FVV_CODEC_AVC1, "h264", "H.264", "CRF", 1, 51, 8, 8},
                                              {FVV_CODEC_HVC1, "hevc", "HEVC", "CRF", 1, 51, 8, 10},
                                              {FVV_CODEC_VP09, "vp9", "VP9", "CRF", 1, 63, 8, 10},
                                              {FVV_CODEC_AV01, "av1", "AV1", "CRF", 1, 63, 8, 10},
                                              {FVV_CODEC_OEXR, "exr", "OpenEXR", "quality", 0, 0, 16, 16}};
  return all;
}

const VideoCodec *find_video_codec(uint32_t code) {
  for (const VideoCodec &codec : video_codecs())
    if (codec.code == code) return &codec;
  return nullptr;
}

void check_bit_depth(const VideoCodec &codec, int bit_depth) {
  if (bit_depth == codec.shallowest || bit_depth == codec.deepest) return;
  const char *why = codec.deepest > 8 ? ""
                    : codec.code == FVV_CODEC_JPEG
                        ? ": a baseline file has no more"
                        : ": browsers do not decode High 10; HEVC, VP9 and AV1 have 10 bits";
  throw Error("the video has " + std::to_string(bit_depth) + " bits a sample, expected " +
              std::to_string(codec.shallowest) +
              (codec.deepest > codec.shallowest ? " or " + std::to_string(codec.deepest) : "") + " for " +
              codec.name + why);
}

void refuse_codec(uint32_t code) {
  std::string text = "the video's codec ";
  for (int shift = 0; shift < 32; shift += 8) {
    const char c = char(code >> shift & 255);
    text += c >= 0x20 && c <= 0x7e ? c : '?';
  }
  text += " is none of";
  for (const VideoCodec &codec : video_codecs()) text += std::string(" ") + codec.name;
  throw Error(text);
}

Colour colour_of_codec(uint32_t code) {
  if (!find_video_codec(code)) refuse_codec(code);
  return code == FVV_CODEC_JPEG ? colour_of_jpeg : code == FVV_CODEC_OEXR ? colour_of_exr : colour_of_video;
}

namespace {

// The units of an Annex B stream for which keep(first header byte) holds. ITU-T H.264 clause B.1, H.265
// clause B.2: units are between start codes 00 00 01; zeros before one belong to no unit.
std::vector<Bytes> annex_b_units(const uint8_t *bytes, size_t size,
                                 const std::function<bool(uint8_t)> &keep) {
  std::vector<Bytes> units;
  const uint8_t start[] = {0, 0, 1};
  const uint8_t *const end = bytes + size;
  const uint8_t *code = std::search(bytes, end, start, start + 3);
  while (code != end) {
    const uint8_t *unit = code + 3;
    code = std::search(unit, end, start, start + 3);
    const uint8_t *last = code;
    while (last > unit && last[-1] == 0) last--;
    if (last > unit && keep(unit[0])) units.emplace_back(unit, last);
  }
  return units;
}

// Units one after the other, each after its length in length_bytes bytes, big-endian.
void append_units(Bytes &out, const std::vector<Bytes> &units, unsigned length_bytes) {
  for (const Bytes &unit : units) {
    for (unsigned i = length_bytes; i-- > 0;) out.push_back(uint8_t(uint64_t(unit.size()) >> 8 * i));
    out.insert(out.end(), unit.begin(), unit.end());
  }
}

// The one parameter set of a kind. Error, by the name "HEVC encoder ... VPS", when there is not exactly one
// of least to 65535 bytes.
const Bytes &only_set(const std::vector<Bytes> &sets, size_t least, const std::string &name) {
  if (sets.size() != 1 || sets[0].size() < least || sets[0].size() > 0xffff)
    throw Error("the encoder gave " + std::to_string(sets.size()) + " " + name +
                ", expected one, of at least " + std::to_string(least) + " bytes");
  return sets[0];
}

// nal_unit_type, ITU-T H.264 table 7-1.
enum class Nal : uint8_t { slice = 1, idr_slice = 5, sps = 7, pps = 8 };

Nal avc_type_of(uint8_t header) {
  return Nal(header & 31);
}

std::vector<Bytes> units_of(const Bytes &annex_b, Nal type) {
  return annex_b_units(annex_b.data(), annex_b.size(),
                       [&](uint8_t header) { return avc_type_of(header) == type; });
}

Bytes avc_sample(const uint8_t *packet, size_t size) {
  Bytes out;
  append_units(out,
               annex_b_units(packet, size,
                             [](uint8_t header) {
                               return avc_type_of(header) == Nal::slice ||
                                      avc_type_of(header) == Nal::idr_slice;
                             }),
               4);
  return out;
}

Bytes avc_record(const VideoSettings &, const Bytes &header, const Bytes &) {
  const std::vector<Bytes> sequence = units_of(header, Nal::sps), picture = units_of(header, Nal::pps);
  const Bytes &sps = only_set(sequence, 4, "sequence parameter sets of H.264");
  only_set(picture, 2, "picture parameter sets of H.264");
  // Version; profile, compatibility, level; 4-byte lengths; how many sets. Reserved bits are ones.
  Bytes out = {1, sps[1], sps[2], sps[3], 0xff, 0xe1};
  append_units(out, sequence, 2);
  out.push_back(1);
  append_units(out, picture, 2);
  // From High profile on: 4:2:0, 8 bits, 8 bits, no extensions.
  if (sps[1] >= 100) out.insert(out.end(), {0xfd, 0xf8, 0xf8, 0});
  return out;
}

} // namespace

const Bitstream avc_bitstream = {avc_sample, avc_record};

namespace {

// nal_unit_type, ITU-T H.265 table 7-1.
constexpr unsigned vcl_last = 31, hevc_vps = 32, hevc_sps = 33, hevc_pps = 34;

unsigned hevc_type_of(uint8_t header) {
  return header >> 1 & 63u;
}

Bytes hevc_sample(const uint8_t *packet, size_t size) {
  Bytes out;
  append_units(
      out, annex_b_units(packet, size, [](uint8_t header) { return hevc_type_of(header) <= vcl_last; }), 4);
  return out;
}

// Without the emulation prevention bytes of clause 7.3.1.1.
Bytes payload_of(const Bytes &unit) {
  Bytes out;
  for (size_t i = 0; i < unit.size(); i++)
    if (!(i >= 2 && unit[i] == 3 && unit[i - 1] == 0 && unit[i - 2] == 0)) out.push_back(unit[i]);
  return out;
}

// ISO/IEC 14496-15 clause 8.3.3.1. An SPS opens with a 2-byte header, a byte that ends with
// sps_max_sub_layers_minus1 (3 bits) and sps_temporal_id_nesting_flag, and the 12 bytes of
// profile_tier_level that the record repeats.
Bytes hevc_record(const VideoSettings &settings, const Bytes &header, const Bytes &) {
  std::vector<Bytes> sets[3];
  for (const unsigned type : {hevc_vps, hevc_sps, hevc_pps}) {
    sets[type - hevc_vps] = annex_b_units(header.data(), header.size(),
                                          [&](uint8_t first) { return hevc_type_of(first) == type; });
    only_set(sets[type - hevc_vps], 3, "parameter sets of HEVC of type " + std::to_string(type));
  }
  const Bytes sequence = payload_of(sets[hevc_sps - hevc_vps][0]);
  if (sequence.size() < 15)
    throw Error("the encoder gave an HEVC sequence parameter set of " + std::to_string(sequence.size()) +
                " bytes, expected at least 15");
  const unsigned layers = (sequence[2] >> 1 & 7u) + 1, nested = sequence[2] & 1u;
  Bytes out(sequence.begin() + 2, sequence.begin() + 15);
  out[0] = 1; // the version
  // No minimum of spatial segmentation; parallelism unknown; 4:2:0; depth of luma and chroma; frame rate not
  // given. Reserved bits are ones.
  const uint8_t depth = uint8_t(0xf8 | (settings.bit_depth - 8));
  out.insert(out.end(), {0xf0, 0, 0xfc, 0xfd, depth, depth, 0, 0});
  out.push_back(uint8_t(layers << 3 | nested << 2 | 3)); // 4-byte lengths
  out.push_back(3);
  for (const unsigned type : {hevc_vps, hevc_sps, hevc_pps}) {
    out.insert(out.end(), {uint8_t(0x80 | type), 0, 1}); // complete: none is in samples
    append_units(out, sets[type - hevc_vps], 2);
  }
  return out;
}

} // namespace

const Bitstream hevc_bitstream = {hevc_sample, hevc_record};

namespace {

// Levels of VP9 by their limits of luma samples a second, luma samples a picture, and the longer side
// (VP9 bitstream specification, annex A). Their limits of bit rate are left out: a group at constant quality
// does not know its rate before it is coded, and every group has the same record.
struct Vp9Level {
  uint8_t number;
  uint64_t rate, size;
  uint32_t side;
};
constexpr Vp9Level vp9_levels[] = {
    {10, 829440, 36864, 512},          {11, 2764800, 73728, 768},        {20, 4608000, 122880, 960},
    {21, 9216000, 245760, 1344},       {30, 20736000, 552960, 2048},     {31, 36864000, 983040, 2752},
    {40, 83558400, 2228224, 4160},     {41, 160432128, 2228224, 4160},   {50, 311951360, 8912896, 8384},
    {51, 588251136, 8912896, 8384},    {52, 1176502272, 8912896, 8384},  {60, 1176502272, 35651584, 16832},
    {61, 2353004544, 35651584, 16832}, {62, 4706009088, 35651584, 16832}};

uint8_t vp9_level(const VideoSettings &settings) {
  const uint64_t size = uint64_t(settings.width) * settings.height;
  // frame_rate is in seconds a frame.
  const double rate = double(size) * settings.frame_rate.denominator / settings.frame_rate.numerator;
  for (const Vp9Level &level : vp9_levels)
    if (size <= level.size && std::max(settings.width, settings.height) <= level.side &&
        rate <= double(level.rate))
      return level.number;
  throw Error("no level of VP9 has frames of " + std::to_string(settings.width) + " x " +
              std::to_string(settings.height) + " at this rate");
}

Bytes vp9_sample(const uint8_t *packet, size_t size) {
  return Bytes(packet, packet + size);
}

// Version and flags of the box; profile; bits, 4:2:0, range; colour; no initialisation data. The chroma
// position in the middle of four pixels has no code: 0, between left neighbours, is the nearest.
Bytes vp9_record(const VideoSettings &settings, const Bytes &, const Bytes &) {
  const Colour colour = colour_of_codec(settings.codec);
  return {1,
          0,
          0,
          0,
          uint8_t(settings.bit_depth > 8 ? 2 : 0),
          vp9_level(settings),
          uint8_t(settings.bit_depth << 4 | (colour.full_range ? 1 : 0)),
          colour.primaries,
          colour.transfer,
          colour.matrix,
          0,
          0};
}

} // namespace

const Bitstream vp9_bitstream = {vp9_sample, vp9_record};

namespace {

// obu_type, AV1 bitstream specification, clause 6.2.2.
constexpr unsigned sequence_header = 1, temporal_delimiter = 2;

struct Obu {
  unsigned type;
  const uint8_t *begin, *payload, *end;
};

// Clause 5.3. The encoder gives every OBU a size field.
std::vector<Obu> obus_of(const uint8_t *bytes, size_t size) {
  std::vector<Obu> out;
  const uint8_t *const end = bytes + size;
  for (const uint8_t *at = bytes; at < end;) {
    Obu obu = {at[0] >> 3 & 15u, at, at + (at[0] & 4 ? 2 : 1), nullptr};
    uint64_t length = 0;
    bool more = true;
    for (unsigned shift = 0; more && shift < 56 && obu.payload < end; shift += 7) {
      length |= uint64_t(*obu.payload & 127) << shift;
      more = *obu.payload++ & 128;
    }
    if (!(at[0] & 2) || more || length > uint64_t(end - obu.payload))
      throw Error("the encoder gave AV1 whose OBUs do not fill its packet");
    at = obu.end = obu.payload + length;
    out.push_back(obu);
  }
  return out;
}

Bytes av1_sample(const uint8_t *packet, size_t size) {
  Bytes out;
  for (const Obu &obu : obus_of(packet, size))
    if (obu.type != temporal_delimiter) out.insert(out.end(), obu.begin, obu.end);
  return out;
}

// The first fields of a sequence header, clause 5.5.1, from its most significant bit on.
unsigned bits(const Obu &obu, size_t first, size_t count) {
  unsigned value = 0;
  for (size_t i = first; i < first + count; i++) {
    if (i / 8 >= size_t(obu.end - obu.payload))
      throw Error("the encoder gave an AV1 sequence header that ends early");
    value = value << 1 | (obu.payload[i / 8] >> (7 - i % 8) & 1u);
  }
  return value;
}

// AV1CodecConfigurationRecord. seq_profile is bits 0 to 2; then still_picture, reduced_still_picture_header,
// timing_info_present_flag and initial_display_delay_present_flag, and operating_points_cnt_minus_1 (5 bits),
// all 0 as the encoder writes none; operating_point_idc (12 bits), seq_level_idx (5 bits), and seq_tier for
// levels above 7.
Bytes av1_record(const VideoSettings &settings, const Bytes &, const Bytes &first) {
  for (const Obu &obu : obus_of(first.data(), first.size())) {
    if (obu.type != sequence_header) continue;
    if (bits(obu, 0, 12) != 0)
      throw Error(
          "the encoder gave an AV1 sequence header that is not of Main profile with one operating point");
    const unsigned level = bits(obu, 24, 5), tier = level > 7 ? bits(obu, 29, 1) : 0;
    const unsigned high_bitdepth = settings.bit_depth > 8;
    // Marker and version; profile and level; tier, depth, not monochrome, 4:2:0, chroma position unknown.
    Bytes out = {0x81, uint8_t(level), uint8_t(tier << 7 | high_bitdepth << 6 | 0x0c), 0};
    out.insert(out.end(), obu.begin, obu.end);
    return out;
  }
  throw Error("the encoder gave AV1 without a sequence header");
}

} // namespace

const Bitstream av1_bitstream = {av1_sample, av1_record};

} // namespace fvv::media
