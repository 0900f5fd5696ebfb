// The data tracks of a stream: their payloads as they were sent.
#pragma once

#include "fvv/stream.h"
#include "fvv_cxx/input_file.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace fvv::demux {

// Media types of files and the opposite. Of a type that is not known the codec is the extension.
struct DataType {
  std::string media_type, codec;
};
DataType data_type_of(const std::string &extension);
std::string data_extension(const DataType &type);

// A payload of a data track. The name is that of the track; number counts the payloads of the track from 0.
struct UnpackedData {
  uint16_t track = 0;
  std::string name;
  DataType type;
  uint64_t number = 0;
  int64_t time = 0; // ticks of the scene
  const uint8_t *payload = nullptr;
  size_t size = 0; // borrowed up to the return
};

// Gives the payloads of groups first to last of a file in their order; of alternatives those of the best.
// Returns what is damaged, for people; the rest is there.
std::vector<std::string> unpack_data(const InputFile &file, size_t first, size_t last,
                                     const std::function<void(const UnpackedData &)> &take);

} // namespace fvv::demux
