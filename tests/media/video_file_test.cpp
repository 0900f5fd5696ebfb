// fvv_media: pictures of video files at random, and what is refused.
#include "fvv_media/video_file.h"

#include "make_video.h"
#include "pictures.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <random>

using namespace fvv::media;

namespace {

// Pictures 0 ... n - 1 in order, backwards and in a random order: each must be itself.
void check_all(VideoFile &file) {
  const size_t count = file.info().times.size();
  const uint32_t x = file.info().width - 4, y = file.info().height - 4;
  std::vector<size_t> order(3 * count);
  for (size_t i = 0; i < count; i++) order[i] = order[2 * count - 1 - i] = order[2 * count + i] = i;
  std::mt19937 random(7);
  std::shuffle(order.begin() + std::ptrdiff_t(2 * count), order.end(), random);
  std::vector<size_t> wrong;
  for (const size_t i : order)
    if (number_in(file.picture(i, 3), x, y) != int(i)) wrong.push_back(i);
  CHECK(wrong.empty());
  CHECK(file.position() == order.back() + 1);
}

std::vector<char> bytes_of(const std::string &name) {
  std::ifstream file(name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_bytes(const std::string &name, const std::vector<char> &bytes, size_t size) {
  std::ofstream(name, std::ios::binary).write(bytes.data(), std::streamsize(size));
}

} // namespace

TEST_CASE("a video with B-frames gives every picture in any order") {
  struct Case {
    const char *name, *encoder, *options;
  };
  for (const Case &c :
       {Case{"b.mp4", "libx264", "crf=4"}, Case{"b.mkv", "libx264", "crf=4"},
        Case{"b.ts", "libx264", "crf=4"},
        Case{"open.mp4", "libx264", "crf=4;x264-params=open-gop=1:bframes=3:b-adapt=0:scenecut=0"},
        Case{"b.mov", "mpeg2video", "b=2000000"},
        Case{"open265.mp4", "libx265", "crf=4;x265-params=open-gop=1:bframes=3:log-level=none:pools=1"},
        Case{"p.webm", "libvpx-vp9", "crf=4;b=0;lag-in-frames=10;auto-alt-ref=1"},
        Case{"p8.webm", "libvpx", "crf=4;b=3000000;lag-in-frames=10;auto-alt-ref=1"},
        Case{"refresh.mp4", "libx264", "crf=4;intra-refresh=1"}}) {
    INFO(c.name);
    Clip clip;
    clip.times = steady(40, 3003);
    if (std::string(c.encoder) == "mpeg2video") {
      clip.time_base = {1001, 30000};
      clip.times = steady(40, 1);
    }
    clip.encoder = c.encoder;
    clip.options = c.options;
    clip.b_frames = std::string(c.encoder).find("vpx") == std::string::npos ? 3 : 0;
    write_video(c.name, clip);
    VideoFile file(c.name);
    CHECK(file.info().width == 64);
    CHECK(file.info().height == 48);
    REQUIRE(file.info().times.size() == 40);
    CHECK(file.info().rotation == 0);
    CHECK(file.info().warnings.empty());
    const fvv_rational tick = file.info().tick;
    for (size_t i = 0; i < 40; i++) {
      const double seconds = double(file.info().times[i]) * tick.numerator / tick.denominator;
      if (std::fabs(seconds - double(i) * 3003 / 90000) > 0.00051)
        FAIL(c.name << ": " << i << " at " << seconds);
    }
    check_all(file);
    VideoFile second = file.another();
    CHECK(number_in(second.picture(17, 1), 60, 44) == 17);
    CHECK(number_in(file.picture(39, 3), 60, 44) == 39);
  }
}

TEST_CASE("times are exact, start at 0 and may be irregular") {
  Clip clip;
  clip.times = {90017, 93020, 99026, 99027, 120000, 450000};
  write_video("vfr.mp4", clip);
  VideoFile file("vfr.mp4");
  const VideoInfo &info = file.info();
  std::vector<int64_t> in_90000;
  for (const int64_t time : info.times) {
    REQUIRE(time * 90000 * info.tick.numerator % info.tick.denominator == 0);
    in_90000.push_back(time * 90000 * info.tick.numerator / info.tick.denominator);
  }
  CHECK(in_90000 == std::vector<int64_t>{0, 3003, 9009, 9010, 29983, 359983});
  check_all(file);
}

TEST_CASE("the display matrix is reported as clockwise degrees") {
  for (const int degrees : {0, 90, 180, 270}) {
    Clip clip;
    clip.times = steady(2, 3000);
    clip.display_rotation = degrees;
    write_video("turned.mp4", clip);
    const VideoFile file("turned.mp4");
    CHECK(file.info().rotation == degrees);
    CHECK(file.info().width == 64); // as stored
  }
  Clip clip;
  clip.times = steady(2, 3000);
  clip.display_rotation = 45;
  write_video("turned.mp4", clip);
  CHECK(!VideoFile("turned.mp4").info().rotation);
}

TEST_CASE("ten bits are rounded to eight") {
  Clip clip;
  clip.times = steady(40, 3000);
  clip.format = AV_PIX_FMT_YUV420P10;
  clip.b_frames = 2;
  write_video("ten.mp4", clip);
  VideoFile file("ten.mp4");
  check_all(file);
  // As 16 bits they keep what lies between the codes of 8.
  size_t between = 0;
  for (const size_t n : {0u, 17u, 39u}) {
    const DeepImage deep = file.picture<uint16_t>(n, 3);
    const Image shallow = file.picture(n, 3);
    REQUIRE(deep.pixels.size() == shallow.pixels.size());
    for (size_t i = 0; i < deep.pixels.size(); i++) {
      const double off = deep.pixels[i] / 257.0 - shallow.pixels[i];
      if (std::abs(off) > 1.5) FAIL("picture " << n << ", sample " << i << " is " << off << " codes off");
      between += std::abs(off) > 0.1;
    }
  }
  CHECK(between > 1000);
}

TEST_CASE("files that would give wrong pictures are refused, unusual ones give a warning") {
  Clip clip;
  clip.times = steady(3, 3000);
  clip.transfer = AVCOL_TRC_SMPTE2084;
  write_video("pq.mp4", clip);
  CHECK(error_of([] { VideoFile("pq.mp4"); }) ==
        "pq.mp4: is HDR video (PQ, SMPTE ST 2084): its samples cannot be shown as sRGB, convert it first");
  clip.transfer = AVCOL_TRC_ARIB_STD_B67;
  write_video("hlg.mkv", clip);
  CHECK_THAT(error_of([] { VideoFile("hlg.mkv"); }), Contains("is HDR video (HLG"));
  clip.transfer = AVCOL_TRC_UNSPECIFIED;
  clip.pixel = {4, 3};
  write_video("wide.mp4", clip);
  CHECK(
      VideoFile("wide.mp4").info().warnings ==
      std::vector<std::string>{"has pixels of 4:3, which are not square: they are taken as they are stored"});
  CHECK_THAT(error_of([] { VideoFile("absent.mp4"); }),
             Contains("absent.mp4: cannot be opened: No such file"));
  CHECK_THAT(error_of([] { VideoFile("wide.mp4", 1); }),
             Contains("has 1 streams, stream 1 is not among them"));
  CHECK_THAT(error_of([] { VideoFile("wide.mp4").picture(3, 3); }), Contains("has 3 pictures, picture 3"));
  write_file("text.mp4", {'n', 'o', ' ', 'v', 'i', 'd', 'e', 'o'});
  CHECK_THAT(error_of([] { VideoFile("text.mp4"); }), Contains("text.mp4: is no video file"));
  const std::string list = "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nwide.mp4\n#EXT-X-ENDLIST\n";
  write_file("list.m3u8", {list.begin(), list.end()});
  CHECK(error_of([] { VideoFile("list.m3u8"); }) ==
        "list.m3u8: is a list of other files (hls), which are not read");
}

TEST_CASE("a name is always a file's name") {
  Clip clip;
  clip.times = steady(2, 3000);
  write_video("plain.mp4", clip);
  for (const char *name : {"a%04d.png", "concat:b", "http:x"}) {
    std::filesystem::copy_file("plain.mp4", name, std::filesystem::copy_options::overwrite_existing);
    CHECK(VideoFile(name).info().times.size() == 2);
  }
}

TEST_CASE("a cut file is refused, or gives no wrong picture") {
  Clip clip;
  clip.times = steady(40, 3000);
  clip.b_frames = 2;
  for (const char *name : {"whole.mp4", "whole.mkv", "whole.ts"}) {
    write_video(name, clip);
    const std::vector<char> bytes = bytes_of(name);
    const std::string cut = std::string("cut") + (name + 5);
    int refused = 0;
    for (int part = 0; part < 24; part++) {
      write_bytes(cut, bytes, bytes.size() * size_t(part) / 24);
      try {
        VideoFile file(cut);
        // A transport stream may end anywhere: what is left must be right.
        for (size_t i = 0; i < file.info().times.size(); i++) {
          Image image;
          const std::string error = error_of([&] { image = file.picture(i, 3); });
          if (error.empty()) CHECK(number_in(image, 60, 44) == int(i));
          refused += !error.empty();
        }
      } catch (const fvv::Error &error) {
        refused++;
        CHECK_THAT(error.what(), Contains(cut));
      }
    }
    CHECK(refused > 0);
    if (std::string(name) != "whole.ts") CHECK(refused >= 24);
  }
}

TEST_CASE("a damaged picture is refused with those that follow it, up to the next key") {
  Clip clip;
  clip.times = steady(40, 3000);
  write_video("flip.mp4", clip);
  std::vector<char> bytes = bytes_of("flip.mp4");
  // Within the first group: 'mdat' is followed by its slices.
  const char tag[] = {'m', 'd', 'a', 't'};
  const auto data = std::search(bytes.begin(), bytes.end(), std::begin(tag), std::end(tag));
  REQUIRE(data != bytes.end());
  std::fill_n(data + 1400, 60, char(0xff));
  write_bytes("flip.mp4", bytes, bytes.size());
  int refused = 0, good = 0;
  VideoFile file("flip.mp4");
  for (size_t i = 0; i < 40; i++) {
    Image image;
    const std::string error = error_of([&] { image = file.picture(i, 3); });
    if (error.empty()) CHECK(number_in(image, 60, 44) == int(i));
    good += error.empty();
    if (!error.empty()) CHECK_THAT(error, Contains("flip.mp4: picture " + std::to_string(i) + " at "));
    refused += !error.empty();
  }
  CHECK(refused > 0);
  CHECK(good >= 24); // the other groups
}
