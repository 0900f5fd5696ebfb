#include "fvv_mux/option_table.h"

#include "fvv/colours.h"
#include "fvv/format.h"
#include "fvv_media/memory_limit.h"
#include "fvv_media/sound.h"
#include "fvv_media/video.h"
#include "fvv_scene/inputs.h"
#include "mux/src/options/option_values.h"

#include <algorithm>
#include <type_traits>
#include <utility>

namespace fvv::mux {

namespace {

const char *const files = "Files",
                  *const without_capture = "Without a capture.json (docs/tools/fvvmux-inputs.md)",
                  *const meshes = "Meshes", *const pictures = "Pictures",
                  *const left_out = "What is left out", *const running = "Running";

// `max-error` in the text of an option is the name of another one.
std::string with_names(const std::string &text) {
  std::string out;
  size_t begin = 0;
  while (begin < text.size()) {
    const size_t open = std::min(text.find('`', begin), text.size());
    out += text.substr(begin, open - begin);
    const size_t close = text.find('`', open + 1);
    if (open == text.size()) break;
    out += option_name(std::string_view(text).substr(open + 1, close - open - 1));
    begin = close + 1;
  }
  return out;
}

template <class Value> struct Bare { using Type = Value; };
template <class Value> struct Bare<std::optional<Value>> { using Type = Value; };

// A row of the table, filled in step by step.
class Row {
public:
  Row(const char *name, const char *value, const std::string &help) {
    option.name = name;
    option.value = value;
    option.help = with_names(help);
    option.since = "0.2"; // of all options until now
  }

  Row &brief(const char *group, const std::string &text) {
    option.group = group;
    option.brief = with_names(text);
    return *this;
  }
  Row &needs(const char *other) {
    option.needs.push_back(other);
    return *this;
  }
  Row &excludes(const char *other) {
    option.excludes.push_back(other);
    return *this;
  }
  Row &formerly(const char *name) {
    option.former = name;
    return *this;
  }
  // Of a capture that lies on a disk.
  Row &of_capture() {
    option.of_capture = true;
    return *this;
  }
  // Of a run on one machine.
  Row &unplanned() {
    option.is_planned = false;
    return *this;
  }
  Row &separated_by(char separator) {
    option.separator = separator;
    return *this;
  }
  Row &list() {
    option.is_list = true;
    return *this;
  }

  // on: the value of the member when the flag is given.
  template <auto Member> Row &flag(bool on = true) {
    option.python = "bool";
    option.example = "on";
    option.set = [name = option.name, on](Options &options, const std::string &text) {
      if (text != "on" && text != "off") refuse_value(name, "on or off", text);
      options.*Member = (text == "on") == on;
    };
    option.text = [on](const Options &options) { return options.*Member == on ? "on" : ""; };
    return *this;
  }

  // unset: a value of the member that is none.
  template <auto Member, class Bound> Row &number(Bound least, Bound most, std::optional<Bound> unset = {}) {
    constexpr bool whole = std::is_integral_v<Bound>;
    using Value = std::decay_t<decltype(std::declval<Options>().*Member)>;
    option.python = whole ? "int" : "float";
    option.bounds = OptionBounds{double(least), double(most), whole};
    option.example = number_text(double(most));
    option.set = [name = option.name, least, most](Options &options, const std::string &text) {
      using Number = typename Bare<Value>::Type;
      options.*Member = Number(parse_number(name, text, double(least), double(most), whole));
    };
    if constexpr (std::is_same_v<Value, typename Bare<Value>::Type>)
      option.text = [unset](const Options &options) {
        return unset && Bound(options.*Member) == *unset ? std::string()
                                                         : number_text(double(options.*Member));
      };
    else
      option.text = [](const Options &options) {
        return options.*Member ? number_text(double(*(options.*Member))) : std::string();
      };
    return *this;
  }

  // The words that the value may be.
  template <auto Member, class Value> Row &words(const std::vector<std::pair<const char *, Value>> &all) {
    using Type = std::decay_t<decltype(std::declval<Options>().*Member)>;
    std::string expected;
    for (size_t i = 0; i < all.size(); i++) {
      option.choices.push_back(all[i].first);
      expected += (!i ? "" : i + 1 < all.size() ? ", " : " or ") + option.choices.back();
      option.python += (!i ? "Literal[\"" : "\", \"") + option.choices.back();
    }
    option.python += "\"]";
    if (std::count(option.choices.begin(), option.choices.end(), "off"))
      option.python = "bool | " + option.python;
    option.example = option.choices.back();
    option.set = [name = option.name, all, expected](Options &options, const std::string &text) {
      for (const auto &[word, value] : all)
        if (text == word) {
          options.*Member = value;
          return;
        }
      refuse_value(name, expected, text);
    };
    option.text = [all](const Options &options) -> std::string {
      if constexpr (!std::is_same_v<Type, Value>)
        if (!(options.*Member)) return {};
      for (const auto &[word, value] : all)
        if (options.*Member == value) return word;
      return {};
    };
    return *this;
  }

  // parse(name, text) gives the value of the member, format(value) its text.
  template <auto Member, class Parse, class Format>
  Row &text(const char *python, const char *example, const Parse &parse, const Format &format) {
    using Value = std::decay_t<decltype(std::declval<Options>().*Member)>;
    option.python = python;
    option.example = example;
    option.set = [name = option.name, parse](Options &options, const std::string &text) {
      if (text.empty()) refuse_value(name, "a value", text);
      options.*Member = parse(name, text);
    };
    option.text = [format](const Options &options) -> std::string {
      if constexpr (std::is_same_v<Value, typename Bare<Value>::Type>)
        return format(options.*Member);
      else
        return options.*Member ? format(*(options.*Member)) : std::string();
    };
    return *this;
  }

  // A text of scene::Inputs, as it is.
  template <auto Member> Row &input(const char *python, const char *example) {
    option.python = python;
    option.example = example;
    option.of_capture = true;
    option.is_planned = false;
    option.set = [name = option.name](Options &options, const std::string &text) {
      if (text.empty()) refuse_value(name, "a value", text);
      options.inputs.*Member = text;
    };
    option.text = [](const Options &options) { return options.inputs.*Member; };
    return *this;
  }

  // Of more than one member.
  Row &custom(const char *python, const char *example, decltype(Option::set) set,
              decltype(Option::text) text) {
    option.python = python;
    option.example = example;
    option.set = std::move(set);
    option.text = std::move(text);
    return *this;
  }

  operator Option() const { return option; }

private:
  Option option;
};

const char *const amount = "int | str", *const length = "float | str", *const size = "str | tuple[int, int]";

std::string amount_text(uint64_t value) {
  return value ? std::to_string(value) : std::string();
}

std::vector<Option> input_options() {
  return {
      Row("meshes", "PATTERN",
          "meshes with %d or %0Nd for the number of the frame ('f/%04d.obj'), from the lowest that is "
          "there; or one for all frames: .obj, .ply, .drc, .draco, .glb, .gltf")
          .input<&scene::Inputs::meshes>("str", "f/%04d.obj")
          .brief(without_capture, "files by frame number: 'f/%04d.obj'"),
      Row("atlas", "PATTERN",
          "pictures of their texture coordinates, likewise, or a video; none; embedded: those that "
          ".glb, .gltf and .obj files bring (default, where there are no cameras)")
          .input<&scene::Inputs::atlas>("str", "f/%04d.png")
          .brief(without_capture, "their textures: 'f/%04d.png'"),
      Row("pictures", "PATTERN",
          "pictures of the cameras of a COLMAP model or transforms.json, with {name} or {id}, and %d; "
          "or videos. Default: those that it names")
          .input<&scene::Inputs::pictures>("str", "{name}/%04d.png"),
      Row("masks", "PATTERN", "silhouettes of the cameras: patterns or videos, as of `pictures`")
          .input<&scene::Inputs::masks>("str", "{name}/%04d.png"),
      Row("fps", "RATE", "frames per second: 30, 30000/1001. Default: 25")
          .custom(
              "float | str", "30000/1001",
              [](Options &options, const std::string &text) {
                options.inputs.frame_duration = scene::parse_frame_rate("fps", text);
              },
              [](const Options &options) {
                const auto &duration = options.inputs.frame_duration;
                if (!duration) return std::string();
                return std::to_string(duration->denominator) +
                       (duration->numerator == 1 ? "" : "/" + std::to_string(duration->numerator));
              })
          .of_capture()
          .unplanned()
          .brief(without_capture, "frames per second. Default: 25"),
      Row("units", "UNIT",
          "of meshes and cameras: metres, centimetres, millimetres, inches, feet, metres per unit, or "
          "unknown. Default: unknown, but of glTF without cameras metres")
          .input<&scene::Inputs::units>("float | str", "centimetres")
          .brief(without_capture, "of meshes and cameras; `up` AXIS"),
      Row("up", "AXIS",
          "axis that points up: +x, -x, +y, -y, +z, -z or unknown. Default: unknown, but of glTF "
          "without cameras +y")
          .input<&scene::Inputs::up>("str", "-y"),
      Row("bake-repeats", "",
          "cut faces on which a texture repeats at the borders of its tiles, so that each piece shows it "
          "once: "
          "more faces. Default: such a face is an error")
          .custom(
              "bool", "on",
              [](Options &options, const std::string &text) {
                if (text != "on" && text != "off") refuse_value("bake-repeats", "on or off", text);
                options.inputs.bake_repeats = text == "on";
              },
              [](const Options &options) { return options.inputs.bake_repeats ? "on" : ""; })
          .of_capture()
          .unplanned(),
  };
}

std::vector<Option> selecting_options() {
  return {
      Row("frames", "A-B", "frame numbers to take: 10-19 or 10..19")
          .text<&Options::frames>(
              "int | str", "10-19",
              [](const auto &name, const auto &text) { return fvv::parse_range(name, text); },
              [](const Range &range) {
                return std::to_string(range.first) + "-" + std::to_string(range.last);
              })
          .of_capture()
          .brief(files, "frame numbers to take"),
      Row("cameras", "A,B-C,NAME", "cameras to take, by identifier, range or name: 0-3,7,overhead")
          .text<&Options::cameras>(
              "int | str | Iterable[int | str]", "0-3,7,overhead",
              [](const auto &, const auto &text) { return parse_list(text); }, list_text)
          .of_capture()
          .list()
          .brief(files, "cameras to take"),
      Row("data", "PATH,...",
          "carry timed data of other formats unchanged: captions of a WebVTT file, or a folder with a file "
          "for each frame, such as splats (docs/encoding/data.md)")
          .text<&Options::data>(
              "str | Sequence[str]", "captions.vtt",
              [](const auto &, const auto &text) { return parse_list(text); }, list_text)
          .of_capture()
          .list(),
      Row("verify", "", "read the file back and compare everything with the capture")
          .flag<&Options::verify>()
          .of_capture()
          .unplanned()
          .brief(files, "read the file back and compare everything with the capture"),
  };
}

std::string parse_objects(const std::string &option, const std::string &text) {
  const std::string ending = ".json";
  const bool is_file =
      text.size() > ending.size() && !text.compare(text.size() - ending.size(), ending.size(), ending);
  if (text != "auto" && !is_file) refuse_value(option, "auto, or a file that ends in .json", text);
  return text;
}

std::vector<Option> mesh_options() {
  return {
      Row("max-error", "ERROR",
          "error of the geometry in pixels of the transmitted pictures, at the camera that sees a place "
          "sharpest, or as a length (1mm, 0.1cm): decides the lattice step, motion and how far meshes are "
          "decimated (docs/encoding/budget.md). Default: by `view-loss`, else 0.15; without cameras 1/8192 "
          "of a mesh's "
          "diagonal, "
          "and "
          "no decimation")
          .text<&Options::max_error>(length, "1mm", parse_max_error, max_error_text)
          .brief(meshes, "pixels of the transmitted pictures, or a length: 1mm"),
      Row("step", "LENGTH",
          "step of the lattice of vertex positions: 1.5mm, 0.002m; plain numbers are metres or the "
          "capture's units. Default: the capture's, else by `max-error`")
          .text<&Options::step>(length, "1.5mm", parse_length, length_text),
      Row("keep-geometry", "", "decimate nothing")
          .flag<&Options::keep_geometry>()
          .brief(meshes, "decimate nothing"),
      Row("triangles", "N", "decimate every frame to this number, at any error")
          .number<&Options::triangles>(1, 1000000000, std::optional(0))
          .excludes("keep-geometry")
          .brief(meshes, "decimate every frame to this number"),
      Row("mesh-profile", "NAME", "draco, raw or fast (more bytes, quick to decode)")
          .words<&Options::mesh_profile, uint8_t>(
              {{"draco", FVV_MESH_DRACO}, {"raw", FVV_MESH_RAW}, {"fast", FVV_MESH_FAST}})
          .brief(meshes, "draco (default), fast (quick to decode) or raw"),
      Row("group", "N", "frames in a group; default: one second")
          .number<&Options::group>(1, 100000, std::optional(0))
          .brief(meshes, "frames in a group: where players can begin. Default: one second"),
      Row("winding", "HOW",
          "of faces: keep (each as it is), flip (turn all of them round), or auto (flip when most of what "
          "cameras see is backfacing: the faces are inside out). Default: neighbours are made to agree, "
          "with a warning in that case")
          .words<&Options::winding, Winding>(
              {{"keep", Winding::keep}, {"flip", Winding::flip}, {"auto", Winding::automatic}})
          .brief(meshes, "keep, flip or auto: for meshes that are inside out"),
      Row("mesh-level", "N", "Draco: 0 is fastest, 10 is smallest. Default: the preset's, 9 of medium")
          .number<&Options::mesh_level>(0, 10),
      Row("normals", "WHEN",
          "send the source's: auto (where more than 1 % of the first mesh's vertices lie on hard edges: "
          "computed from all faces around, their normals are off by more than 20 degrees), always or never")
          .words<&Options::normals, Normals>(
              {{"auto", Normals::automatic}, {"always", Normals::always}, {"never", Normals::never}}),
      Row("texture-bits", "N", "of each texture coordinate, 1 to 16. Default: the capture's, else 12")
          .number<&Options::texture_bits>(1, FVV_TEXTURE_BITS_MAX, std::optional(0)),
      Row("no-delta", "", "every mesh a key frame, also where the faces are those of the frame before")
          .flag<&Options::delta>(false),
      Row("track", "WHEN",
          "follow surfaces whose faces change in every frame, and send runs of frames as motion, with a "
          "patch "
          "where that fails: auto (where it takes fewer bytes), always (on a finer lattice, for long runs) "
          "or never: it takes one to two seconds a frame (docs/encoding/tracking.md). Default: auto with the "
          "preset slow, else never")
          .words<&Options::track, Track>(
              {{"auto", Track::automatic}, {"never", Track::never}, {"always", Track::always}})
          .excludes("keep-geometry")
          .excludes("triangles")
          .excludes("no-delta"),
      Row("objects", "FILE",
          "follow the pieces of the meshes over time, and send the path of each, so that readers know one "
          "from "
          "the other; a JSON file with their names, or auto: they have none (docs/encoding/objects.md)")
          .text<&Options::objects>("str", "names.json", parse_objects,
                                   [](const std::string &text) { return text; })
          .of_capture(),
      Row("min-component", "N", "drop connected pieces with fewer faces")
          .number<&Options::min_component>(0, 1000000000),
  };
}

std::vector<Option> picture_options() {
  return {
      Row("codec", "NAME",
          "jpeg, h264, hevc, vp9, av1, or exr: light beyond white stays as it is, from pictures in OpenEXR")
          .words<&Options::codec, uint32_t>({{"jpeg", FVV_CODEC_JPEG},
                                             {"h264", FVV_CODEC_AVC1},
                                             {"hevc", FVV_CODEC_HVC1},
                                             {"vp9", FVV_CODEC_VP09},
                                             {"av1", FVV_CODEC_AV01},
                                             {"exr", FVV_CODEC_OEXR}})
          .brief(pictures, "h264 (default), hevc, vp9, av1, jpeg, exr"),
      Row("quality", "Q",
          "luma PSNR to reach (42dB), over the foreground when there are masks, or the codec's own "
          "number: JPEG 1 to 100, CRF 1 to 51 in eighths (H.264, HEVC) or 63 (VP9, AV1); OpenEXR has "
          "lossless alone. Default: by `view-loss`, else 42dB, of exr lossless")
          .custom(
              "float | str", "38dB",
              [](Options &options, const std::string &text) {
                options.quality = parse_quality("quality", text);
              },
              [](const Options &options) {
                return options.quality.by_default ? std::string() : quality_text(options.quality);
              })
          .excludes("bitrate")
          .brief(pictures, "PSNR of the foreground (42dB), or the codec's number"),
      Row("view-loss", "DB",
          "choose for the scene what is not set: the quality of pictures, `max-error`, and how players "
          "blend, "
          "for the fewest bytes by which views from between cameras lose at most that against 42dB and 0.15 "
          "px "
          "(0.1dB), with pictures of 38 dB or more; or none (docs/encoding/view-loss.md). Default: 0.1dB, "
          "unless "
          "`quality`, `max-error` or `bitrate` says another goal, the preset is fast or live, or frames come "
          "one after the other")
          .text<&Options::view_loss>("float | str", "0.1dB", parse_view_loss, view_loss_text)
          .brief(pictures, "for what is not set: 0.1dB (default), none"),
      Row("bitrate", "RATE",
          "bits a second for all pictures (4M, 800k) in place of a quality: every group has its share "
          "and gets the finest quality that keeps it; tracks share by their pixels")
          .text<&Options::bit_rate>(amount, "4000000", parse_bit_rate, amount_text)
          .brief(pictures, "bits a second (4M), in place of a quality"),
      Row("scale", "F", "size of every picture as a factor of its source, above 0 and at most 1")
          .text<&Options::scale>("float", "0.75", parse_scale, number_text)
          .brief(pictures, "size of the pictures, above 0 and at most 1; or `tile` WxH"),
      Row("tile", "WxH", "size of every camera's picture in the stream: 480x270")
          .text<&Options::tile>(size, "480x270", parse_tile, size_text)
          .separated_by('x')
          .excludes("scale"),
      Row("ladder", "F,F",
          "send the pictures several times, of which a player takes one, and changes by the bandwidth "
          "that it has, best first: qualities at the full size (42dB,36dB,30dB), which show most for their "
          "bytes; factors of the size (1,0.75,0.5), which also spare players pixels, with a target PSNR "
          "that falls by 9 dB per halving; or bits a second of each (8M,2M,500k); auto: qualities and meshes "
          "by "
          "what views lose of each (docs/encoding/ladder.md)")
          .custom(
              "str | Sequence[float | str]", "1,0.5",
              [](Options &options, const std::string &text) {
                options.ladder_by_views = text == "auto";
                options.ladder.clear();
                if (!options.ladder_by_views) options.ladder = parse_ladder("ladder", text);
              },
              [](const Options &options) {
                return options.ladder_by_views ? std::string("auto") : ladder_text(options.ladder);
              })
          .brief(pictures, "rungs, for players to choose by bandwidth: 42dB,36dB,30dB, or auto"),
      Row("tile-fill", "HOW",
          "of tiles around the silhouette, where there are masks: keep, flat (its colours for 8 px, then "
          "grey), "
          "smooth "
          "(its colours run on everywhere), or auto: smooth for av1, flat for the others")
          .words<&Options::tile_fill, TileFill>({{"auto", TileFill::automatic},
                                                 {"keep", TileFill::keep},
                                                 {"flat", TileFill::flat},
                                                 {"smooth", TileFill::smooth}})
          .formerly("background")
          .brief(pictures, "around the silhouette: auto, keep, flat, smooth"),
      Row("bit-depth", "N",
          "8, or 10 (hevc, vp9, av1): smooth shades without bands, from pictures of 16 bits above "
          "all; exr has 16. Default: the least that the codec has")
          .custom(
              "int", "8",
              [](Options &options, const std::string &text) {
                options.bit_depth = parse_bit_depth("bit-depth", text);
              },
              [](const Options &options) { return amount_text(uint64_t(options.bit_depth)); })
          .brief(pictures, "8, or 10 for smooth shades"),
      Row("video-pixels", "N",
          "of the one frame in which all cropped pictures are packed, at most (300k, 2M): cameras share them "
          "by their usefulness, none gets more than `tile` or `scale` gives. Without it, cameras are spread "
          "over several video tracks when a frame would exceed what decoders take")
          .text<&Options::video_pixels>(amount, "2000000", parse_pixels, amount_text)
          .excludes("video-size")
          .brief(pictures, "of the frame that all cameras share: 2M"),
      Row("video-size", "WxH",
          "of the one frame in which all cropped pictures are packed: at most these sides, "
          "1920x1088")
          .text<&Options::video_size>(size, "1920x1088", parse_video_size, size_text)
          .separated_by('x'),
      Row("video-tracks", "N",
          "spread the cameras over this number of video tracks, neighbours together, or camera: one for "
          "each. Players can then leave out what a viewpoint does not need (docs/encoding/tiles.md)")
          .text<&Options::video_tracks>("int | Literal[\"camera\"]", "camera", parse_video_tracks,
                                        video_tracks_text)
          .excludes("video-pixels")
          .excludes("video-size"),
      Row("mesh-ladder", "WHEN",
          "coarser meshes for lower rungs, whose pixels are larger: auto where they save 5 % of a "
          "rung, on or off")
          .words<&Options::mesh_ladder, MeshLadder>(
              {{"auto", MeshLadder::automatic}, {"on", MeshLadder::on}, {"off", MeshLadder::off}})
          .needs("ladder"),
      Row("atlas-scale", "F",
          "size of the atlas in the stream as a factor, above 0 and at most 1; rounded to even sides "
          "but for JPEG")
          .text<&Options::atlas_scale>("float", "0.5", parse_scale, number_text),
      Row("crop", "HOW",
          "auto: of each camera's picture what is seen of the scene in a group of frames, by its masks, else "
          "by the mesh; none: whole pictures (docs/encoding/tiles.md)")
          .words<&Options::crop, Crop>({{"auto", Crop::automatic}, {"none", Crop::none}}),
      Row("undistort", "",
          "resample the pictures of cameras with a lens to cameras without (docs/tools/calibration.md)")
          .flag<&Options::undistort>(),
      Row("undistort-alpha", "F",
          "how much they show: 0, the most that leaves no pixel blank; 1, all that the lens shows")
          .number<&Options::undistort_alpha>(0.0, 1.0)
          .needs("undistort"),
  };
}

std::vector<Option> texturing_options() {
  return {
      Row("visibility", "HOW",
          "send what cameras see: auto (weight, unless it takes more than a tenth of the pictures' bytes, or "
          "one camera is alone), weight (a visibility weight of each vertex and camera) or none "
          "(docs/encoding/visibility.md)")
          .words<&Options::visibility, Visibility>(
              {{"auto", Visibility::automatic}, {"weight", Visibility::weights}, {"none", Visibility::none}}),
      Row("colours", "HOW",
          "send a colour of low resolution for all of the surface, which is shown where no camera sees it, "
          "and by players that cannot decode the pictures: auto (where there are meshes and pictures of "
          "cameras, or colours of the meshes' vertices, and no atlas), on, off, or about how many cells of "
          "one colour the first mesh has "
          "(docs/encoding/colours.md)")
          .custom(
              "bool | int | Literal[\"auto\", \"on\", \"off\"]", "2000",
              [](Options &options, const std::string &text) { parse_colours("colours", text, options); },
              colours_text),
      Row("match-colours", "WHEN",
          "correct the pictures of cameras whose exposure or white balance differs, by the surface that they "
          "see in common: auto (where two cameras differ by more than 3 % and gains take away at least half "
          "of that), on or off (docs/encoding/match.md)")
          .words<&Options::match_colours, MatchColours>(
              {{"auto", MatchColours::automatic}, {"on", MatchColours::on}, {"off", MatchColours::off}}),
      Row("texture-threshold", "F",
          "tell players the least cosine between normal and ray for which they take a camera's colour; "
          "visibility is found for it. Players' default: that of the blend, 0.05 or 0.25")
          .number<&Options::texture_threshold>(0.0, 1.0),
      Row("texture-best", "N",
          "tell players how many cameras to mix at a place, at most. Players' default: 3")
          .number<&Options::texture_best>(1, 255),
      Row("texture-blend", "HOW",
          "tell players how to weight cameras: viewer (by the viewer's direction, players' default) or "
          "paper (by the normal alone, as WHP 235)")
          .words<&Options::texture_blend, uint32_t>(
              {{"viewer", FVV_BLEND_VIEWER}, {"paper", FVV_BLEND_PAPER}}),
      Row("texture-unseen", "R,G,B",
          "tell players the colour of surface that no camera shows, R,G,B. Players' default: 128,128,128")
          .text<&Options::texture_unseen>("str | tuple[int, int, int]", "255,0,128", parse_colour,
                                          colour_text),
      Row("texture-depth-bias", "F",
          "tell players that make depth maps by how much a place may lie behind one and still be "
          "seen, in widths of a pixel. Players' default: 0.2")
          .number<&Options::texture_depth_bias>(0.0, 1e6),
      Row("texture-depth-slope", "F",
          "tell players that make depth maps by how much more it may lie behind: times what the surface "
          "recedes from one pixel to the next. Players' default: 0.5")
          .number<&Options::texture_depth_slope>(0.0, 1e6),
      Row("texture-inset", "LENGTH",
          "tell players how far inside the mesh the surface lies that cameras show: auto (found by "
          "drawing cameras from the others), off, or a length such as 3mm (docs/encoding/inset.md)")
          .custom(
              "float | Literal[False] | str", "0.003",
              [](Options &options, const std::string &text) {
                options.texture_inset = parse_inset("texture-inset", text);
              },
              [](const Options &options) { return inset_text(options.texture_inset); }),
  };
}

std::vector<Option> other_options() {
  return {
      Row("no-pictures", "", "leave the pictures out, those of the atlas too")
          .flag<&Options::pictures>(false)
          .brief(left_out, "and `no-meshes`, `no-environment`, `no-sound`"),
      Row("no-meshes", "", "leave the meshes out").flag<&Options::meshes>(false),
      Row("no-environment", "", "leave the static environment out, lights and all")
          .flag<&Options::environment>(false)
          .formerly("no-background"),
      Row("no-sound", "", "leave the sound out").flag<&Options::sound>(false).formerly("no-audio"),
      Row("skip-bad-frames", "",
          "leave out frames with a mesh, picture or mask that cannot be used, and name them; exit code 3. "
          "All "
          "files are read once more for it (docs/encoding/frames.md)")
          .flag<&Options::skip_bad_frames>()
          .of_capture()
          .brief(left_out, "frames that cannot be used are left out and named, with exit code 3"),
      Row("sound-bitrate", "RATE",
          "bits a second of each track of sound (96k), encoded as Opus. Default: Opus and AAC-LC stay as "
          "they are; other sound has 64k for one channel, 48k a channel for more (docs/encoding/sound.md)")
          .text<&Options::sound_bit_rate>(amount, "96000", parse_audio_bit_rate, amount_text)
          .formerly("audio-bitrate")
          .excludes("no-sound"),
      Row("sound-channels", "N",
          "of sound that is encoded, at most: more are mixed down; sound with a place in the scene has one")
          .number<&Options::sound_channels>(1, int(media::max_sound_channels))
          .formerly("audio-channels")
          .excludes("no-sound"),
      Row("threads", "N", "threads; the bytes are the same for any number. Default: one for each processor")
          .number<&Options::threads>(1, 256, std::optional(1))
          .unplanned()
          .brief(running, "the bytes are the same for any number"),
      Row("max-memory", "SIZE",
          "that decoding one file of the capture may take, a picture, a video, a mesh or sound: bytes, or "
          "with "
          "K, M or G (512M). A file that needs more is refused (docs/encoding/memory.md)")
          .text<&Options::max_memory>(amount, "512M", parse_bytes, media::memory_text)
          .of_capture(),
      Row("preset", "NAME",
          "how long encoding may take: live, fast, medium or slow. slow also follows surfaces (`track`); "
          "fast and "
          "live send no visibility and no colours of the pictures for vertices, and measure some or none of "
          "the "
          "decimated meshes. Options that are given hold (docs/encoding/presets.md). Default: medium")
          .words<&Options::preset, Preset>({{"live", Preset::live},
                                            {"fast", Preset::fast},
                                            {"medium", Preset::medium},
                                            {"slow", Preset::slow}})
          .brief(running, "live, fast, medium (default) or slow: time against bytes"),
      Row("live", "", "no index and no footer")
          .flag<&Options::live>()
          .brief(running, "no index and no footer"),
      Row("repeat-configuration", "",
          "configuration before every group, for late joiners; the environment in every group too")
          .flag<&Options::repeat_configuration>(),
  };
}

// Whether an option differs from its default.
bool is_set(const Option &option, const Options &options) {
  static const Options defaults;
  return option.text(options) != option.text(defaults);
}

void check_rows(const Options &options) {
  for (const Option &option : option_table()) {
    if (!is_set(option, options)) continue;
    for (const std::string &other : option.excludes)
      if (is_set(*find_option(other), options))
        refuse_option(option.name, "expected without " + option_name(other) + ", found both");
    for (const std::string &other : option.needs)
      if (!is_set(*find_option(other), options))
        refuse_option(option.name, "expected with " + option_name(other) + ", found alone");
  }
}

} // namespace

const std::vector<Option> &option_table() {
  static const std::vector<Option> table = [] {
    std::vector<Option> all;
    for (const auto &part : {selecting_options(), input_options(), mesh_options(), picture_options(),
                             texturing_options(), other_options()})
      all.insert(all.end(), part.begin(), part.end());
    return all;
  }();
  return table;
}

const Option *find_option(std::string_view name) {
  for (const Option &option : option_table())
    if (name == option.name || (!option.former.empty() && name == option.former)) return &option;
  return nullptr;
}

void set_option(Options &options, std::string_view name, std::string_view value) {
  const Option *const option = find_option(name);
  if (!option) throw Error("there is no option " + option_name(name), Error::usage);
  option->set(options, std::string(value));
}

Options settled(Options options) {
  check_rows(options);
  if (!options.ladder.empty() && (options.ladder[0].bit_rate || options.ladder[0].psnr) &&
      (!options.quality.by_default || options.bit_rate))
    refuse_option("ladder", std::string("with ") + (options.ladder[0].psnr ? "a quality" : "bits a second") +
                                " of each rung there is no " + option_name("quality") + " and no " +
                                option_name("bitrate"));
  if (options.bit_rate && options.codec == FVV_CODEC_OEXR)
    refuse_option("bitrate", "video in OpenEXR is lossless and keeps no bit rate");
  scene::check_inputs(options.inputs);
  fill_in(options);
  return options;
}

static_assert(Options::default_max_memory == media::default_memory_limit, "that of all tools");

media::MemoryLimit memory_limit_of(const Options &options) {
  return {options.max_memory, option_name("max-memory")};
}

} // namespace fvv::mux
