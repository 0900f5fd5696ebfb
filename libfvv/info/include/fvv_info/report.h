// What is in a stream and whether it is whole, and the two ways to show it: fvvinfo and python -m fvv info
// print both from here.
#pragma once

#include "fvv/stream.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace fvv::info {

struct Options {
  bool check = false;  // decode meshes, check video samples
  bool chunks = false; // list every chunk
};

// The bytes of a stream, read from front to back. What read throws passes through inspect.
struct Input {
  std::string name;      // as the user wrote it
  bool seekable = false; // rewind works
  uint64_t size = 0;     // bytes in all: then those after the footer are not read; 0: not known
  std::function<size_t(uint8_t *, size_t)>
      read;                     // into a buffer of that many bytes; returns how many, 0 at the end
  std::function<bool()> rewind; // to the front; false: not possible
  // A second reading will hardly be needed; may be empty.
  std::function<void()> settle = {};
};

struct Chunk {
  uint64_t offset;
  fvv_chunk_header header;
  bool intact; // false: its payload is damaged, or its group is
};

struct CheckerDeleter {
  void operator()(fvv_checker *checker) const { fvv_checker_destroy(checker); }
};

struct Report {
  std::string name; // as the user wrote it
  Options options;
  std::unique_ptr<fvv_checker, CheckerDeleter> checker;
  std::vector<Chunk> chunks;  // with options.chunks
  bool has_index = false;     // there was an intact INDX chunk
  fvv_status status = FVV_OK; // the error that ended the reading

  const fvv_check_summary &summary() const { return *fvv_checker_summary(checker.get()); }
  const fvv_configuration *configuration() const { return fvv_checker_configuration(checker.get()); }
  // "complete", "truncated", "damaged" or "unreadable".
  const char *integrity() const;
};

// Reads an input to its end; twice where a configuration block is repeated after damage. Throws
// std::bad_alloc.
Report inspect(const Input &input, const Options &options);

std::string type_name(uint32_t four_character_code);
std::string codec_name(uint32_t codec);
const char *kind_name(uint8_t track_kind);
const char *lens_name(uint8_t lens);
const char *up_name(uint8_t up_axis);

// Pixels of a video frame with tiles over those of all pictures of its cameras; more than 1 where pictures
// are enlarged.
double pixel_share(const Report &report, const fvv_video_layout &video);

// One screen for people.
std::string text(const Report &report);
// One element of "files" in spec/fvvinfo.schema.json.
nlohmann::ordered_json json(const Report &report);
// The document of that schema, without a line's end.
std::string document(const std::vector<nlohmann::ordered_json> &files);

} // namespace fvv::info
