// video/: what is checked of an OpenEXR sample before a decoder sees it, on files made by hand.
#include "exact.h"

#include "base/bytes.h"
#include "base/layout.h"
#include "fvv/video.h"

#include "fvv_catch.h"

#include <functional>
#include <string>

namespace {

using bytes = std::vector<uint8_t>;

constexpr uint32_t width = 5, height = 40;

void put32(bytes &out, uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(uint8_t(value >> shift));
}

void put_text(bytes &out, const std::string &text) {
  out.insert(out.end(), text.begin(), text.end());
  out.push_back(0);
}

struct Attribute {
  std::string name, type;
  bytes value;
};

bytes words(std::initializer_list<uint32_t> values) {
  bytes out;
  for (const uint32_t value : values) put32(out, value);
  return out;
}

bytes channels(const std::vector<std::string> &names, uint32_t type = 1, uint32_t sampling = 1) {
  bytes out;
  for (const std::string &name : names) {
    put_text(out, name);
    for (const uint32_t value : {type, 0u, sampling, sampling}) put32(out, value);
  }
  out.push_back(0);
  return out;
}

// A file, of which tests change parts before it is put together.
struct File {
  uint32_t version = 2;
  std::vector<Attribute> attributes;
  uint32_t lines = 16;
  std::vector<bytes> blocks; // their data

  explicit File(int compression = 3, uint32_t lines_of_block = 16) : lines(lines_of_block) {
    const bytes window = words({0, 0, width - 1, height - 1}), one = words({0x3f800000});
    attributes = {{"channels", "chlist", channels({"B", "G", "R"})},
                  {"compression", "compression", {uint8_t(compression)}},
                  {"dataWindow", "box2i", window},
                  {"displayWindow", "box2i", window},
                  {"lineOrder", "lineOrder", {0}},
                  {"pixelAspectRatio", "float", one},
                  {"screenWindowCenter", "v2f", words({0, 0})},
                  {"screenWindowWidth", "float", one}};
    for (uint32_t first = 0; first < height; first += lines)
      blocks.push_back(bytes(compression ? 7 : width * 6, 0xaa));
  }
  Attribute &at(const std::string &name) {
    for (Attribute &attribute : attributes)
      if (attribute.name == name) return attribute;
    FAIL("no attribute " << name);
    return attributes[0];
  }
  bytes header() const {
    bytes out = {0x76, 0x2f, 0x31, 0x01};
    put32(out, version);
    for (const Attribute &attribute : attributes) {
      put_text(out, attribute.name);
      put_text(out, attribute.type);
      put32(out, uint32_t(attribute.value.size()));
      out.insert(out.end(), attribute.value.begin(), attribute.value.end());
    }
    out.push_back(0);
    return out;
  }
  bytes put_together() const {
    bytes out = header();
    uint32_t offset = uint32_t(out.size() + 8 * blocks.size());
    for (const bytes &block : blocks) {
      put32(out, offset);
      put32(out, 0);
      offset += uint32_t(8 + block.size());
    }
    for (size_t i = 0; i < blocks.size(); i++) {
      put32(out, uint32_t(i) * lines);
      put32(out, uint32_t(blocks[i].size()));
      out.insert(out.end(), blocks[i].begin(), blocks[i].end());
    }
    return out;
  }
};

fvv_video_config config() {
  fvv_video_config c = {};
  c.codec = FVV_CODEC_OEXR;
  c.width = width;
  c.height = height;
  c.shows = FVV_SHOWS_ATLAS;
  c.bit_depth = 16;
  c.colour_primaries = 1;
  c.transfer_characteristics = 8;
  c.full_range = 1;
  return c;
}

// The complaint about a sample, or "".
std::string complaint(const bytes &sample, size_t size, int key = 1, fvv_video_config c = config()) {
  const exact block(sample, size);
  fvv_diagnostic d;
  if (fvv_video_sample_check(&c, key, block.data(), size, &d) == FVV_OK) return "";
  REQUIRE(d.status == FVV_ERROR_INVALID);
  REQUIRE(d.issue == FVV_ISSUE_SAMPLE_OEXR);
  REQUIRE(d.chunk_type == FVV_CHUNK_VIDEO_PACKET);
  REQUIRE(d.offset <= size);
  return d.message;
}
std::string complaint(const bytes &sample) {
  return complaint(sample, sample.size());
}
std::string changed(const std::function<void(File &)> &change, int compression = 3, uint32_t lines = 16) {
  File file(compression, lines);
  change(file);
  return complaint(file.put_together());
}

} // namespace

TEST_CASE("OpenEXR samples in the lossless compressions are taken, and none in DWAA or DWAB") {
  constexpr uint32_t lines[] = {1, 0, 1, 16, 32, 0, 0, 0, 0, 0}; // 8 and 9: DWAA and DWAB
  for (int i = 0; i < 12; i++) {
    CAPTURE(i);
    const uint32_t of_block = i < 10 ? lines[i] : 0;
    const std::string text = complaint(File(i, of_block ? of_block : 16).put_together());
    CHECK(text ==
          (of_block ? "" : "OpenEXR compression is " + std::to_string(i) + ", expected 0, 2, 3 or 4"));
  }
}

TEST_CASE("every prefix of an OpenEXR sample and every longer one is refused") {
  for (const int compression : {0, 3, 4}) {
    bytes sample = File(compression, compression == 0 ? 1 : compression == 3 ? 16 : 32).put_together();
    for (size_t size = 0; size < sample.size(); size++) REQUIRE(complaint(sample, size) != "");
    REQUIRE(complaint(sample) == "");
    sample.push_back(0);
    CHECK(complaint(sample) == "OpenEXR file has 1 bytes after its last block");
  }
}

TEST_CASE("an OpenEXR sample is a key") {
  const bytes sample = File().put_together();
  CHECK(complaint(sample, sample.size(), 0) ==
        "OpenEXR sample is not marked as a key sample, expected every one to be");
}

TEST_CASE("kinds of OpenEXR files that are not for samples are refused by name") {
  const std::string flags = "expected 2: one part of scan lines, short names";
  for (const uint32_t flag : {0x200u, 0x400u, 0x800u, 0x1000u, 1u})
    CHECK(changed([&](File &f) { f.version |= flag; }).find(flags) != std::string::npos);
  CHECK(changed([](File &f) {
          f.attributes.push_back({"tiles", "tiledesc", bytes(9)});
        }) == "OpenEXR has tiles, expected scan lines");
  const auto type = [](const std::string &text) {
    return changed([&](File &f) { f.attributes.push_back({"type", "string", {text.begin(), text.end()}}); });
  };
  CHECK(type("scanlineimage") == "");
  CHECK(type("deepscanlines") == "OpenEXR type is not 'scanlineimage'");
  CHECK(type("deepscanline") == "OpenEXR attribute type is not a string of 13 bytes");
  CHECK(changed([](File &f) { f.at("lineOrder").value = {1}; }) == "OpenEXR line order is 1, expected 0");
}

TEST_CASE("OpenEXR channels are half B, G and R at every pixel") {
  const auto with = [](const bytes &list) {
    return changed([&](File &f) { f.at("channels").value = list; });
  };
  CHECK(with(channels({"A", "B", "G", "R"})) == "OpenEXR attribute channels is not a chlist of 55 bytes");
  CHECK(with(channels({"B", "G"})) == "OpenEXR attribute channels is not a chlist of 55 bytes");
  CHECK(with(channels({"B", "G", "Y"})) == "OpenEXR channel 2 is not R: expected B, G and R alone");
  CHECK(with(channels({"R", "G", "B"})) == "OpenEXR channel 0 is not B: expected B, G and R alone");
  CHECK(with(channels({"B", "G", "R"}, 2)) == "OpenEXR channel B is of type 2, expected 1 (half)");
  CHECK(with(channels({"B", "G", "R"}, 1, 2)) == "OpenEXR channel B is sampled 2 x 2, expected 1 x 1");
  CHECK(with(channels({"B", "G", "R"}, 1, 0)) == "OpenEXR channel B is sampled 0 x 0, expected 1 x 1");
  bytes open = channels({"B", "G", "R"});
  open.back() = 'Z';
  CHECK(with(open) == "OpenEXR has a channel after B, G and R");
}

TEST_CASE("OpenEXR windows are those of the configuration, however large") {
  for (const char *name : {"dataWindow", "displayWindow"}) {
    const auto with = [&](std::initializer_list<uint32_t> box) {
      return changed([&](File &f) { f.at(name).value = words(box); });
    };
    CHECK(with({0, 0, width - 1, height}) ==
          std::string("OpenEXR ") + name + " is (0, 0) to (4, 40), expected (0, 0) to (4, 39)");
    CHECK(with({1, 0, width, height - 1}) != "");
    CHECK(with({0, 0xffffffff, width - 1, height - 2}) != "");
    CHECK(with({0, 0, 0x7fffffff, 0x7fffffff}) != "");
    CHECK(with({0x80000000, 0x80000000, 0x7fffffff, 0x7fffffff}) != "");
  }
  // Sides that overflow 32 bits when they are multiplied.
  fvv_video_config c = config();
  File file;
  for (const uint32_t side : {0x7fffffffu, 0x80000000u, 0xffffffffu}) {
    c.width = c.height = side;
    file.at("dataWindow").value = file.at("displayWindow").value = words({0, 0, side - 1, side - 1});
    const bytes sample = file.put_together();
    CHECK(complaint(sample, sample.size(), 1, c) != "");
  }
  c.width = 0x7fffffff;
  c.height = height;
  file.at("dataWindow").value = file.at("displayWindow").value = words({0, 0, 0x7ffffffe, height - 1});
  const bytes sample = file.put_together();
  CHECK(complaint(sample, sample.size(), 1, c) == ""); // one line of a block may have 12 GiB, and has 7 bytes
}

TEST_CASE("OpenEXR attributes occur once, with their types, within the sample") {
  const std::vector<Attribute> needed = File().attributes;
  for (size_t i = 0; i < needed.size(); i++) {
    const std::string name = needed[i].name;
    CAPTURE(name);
    CHECK(changed([&](File &f) { f.attributes.erase(f.attributes.begin() + long(i)); }) ==
          "OpenEXR has no attribute " + name);
    CHECK(changed([&](File &f) { f.attributes.push_back(needed[i]); }) ==
          "OpenEXR has attribute " + name + " twice");
    CHECK(changed([&](File &f) {
            f.at(name).type = "double";
          }).find("OpenEXR attribute " + name + " is not") == 0);
    CHECK(changed([&](File &f) {
            f.at(name).value.push_back(0);
          }).find("OpenEXR attribute " + name + " is not") == 0);
  }
  const auto other = [](const std::string &name, const std::string &type) {
    return changed([&](File &f) { f.attributes.push_back({name, type, bytes(300)}); });
  };
  CHECK(other("comments", "string") == "");
  CHECK(other(std::string(31, 'n'), std::string(31, 't')) == "");
  const std::string unnamed = "OpenEXR attribute has no name and type of 1 to 31 bytes";
  CHECK(other(std::string(32, 'n'), "t") == unnamed);
  CHECK(other("n", std::string(32, 't')) == unnamed);
  CHECK(other("n", "") == unnamed);
  // A size that reaches beyond the sample, or below 0.
  bytes sample = File().put_together();
  const size_t size_of_first = 8 + 9 + 7;
  for (const uint32_t size : {0x7fffffffu, 0xffffffffu, 0x80000000u}) {
    fvv_put_u32(&sample[size_of_first], size);
    CHECK(complaint(sample).find("OpenEXR attribute has " + std::to_string(size) + " bytes") == 0);
  }
}

TEST_CASE("OpenEXR blocks follow each other in their order") {
  CHECK(changed([](File &f) { f.attributes.push_back({"chunkCount", "int", words({3})}); }) == "");
  CHECK(changed([](File &f) {
          f.attributes.push_back({"chunkCount", "int", words({4})});
        }) == "OpenEXR chunkCount is 4, expected 3");
  CHECK(changed([](File &f) {
          f.attributes.push_back({"chunkCount", "int", words({0x80000000})});
        }) == "OpenEXR chunkCount is negative");
  const size_t most = 16 * width * 6;
  CHECK(changed([&](File &f) { f.blocks[1].resize(most); }) == "");
  CHECK(changed([&](File &f) { f.blocks[1].resize(most + 1); }) ==
        "OpenEXR block 1 has 481 bytes, expected 1 to 480");
  CHECK(changed([&](File &f) { f.blocks[2].resize(most / 2 + 1); }) ==
        "OpenEXR block 2 has 241 bytes, expected 1 to 240");
  CHECK(changed([](File &f) { f.blocks[0].clear(); }) == "OpenEXR block 0 has 0 bytes, expected 1 to 480");
  CHECK(changed([](File &f) { f.blocks[9].pop_back(); }, 0, 1) ==
        "OpenEXR block 9 has 29 bytes, expected 30");
  const File file;
  const bytes good = file.put_together();
  const size_t table = file.header().size(), first = table + 3 * 8;
  const auto poked = [&](size_t at, int by) {
    bytes sample = good;
    sample[at] = uint8_t(sample[at] + by);
    return complaint(sample);
  };
  const std::string at = std::to_string(first + 15);
  CHECK(poked(table + 8, 1) ==
        "OpenEXR block 1 is at " + std::to_string(first + 16) + " by the table, expected at " + at);
  CHECK(poked(table + 8 + 7, 1).find("OpenEXR block 1 is at") == 0);
  CHECK(poked(first + 15, 1) == "OpenEXR block 1 begins with line 17, expected 16");
  CHECK(poked(first + 4, 1) != "");
  CHECK(poked(first + 7, 0x7f) != "");
}

TEST_CASE("the configuration of OpenEXR is linear RGB of 16 bits, without a record") {
  fvv_diagnostic d;
  const auto issue = [&](const std::function<void(fvv_video_config &)> &change) -> uint32_t {
    fvv_video_config c = config();
    change(c);
    uint8_t out[64];
    size_t size;
    if (fvv_video_config_encode(&c, out, sizeof out, &size, &d) == FVV_OK) return 0;
    return d.issue;
  };
  CHECK(issue([](fvv_video_config &) {}) == 0);
  CHECK(issue([](fvv_video_config &c) { c.colour_primaries = 9; }) == 0);
  for (const uint8_t bits : {8, 10, 15})
    CHECK(issue([&](fvv_video_config &c) { c.bit_depth = bits; }) == FVV_ISSUE_VIDEO_RANGE);
  CHECK(issue([](fvv_video_config &c) { c.transfer_characteristics = 13; }) == FVV_ISSUE_VIDEO_RANGE);
  CHECK(std::string(d.message) == "transfer, matrix and full range are 13, 0 and 1, OpenEXR has 8, 0 and 1");
  CHECK(issue([](fvv_video_config &c) { c.matrix_coefficients = 1; }) == FVV_ISSUE_VIDEO_RANGE);
  CHECK(issue([](fvv_video_config &c) { c.full_range = 0; }) == FVV_ISSUE_VIDEO_RANGE);
  const uint8_t record[1] = {0};
  CHECK(issue([&](fvv_video_config &c) {
          c.record = record;
          c.record_size = 1;
        }) == FVV_ISSUE_VIDEO_RECORD);
  CHECK(issue([](fvv_video_config &c) {
          c.codec_string = "oexr";
          c.codec_string_size = 4;
        }) == FVV_ISSUE_VIDEO_RECORD);
  char text[FVV_CODEC_STRING_CAPACITY];
  CHECK(fvv_video_codec_string(FVV_CODEC_OEXR, record, 1, text, &d) == FVV_ERROR_UNSUPPORTED);
}
