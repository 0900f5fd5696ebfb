#include "fvv_demux/data.h"

#include "fvv_cxx/error.h"
#include "fvv_demux/frame_plan.h"

#include <algorithm>
#include <map>

namespace fvv::demux {

namespace {

struct MediaType {
  const char *media_type, *extension;
};
constexpr MediaType media_types[] = {{"text/vtt", "vtt"},         {"model/gltf-binary", "glb"},
                                     {"model/gltf+json", "gltf"}, {"application/json", "json"},
                                     {"text/plain", "txt"},       {"image/jpeg", "jpg"},
                                     {"image/png", "png"}};

} // namespace

DataType data_type_of(const std::string &extension) {
  for (const MediaType &known : media_types)
    if (extension == known.extension) return {known.media_type, ""};
  return {"application/octet-stream", extension};
}

// A codec is a word of the stream: of a file name it may have no more than letters and digits.
std::string data_extension(const DataType &type) {
  const std::string &codec = type.codec;
  for (const MediaType &known : media_types)
    if (type.media_type == known.media_type) return known.extension;
  const bool plain =
      !codec.empty() && codec.size() <= 8 && std::all_of(codec.begin(), codec.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
      });
  return plain ? codec : "bin";
}

std::vector<std::string> unpack_data(const InputFile &input, size_t first, size_t last,
                                     const std::function<void(const UnpackedData &)> &take) {
  std::vector<std::string> losses;
  const Stream stream = open_stream(input, nullptr);
  const fvv_configuration *configuration = nullptr;
  if (fvv_stream_configuration(stream.get(), first, &configuration, nullptr) != FVV_OK) return losses;
  std::map<uint16_t, UnpackedData> tracks;
  for (size_t i = 0; i < configuration->data_count; i++) {
    const fvv_data_layout &layout = configuration->datas[i];
    const fvv_track *track = fvv_configuration_track(configuration, layout.track);
    if (!track || track->rank) continue;
    UnpackedData &data = tracks[layout.track];
    data.track = layout.track;
    data.name.assign(track->name, track->name_size);
    data.type.media_type.assign(layout.config.media_type, layout.config.media_type_size);
    data.type.codec.assign(layout.config.codec, layout.config.codec_size);
  }
  for (size_t group = first; group <= last && group < fvv_stream_group_count(stream.get()); group++) {
    const fvv_chunk_info *chunks = nullptr;
    size_t count = 0;
    fvv_diagnostic diagnostic = {};
    if (fvv_stream_group_chunks(stream.get(), group, &chunks, &count, &diagnostic) < 0) {
      losses.push_back("data are lost: " + text_of(diagnostic));
      continue;
    }
    for (size_t i = 0; i < count; i++) {
      const auto found = tracks.find(chunks[i].track);
      if (chunks[i].type != FVV_CHUNK_DATA || found == tracks.end()) continue;
      UnpackedData &data = found->second;
      data.time = chunks[i].time;
      data.size = size_t(chunks[i].size);
      diagnostic = {};
      if (fvv_stream_read_chunk(stream.get(), &chunks[i], &data.payload, &diagnostic) < 0)
        losses.push_back("data are lost: " + text_of(diagnostic));
      else
        take(data);
      data.number++;
    }
  }
  return losses;
}

} // namespace fvv::demux
