#include "fvvrender/film.h"

#include "cli/cli.h"
#include "cli/output.h"
#include "fvv_demux/frame_plan.h"
#include "fvv_media/movie.h"
#include "fvv_render/projection.h"
#include "fvv_scene/file_io.h"
#include "fvv_view/path.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numeric>

namespace fvv::rendering {

namespace {

using render::Vec3;

constexpr int64_t most_pictures = 100000;
constexpr int crf = 18; // pictures look like those that are written alone
constexpr uint64_t max_path_file = 16 << 20;
constexpr double slope = 0.2; // of the way to the target, unless the user says otherwise
constexpr size_t looks = 9;   // frames that the place of the action is found by

[[noreturn]] void refuse(const std::string &line) {
  throw Error(line, Error::usage);
}

// What is shown of the stream, and when.
struct Shown {
  struct Frame {
    int64_t number;
    double time; // seconds from the first
  };
  std::vector<Frame> frames;
  double length;         // seconds: to the end of the last
  fvv_rational duration; // of a picture of the film, in seconds
  fvv_scene scene;
  std::vector<fvv_camera> cameras; // of the first configuration

  int64_t number_at(double seconds) const {
    const auto next = std::upper_bound(frames.begin() + 1, frames.end(), seconds + 1e-6,
                                       [](double time, const Frame &frame) { return time < frame.time; });
    return (next - 1)->number;
  }
};

fvv_rational lowest(uint64_t numerator, uint64_t denominator) {
  const uint64_t common = std::gcd(numerator, denominator);
  numerator /= common;
  denominator /= common;
  if (!numerator || numerator > INT32_MAX || denominator > INT32_MAX)
    refuse("--fps: expected with this stream, whose frame rate a film cannot have");
  return {uint32_t(numerator), uint32_t(denominator)};
}

Shown survey(const InputFile &file, const Options &options) {
  const Film &film = options.film;
  demux::LazySurvey lazy(file);
  const demux::Stream stream = demux::open_stream(file);
  demux::Selection wanted = film.frames;
  if (film.count) wanted = demux::Selection::parse("frame", std::to_string(options.frame));
  const demux::Plan plan = demux::make_plan(stream.get(), file, wanted, lazy);
  if (!wanted.everything() && wanted.largest() >= plan.count)
    refuse((film.count ? "--frame" : "--frames") + (": frame " + std::to_string(wanted.largest())) +
           " is not in the stream, which has " + std::to_string(plan.count));
  if (wanted.within(0, INT32_MAX).size() > 1)
    refuse("--frames: expected one range for a film, such as 10-35");
  Shown out = {};
  int64_t first = 0, last = 0;
  // A damaged group may have had any number of frames: those that are there are counted.
  const auto is_there = [&](const demux::GroupPlan &group, int64_t number, fvv_frame *frame) {
    const size_t place = group.frame + size_t(number - group.number);
    if (place >= fvv_stream_frame_count(stream.get())) return false;
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_stream_frame(stream.get(), place, frame, &diagnostic), file.path(), diagnostic);
    return frame->group == group.group;
  };
  fvv_frame frame;
  fvv_diagnostic diagnostic = {};
  for (const demux::GroupPlan &group : plan.groups)
    for (const fvv::Range &range : wanted.within(group.number, group.number + group.count - 1))
      for (int64_t number = range.first; number <= range.last && is_there(group, number, &frame); number++) {
        if (out.frames.empty()) {
          const fvv_configuration *configuration;
          fvv::check(fvv_stream_configuration(stream.get(), group.group, &configuration, &diagnostic),
                     file.path(), diagnostic);
          out.scene = configuration->scene;
          out.cameras.assign(configuration->cameras, configuration->cameras + configuration->camera_count);
          for (fvv_camera &camera : out.cameras) {
            camera.name = nullptr;
            camera.name_size = 0;
          }
          first = frame.time;
        }
        last = frame.time;
        const double tick = double(out.scene.time_base.numerator) / out.scene.time_base.denominator;
        out.frames.push_back({number, double(uint64_t(frame.time) - uint64_t(first)) * tick});
      }
  if (out.frames.empty()) throw Error(file.path() + ": the stream has no frames");
  const fvv_rational &base = out.scene.time_base;
  const auto ticks = uint64_t(out.scene.frame_duration);
  out.length = (double(uint64_t(last) - uint64_t(first)) + double(ticks)) * base.numerator / base.denominator;
  out.duration = film.fps            ? fvv_rational{film.fps->denominator, film.fps->numerator}
                 : ticks > INT32_MAX ? lowest(0, 1)
                                     : lowest(ticks * base.numerator, base.denominator);
  return out;
}

struct Box {
  Vec3 least{1e30, 1e30, 1e30}, most{-1e30, -1e30, -1e30};

  bool is_empty() const { return least.x > most.x; }
  void add(const view::Frame &frame) {
    const std::vector<float> &positions = frame.positions;
    for (size_t i = 0; i + 2 < positions.size(); i += 3) {
      const double x = frame.origin.x + positions[i], y = frame.origin.y + positions[i + 1],
                   z = frame.origin.z + positions[i + 2];
      least = {std::min(least.x, x), std::min(least.y, y), std::min(least.z, z)};
      most = {std::max(most.x, x), std::max(most.y, y), std::max(most.z, z)};
    }
  }
};

// Around all of some frames.
Box box_of(const InputFile &file, const Options &options, const Shown &shown) {
  view::LoadOptions load = options.load;
  load.pictures = false;
  Box box;
  const size_t count = shown.frames.size();
  for (size_t i = 0; i < std::min(looks, count); i++)
    box.add(view::load_frame(file, shown.frames[i * count / std::min(looks, count)].number, load));
  if (box.is_empty())
    throw Error(file.path() + ": the stage is empty: expected --target and --radius with --orbit");
  return box;
}

// From the point to the first camera that is not above or below it, at right angles to up.
Vec3 start_of(const Shown &shown, Vec3 target, Vec3 up) {
  for (const fvv_camera &camera : shown.cameras) {
    const double *r = camera.rotation, *t = camera.translation;
    const Vec3 eye = {-(r[0] * t[0] + r[3] * t[1] + r[6] * t[2]), -(r[1] * t[0] + r[4] * t[1] + r[7] * t[2]),
                      -(r[2] * t[0] + r[5] * t[1] + r[8] * t[2])};
    const Vec3 away = eye - target, flat = away - up * render::dot(away, up);
    if (render::length(flat) > 1e-3 * render::length(away)) return render::normalised(flat);
  }
  const Vec3 axis = std::abs(up.z) > 0.5 ? Vec3{1, 0, 0} : Vec3{0, 0, 1};
  return render::normalised(axis - up * render::dot(axis, up));
}

view::Size size_of(const Options &options) {
  return options.draw.target.size.value_or(view::Size{view::default_width, view::default_height});
}

view::Orbit orbit_of(const InputFile &file, const Options &options, const Shown &shown) {
  const Film &film = options.film;
  view::Orbit orbit = {};
  orbit.up = render::up_vector(shown.scene.up_axis);
  double distance = 0;
  if (!film.target || !film.radius) {
    const Box box = box_of(file, options, shown);
    orbit.target = (box.least + box.most) * 0.5;
    // The upright cylinder around the box fits, with a tenth to spare.
    const view::Size size = size_of(options);
    const double focal = options.draw.target.focal.value_or(size.width);
    const Vec3 half = (box.most - box.least) * 0.5;
    const double tall = std::abs(render::dot(half, orbit.up)),
                 wide = std::sqrt(std::max(0.0, render::dot(half, half) - tall * tall));
    const double across = wide / std::sin(std::atan(size.width / 2.0 / focal));
    const auto away = [&](double steep) {
      return 1.1 * std::max(across, wide + (tall + steep * wide) * 2 * focal / size.height);
    };
    // Seen from above, the near and the far edge take more of the picture.
    distance = away(film.height ? std::min(1.0, std::abs(*film.height) / away(0)) : slope);
  }
  if (film.target) orbit.target = *film.target;
  orbit.height = film.height.value_or((film.radius ? *film.radius : distance) * slope);
  orbit.radius = film.radius.value_or(
      std::sqrt(std::max(distance * distance - orbit.height * orbit.height, distance * distance / 100)));
  orbit.start = start_of(shown, orbit.target, orbit.up);
  return orbit;
}

// The camera at a time of a film of that many seconds.
class Way {
public:
  Way(const InputFile &file, const Options &options, const Shown &shown)
      : target(options.draw.target), degrees(options.film.orbit) {
    if (degrees) orbit = orbit_of(file, options, shown);
    if (!options.film.path.empty())
      path = view::parse_path(scene::read_file(options.film.path, max_path_file), options.film.path);
    up = render::up_vector(shown.scene.up_axis);
    height = size_of(options).height;
  }

  std::optional<double> end() const { return path ? std::optional(path->end()) : std::nullopt; }

  // share: of the film's length that is over.
  view::Target at(double seconds, double share) const {
    if (!degrees && !path) return target;
    const view::Keyframe key = path ? path->at(seconds) : orbit->at(*degrees * share);
    const Vec3 top = key.up.value_or(up), line = key.target - key.position;
    const double sine = render::length(render::cross(render::normalised(line), render::normalised(top)));
    if (!(sine > 1e-6)) {
      char text[32];
      std::snprintf(text, sizeof text, "%.3f", seconds);
      throw Error(std::string(path ? "--path" : "--orbit") + ": at " + text +
                      " s the camera looks along its up direction, or is where it looks at",
                  Error::usage);
    }
    view::Target out = target;
    out.pose = {key.position.x, key.position.y, key.position.z, key.target.x, key.target.y,
                key.target.z,   top.x,          top.y,          top.z};
    if (key.fov) out.focal = height / 2.0 / std::tan(*key.fov * 3.14159265358979323846 / 360);
    return out;
  }

private:
  const view::Target target;
  const std::optional<double> degrees;
  std::optional<view::Orbit> orbit;
  std::optional<view::Path> path;
  Vec3 up;
  uint32_t height;
};

// Draws the pictures of a film, in order.
class Pictures {
public:
  Pictures(const Options &chosen, Result &out)
      : options(chosen), result(out), file(options.input), shown(survey(file, options)),
        way(file, options, shown) {
    const double rate = double(shown.duration.denominator) / shown.duration.numerator;
    if (options.film.count)
      total = *options.film.count;
    else
      total = std::max<int64_t>(1, int64_t(std::llround(std::min(shown.length * rate, 1e9))));
    if (total > most_pictures)
      refuse("a film of " + std::to_string(total) + " pictures: expected at most " +
             std::to_string(most_pictures) + "; --frames or --fps makes it shorter");
    result.film =
        Result::Film{total, shown.duration, shown.frames.front().number, shown.frames.back().number};
  }

  int64_t count() const { return total; }
  const fvv_rational &duration() const { return shown.duration; }

  media::Image draw(int64_t i) {
    const double seconds = double(i) * shown.duration.numerator / shown.duration.denominator;
    const int64_t number = options.film.count ? options.frame : shown.number_at(seconds);
    if (!frame || frame->number != number) {
      const auto begin = std::chrono::steady_clock::now();
      frame = view::load_frame(file, number, options.load);
      result.load += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
    view::Options now = options.draw;
    now.target = way.at(seconds, double(i) / double(total));
    view::Result one;
    const render::ViewPicture picture = view::draw(*frame, now, one);
    add(one);
    media::Image image = media::make_image(picture.width, picture.height, 3, 0);
    image.pixels = view::eight_bits(picture);
    return image;
  }

private:
  void add(const view::Result &one) {
    const auto add_new = [](std::vector<std::string> &lines, const std::vector<std::string> &more) {
      for (const std::string &line : more)
        if (std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
    };
    view::Result sum = result;
    if (!result.width) {
      sum = one;
    } else {
      sum.surface += one.surface;
      sum.by_cameras.resize(std::max(sum.by_cameras.size(), one.by_cameras.size()));
      for (size_t i = 0; i < one.by_cameras.size(); i++) sum.by_cameras[i] += one.by_cameras[i];
      sum.prepare += one.prepare;
      sum.draw += one.draw;
      add_new(sum.losses, one.losses);
      add_new(sum.warnings, one.warnings);
    }
    static_cast<view::Result &>(result) = std::move(sum);
  }

  const Options &options;
  Result &result;
  const InputFile file;
  const Shown shown;
  const Way way;
  int64_t total = 0;
  std::optional<view::Frame> frame;
};

void write_mp4(const Options &options, Result &result) {
  cli::OutputFile out(options.output, options.force, cli::inputs({options.input}));
  Pictures pictures(options, result);
  const auto first = std::make_shared<media::Image>(pictures.draw(0));
  if (first->width % 2 || first->height % 2)
    refuse("--size: expected even sides for MP4, found " + std::to_string(first->width) + "x" +
           std::to_string(first->height));
  media::VideoSettings settings = {};
  settings.codec = FVV_CODEC_AVC1;
  settings.width = first->width;
  settings.height = first->height;
  settings.quality = crf;
  settings.frame_rate = pictures.duration();
  cli::Progress progress(options.output, uint64_t(pictures.count()));
  const auto load = [&](size_t i) {
    media::GroupFrame<uint8_t> loaded;
    loaded.image = i ? std::make_shared<media::Image>(pictures.draw(int64_t(i))) : first;
    progress.step();
    return loaded;
  };
  const media::EncodedGroup group =
      media::encode_group(settings, media::GroupSource<uint8_t>(size_t(pictures.count()), load));
  const std::string bytes = media::movie_file(settings, group, nullptr);
  out.write(bytes.data(), bytes.size());
  out.commit();
}

void write_files(const Options &options, Result &result) {
  const std::filesystem::path path = options.output;
  cli::OutputFolder folder(path.parent_path(), options.force, cli::inputs({options.input}));
  Pictures pictures(options, result);
  cli::Progress progress(options.output, uint64_t(pictures.count()));
  for (int64_t i = 0; i < pictures.count(); i++) {
    char name[32];
    std::snprintf(name, sizeof name, "%04lld.png", static_cast<long long>(i));
    const std::vector<uint8_t> bytes = media::encode_png(pictures.draw(i));
    folder.write(name, {reinterpret_cast<const char *>(bytes.data()), bytes.size()});
    progress.step();
  }
  folder.commit();
}

bool is_numbered(const std::string &output) {
  return std::filesystem::path(output).filename() == "%04d.png";
}

} // namespace

bool is_film(const std::string &output) {
  return std::filesystem::path(output).extension() == ".mp4" || is_numbered(output);
}

void run_film(const Options &options, Result &result) {
  const view::Target &target = options.draw.target;
  const int ways = options.film.orbit.has_value() + !options.film.path.empty() + target.camera.has_value() +
                   !target.pose.empty();
  if (ways != 1)
    refuse("expected one of --orbit, --path, --camera and --pose, found " +
           std::string(ways ? "several" : "none"));
  if (is_numbered(options.output) && std::filesystem::path(options.output).parent_path().empty())
    refuse("--output: expected a folder before %04d.png, as in turn/%04d.png");
  is_numbered(options.output) ? write_files(options, result) : write_mp4(options, result);
}

} // namespace fvv::rendering
