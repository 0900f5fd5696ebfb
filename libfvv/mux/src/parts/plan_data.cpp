#include "mux/src/parts/plan_data.h"
#include "fvv/container.h"
#include "fvv_cxx/error.h"
#include "fvv_mux/option_table.h"
#include "mux/src/environment.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/options/option_values.h"
#include "mux/src/pictures.h"
#include "mux/src/planner.h"

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <type_traits>
#include <utility>

namespace fvv::mux {

namespace {

using Cbor = nlohmann::json;

// The fields of each structure, in the order in which they are saved. A structured binding names all of them,
// so that a field that is added to a structure does not compile before it is decided here whether it is
// saved. Left out are objects that are made again from what is saved.
struct Fields {
  template <class A> static void of(A &a, fvv_rational &v) {
    auto &[numerator, denominator] = v;
    a(numerator, denominator);
  }
  template <class A> static void of(A &a, fvv_rect &v) {
    auto &[x, y, width, height] = v;
    a(x, y, width, height);
  }
  template <class A> static void of(A &a, fvv_tile &v) {
    auto &[camera, source, destination] = v;
    a(camera, source, destination);
  }
  template <class A> static void of(A &a, Range &v) {
    auto &[first, last] = v;
    a(first, last);
  }
  template <class A> static void of(A &a, geometry::Lattice &v) {
    auto &[origin, step] = v;
    a(origin, step);
  }
  template <class A> static void of(A &a, FrameLimit &v) {
    auto &[width, height, pixels, name] = v;
    a(width, height, pixels, name);
  }
  template <class A> static void of(A &a, decimate::Sight &v) {
    auto &[metres_per_pixel, distance, camera] = v;
    a(metres_per_pixel, distance, camera);
  }
  template <class A> static void of(A &a, decimate::Budget &v) {
    auto &[pixels, triangles, min_piece, lattice, checks] = v;
    a(pixels, triangles, min_piece, lattice, checks);
  }
  template <class A> static void of(A &a, ErrorBudget &v) {
    auto &[value, is_length, reason, nearest] = v;
    a(value, is_length, reason, nearest);
  }
  template <class A> static void of(A &a, LatticeChoice &v) {
    auto &[lattice, reason, pixels, delta_error] = v;
    a(lattice, reason, pixels, delta_error);
  }
  template <class A> static void of(A &a, DecimationChoice &v) {
    auto &[on, budget, pixel, target_error, is_length, reason] = v;
    a(on, budget, pixel, target_error, is_length, reason);
  }
  template <class A> static void of(A &a, NormalChoice &v) {
    auto &[bits, reason] = v;
    a(bits, reason);
  }
  template <class A> static void of(A &a, WindingChoice &v) {
    auto &[flip, by_cameras, turned_away] = v;
    a(flip, by_cameras, turned_away);
  }
  template <class A> static void of(A &a, VisibilityChoice &v) {
    auto &[on, open, by_views, known, threshold, cosine, cameras, reason] = v;
    a(on, open, by_views, known, threshold, cosine, cameras, reason);
  }
  template <class A> static void of(A &a, ColourChoice &v) {
    auto &[on, of_vertices, cell_size, step, cameras, reason] = v;
    a(on, of_vertices, cell_size, step, cameras, reason);
  }
  template <class A> static void of(A &a, render::CameraMatch &v) {
    auto &[gain, matched, places] = v;
    a(gain, matched, places);
  }
  template <class A> static void of(A &a, render::ColourMatch &v) {
    auto &[cameras, before, after] = v;
    a(cameras, before, after);
  }
  template <class A> static void of(A &a, MatchChoice &v) {
    auto &[on, reason, cameras, frames, found, tables] = v;
    a(on, reason, cameras, frames, found);
  }
  template <class A> static void of(A &a, render::TextureInset &v) {
    auto &[inset, before, after, views, better, pixels] = v;
    a(inset, before, after, views, better, pixels);
  }
  template <class A> static void of(A &a, InsetChoice &v) {
    auto &[inset, reason, frame, found] = v;
    a(inset, reason, frame, found);
  }
  template <class A> static void of(A &a, fvv_texturing &v) {
    auto &[threshold, depth_bias, depth_slope, inset, best, unseen, blend] = v;
    a(threshold, depth_bias, depth_slope, inset, best, unseen, blend);
  }
  template <class A> static void of(A &a, ViewReport &v) {
    auto &[goal, is_measured, reason, frame, psnr, max_error, step, is_length, is_paper, threshold, best,
           loss, finest_psnr, finest_ssim, psnr_without, held_out_psnr, held_out_ssim, between_psnr,
           bytes_without, bytes, candidates, blends, rungs] = v;
    a(goal, is_measured, reason, frame, psnr, max_error, step, is_length, is_paper, threshold, best, loss,
      finest_psnr, finest_ssim, psnr_without, held_out_psnr, held_out_ssim, between_psnr, bytes_without,
      bytes);
  }
  template <class A> static void of(A &a, ViewChoice &v) {
    auto &[report, texturing, ladder] = v; // the options have the ladder
    a(report, texturing);
  }
  template <class A> static void of(A &a, Tiling &v) {
    auto &[cameras, tiles, width, height] = v;
    a(cameras, tiles, width, height);
  }
  template <class A> static void of(A &a, media::VideoSettings &v) {
    auto &[codec, width, height, quality, frame_rate, bit_depth, bit_rate, draft, parts, effort] = v;
    a(codec, width, height, quality, frame_rate, bit_depth, bit_rate, draft, parts, effort);
  }
  template <class A> static void of(A &a, VideoDecision &v) {
    auto &[settings, masks, sample_frames, target_psnr, sample_psnr, sample_rate, record, codec_string] = v;
    a(settings, masks, sample_frames, target_psnr, sample_psnr, sample_rate, record, codec_string);
  }
  template <class A> static void of(A &a, Silhouette &v) {
    auto &[left, top, right, bottom] = v;
    a(left, top, right, bottom);
  }
  template <class A> static void of(A &a, CropChoice &v) {
    auto &[on, by_masks, by_mesh, reason, whole_pixels, boxes] = v;
    a(on, by_masks, by_mesh, reason, whole_pixels, boxes);
  }
  template <class A> static void of(A &a, VideoTrack &v) {
    auto &[shows, tiling, groups, part, encoded, sample, rung, best, id, alternate_group] = v;
    a(shows, tiling, groups, part, sample, rung, best, id, alternate_group);
  }
  template <class A> static void of(A &a, MeshTrack &v) {
    auto &[rung, times, lattice, decimation, loader, id, visibility, colours] = v;
    a(rung, times, lattice, decimation, id, visibility, colours);
  }
  template <class A> static void of(A &a, scene::Seconds &v) {
    auto &[numerator, denominator] = v;
    a(numerator, denominator);
  }
  template <class A> static void of(A &a, scene::SoundSource &v) {
    auto &[file, stream, offset, first, title, language, position, per_frame, memory] = v;
    a(file, stream, offset, first, title, language, position, per_frame);
  }
  template <class A> static void of(A &a, media::SoundFormat &v) {
    auto &[codec, rate, channels, packet_duration, preroll, record] = v;
    a(codec, rate, channels, packet_duration, preroll, record);
  }
  template <class A> static void of(A &a, media::SoundPackets &v) {
    auto &[format, start, packets, encoded, before, goes_on, warnings] = v;
    a(format, start, packets, encoded, before, goes_on, warnings);
  }
  template <class A> static void of(A &a, SoundTrack &v) {
    auto &[source, packets] = v;
    a(source, packets);
  }
  template <class A> static void of(A &a, DataCue &v) {
    auto &[start, end, text] = v;
    a(start, end, text);
  }
  template <class A> static void of(A &a, DataTrack &v) {
    auto &[name, media_type, codec, head, cues, files] = v;
    a(name, media_type, codec, head, cues, files);
  }
  template <class A> static void of(A &a, PackedEnvironment &v) {
    auto &[payload, lattice, reason, parts, pictures, lights, vertices, faces, mesh_bytes, picture_bytes,
           max_error, warnings] = v;
    a(payload, lattice, reason, parts, pictures, lights, vertices, faces, mesh_bytes, picture_bytes,
      max_error, warnings);
  }
  template <class A> static void of(A &a, GroupSpan &v) {
    auto &[first, count, start, end] = v;
    a(first, count, start, end);
  }
  template <class A> static void of(A &a, BadFrame &v) {
    auto &[number, reason] = v;
    a(number, reason);
  }
  template <class A> static void of(A &a, scene::Frames &v) {
    auto &[first, count, step, left_out] = v;
    a(first, count, step, left_out);
  }
  template <class A> static void of(A &a, VisibilityDecision &v) {
    auto &[on, reason] = v;
    a(on, reason);
  }
  template <class A> static void of(A &a, MeshDecision &v) {
    auto &[sent, saving] = v;
    a(sent, saving);
  }
  template <class A> static void of(A &a, Decisions &v) {
    auto &[videos, meshes, visibility, nominal] = v;
    a(videos, meshes, visibility, nominal);
  }
  template <class A> static void of(A &a, NominalRates &v) {
    auto &[rates, sizes] = v;
    a(rates, sizes);
  }
  template <class A> static void of(A &a, TrackChoice &v) {
    auto &[on, reason, by_outlines] = v;
    a(on, reason, by_outlines);
  }
  // Of the capture, what files say; sources, and what the view was chosen from, are for a summary alone, and
  // effort changes only of frames in memory.
  template <class A> static void of(A &a, Plan &v) {
    auto &[options, observer, capture, group_size, effort, groups, bad, has_constant_topology, tracking,
           error, lattice, meshes, shares_meshes, normals, winding, texture_bits, tracks, videos, sources,
           mask_rules, outline_cameras, outline_rules, warned, crop, first_view, objects, whole, visibility,
           match, inset, view, colours, undistortion, environment, sounds, data, frame_limit] = v;
    a(options, capture.frames, capture.empty, group_size, groups, bad, has_constant_topology, tracking, error,
      lattice, meshes, shares_meshes, normals, winding, texture_bits, tracks, mask_rules, outline_rules,
      warned, crop, first_view, objects, whole, visibility, match, inset, view, colours, environment, sounds,
      data, frame_limit);
  }
  template <class A> static void of(A &a, PlanData &v) {
    auto &[plan, decisions, capture, warnings, checksum] = v;
    a(plan, decisions, capture, warnings);
  }
};

// A structure becomes an array of its fields; everything else is as JSON has it, and bytes are binary.
class Saver {
public:
  template <class... Values> void operator()(Values &...values) { (list.push_back(saved(values)), ...); }

  template <class T> static Cbor saved(T &value) {
    if constexpr (std::is_enum_v<T>) {
      return static_cast<std::underlying_type_t<T>>(value);
    } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
      return value;
    } else if constexpr (std::is_array_v<T>) {
      Cbor list = Cbor::array();
      for (auto &one : value) list.push_back(saved(one));
      return list;
    } else {
      return saved_object(value);
    }
  }

  Cbor list = Cbor::array();

private:
  template <class T> static Cbor saved_object(T &value) {
    Saver saver;
    Fields::of(saver, value);
    return std::move(saver.list);
  }
  // Those of the table by name and text; what a capture on disk is without them.
  static Cbor saved_object(Options &options) {
    const Options defaults;
    Cbor texts = Cbor::object();
    for (const Option &option : option_table())
      if (const std::string text = option.text(options);
          option.is_planned && !option.is_list && text != option.text(defaults))
        texts[option.name] = option.is_flag() && text.empty() ? "off" : text;
    return Cbor::array({saved(options.capture), saved(options.cameras), saved(options.data), texts});
  }
  static Cbor saved_object(std::vector<uint8_t> &value) { return Cbor::binary(value); }
  template <class T> static Cbor saved_object(std::vector<T> &value) { return saved_items(value); }
  template <class T, size_t n> static Cbor saved_object(std::array<T, n> &value) {
    return saved_items(value);
  }
  template <class T> static Cbor saved_object(std::set<T> &value) { return saved_items(value); }
  template <class K, class T> static Cbor saved_object(std::map<K, T> &value) {
    Cbor list = Cbor::array();
    for (auto &[key, one] : value) list.push_back({key, saved(one)});
    return list;
  }
  template <class T> static Cbor saved_object(std::optional<T> &value) {
    return value ? Cbor::array({saved(*value)}) : Cbor();
  }
  template <class T> static Cbor saved_object(std::shared_ptr<const T> &value) {
    if (!value) return {};
    T copy = *value;
    return Cbor::array({saved(copy)});
  }
  template <class Items> static Cbor saved_items(Items &items) {
    Cbor list = Cbor::array();
    for (auto &one : items) list.push_back(saved(one));
    return list;
  }
};

class Loader {
public:
  explicit Loader(const Cbor &saved) : list(saved) {}

  template <class... Values> void operator()(Values &...values) {
    size_t next = 0;
    (load(list.at(next++), values), ...);
  }

  template <class T> static void load(const Cbor &saved, T &value) {
    if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(saved.get<std::underlying_type_t<T>>());
    } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
      value = saved.get<T>();
    } else if constexpr (std::is_array_v<T>) {
      size_t next = 0;
      for (auto &one : value) load(saved.at(next++), one);
    } else {
      load_object(saved, value);
    }
  }

private:
  template <class T> static void load_object(const Cbor &saved, T &value) {
    Loader loader(saved);
    Fields::of(loader, value);
  }
  static void load_object(const Cbor &saved, Options &options) {
    load(saved.at(0), options.capture);
    load(saved.at(1), options.cameras);
    load(saved.at(2), options.data);
    for (const auto &[name, text] : saved.at(3).items())
      set_option(options, name, text.get_ref<const std::string &>());
    fill_in(options);
  }
  static void load_object(const Cbor &saved, std::vector<uint8_t> &value) { value = saved.get_binary(); }
  template <class T> static void load_object(const Cbor &saved, std::vector<T> &value) {
    value.resize(saved.size());
    for (size_t i = 0; i < saved.size(); i++) load(saved.at(i), value[i]);
  }
  template <class T, size_t n> static void load_object(const Cbor &saved, std::array<T, n> &value) {
    for (size_t i = 0; i < n; i++) load(saved.at(i), value[i]);
  }
  template <class T> static void load_object(const Cbor &saved, std::set<T> &value) {
    value.clear();
    for (const Cbor &one : saved) {
      T item;
      load(one, item);
      value.insert(item);
    }
  }
  template <class K, class T> static void load_object(const Cbor &saved, std::map<K, T> &value) {
    value.clear();
    for (const Cbor &one : saved) load(one.at(1), value[one.at(0).get<K>()]);
  }
  template <class T> static void load_object(const Cbor &saved, std::optional<T> &value) {
    value.reset();
    if (!saved.is_null()) load(saved.at(0), value.emplace());
  }
  template <class T> static void load_object(const Cbor &saved, std::shared_ptr<const T> &value) {
    value.reset();
    if (saved.is_null()) return;
    T loaded;
    load(saved.at(0), loaded);
    value = std::make_shared<const T>(std::move(loaded));
  }

  const Cbor &list;
};

// Changes with every change of Fields and of the texts of options.
constexpr int plan_version = 11;

std::string version_text() {
  return std::string("fvv ") + fvv_version() + ", plans of version " + std::to_string(plan_version);
}

// What plan_frames() did with the capture, and the objects that are not saved.
void complete(PlanData &data, const std::string &path) {
  Plan &plan = data.plan;
  const scene::Frames frames = plan.capture.frames;
  const std::set<int64_t> empty = plan.capture.empty;
  plan.capture = scene::parse_capture(data.capture, path);
  plan.capture.memory_limit = memory_limit_of(plan.options);
  plan.capture.mesh_cache = scene::make_mesh_cache();
  plan.outline_cameras = outline_cameras(plan.capture.cameras, plan.outline_rules);
  select(plan.capture, plan.options, {});
  plan.capture.frames = frames;
  plan.capture.empty = empty;
  plan.capture.flip_faces = plan.winding.flip;
  std::vector<scene::Camera> &cameras = plan.capture.cameras;
  for (size_t i = 0; i < std::min(cameras.size(), plan.mask_rules.size()); i++)
    if (cameras[i].masks) cameras[i].masks->mask_rule = plan.mask_rules[i];
  if (plan.options.undistort)
    plan.undistortion = std::make_shared<scene::Undistortion>(plan.capture, plan.options.undistort_alpha);
  if (plan.match.on) plan.match.tables = gain_tables(plan.match, plan.capture.cameras.size());
  plan.videos = std::make_shared<scene::Videos>(plan.options.threads, plan.capture.memory_limit);
  for (MeshTrack &track : plan.meshes)
    track.loader = std::make_shared<MeshLoader>(plan, track.decimation, plan.whole);
}

} // namespace

std::string save_plan(PlanData data) {
  const std::vector<uint8_t> fields = Cbor::to_cbor(Saver::saved(data));
  const Cbor file = {{"fvv_plan", version_text()},
                     {"crc32c", fvv_crc32c(0, fields.data(), fields.size())},
                     {"plan", Cbor::binary(fields)}};
  std::string bytes;
  Cbor::to_cbor(file, bytes);
  return bytes;
}

namespace {

// More than any plan has. nlohmann-json reads CBOR by recursion, and a plan is read before its checksum is
// known.
constexpr size_t deepest = 64;

// Whether arrays and objects are at most that deep inside one another.
class Depth : public nlohmann::json_sax<Cbor> {
public:
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(int64_t) override { return true; }
  bool number_unsigned(uint64_t) override { return true; }
  bool number_float(double, const std::string &) override { return true; }
  bool string(std::string &) override { return true; }
  bool binary(Cbor::binary_t &) override { return true; }
  bool key(std::string &) override { return true; }
  bool start_object(size_t) override { return ++level <= deepest; }
  bool start_array(size_t) override { return ++level <= deepest; }
  bool end_object() override { return level-- > 0; }
  bool end_array() override { return level-- > 0; }
  bool parse_error(size_t, const std::string &, const nlohmann::detail::exception &) override {
    return false;
  }

private:
  size_t level = 0;
};

template <class Bytes> Cbor from_cbor(const Bytes &bytes, const std::string &name) {
  Depth depth;
  if (!Cbor::sax_parse(bytes.begin(), bytes.end(), &depth, Cbor::input_format_t::cbor))
    throw Error(name + ": is no plan, or a damaged one");
  return Cbor::from_cbor(bytes.begin(), bytes.end());
}

} // namespace

PlanData load_plan(std::string_view bytes, const std::string &name, const std::string &capture) {
  PlanData data;
  try {
    const Cbor file = from_cbor(bytes, name);
    const auto &made_by = file.at("fvv_plan").get_ref<const std::string &>();
    if (made_by != version_text())
      throw Error(name + ": is a plan of " + made_by + ", expected one of " + version_text() +
                  ": plan again, with the version that encodes");
    const std::vector<uint8_t> &fields = file.at("plan").get_binary();
    data.checksum = file.at("crc32c").get<uint32_t>();
    if (fvv_crc32c(0, fields.data(), fields.size()) != data.checksum)
      throw Error(name + ": the plan is damaged: its checksum is wrong");
    Loader::load(from_cbor(fields, name), data);
  } catch (const Cbor::exception &) {
    throw Error(name + ": is no plan, or a damaged one");
  }
  complete(data, capture.empty() ? data.plan.options.capture : capture);
  return data;
}

} // namespace fvv::mux
