#include "fvvdemux/group.h"
#include "fvv_cxx/owned.h"
#include "fvv_demux/meshes.h"
#include "fvv_demux/picture_decoder.h"
#include "fvv_demux/views.h"
#include "fvv_media/exr.h"
#include "fvv_media/frame.h"
#include "fvv_media/video.h"
#include "fvv_scene/mesh_file.h"

#include <cmath>
#include <optional>
#include <variant>

namespace fvv::demux {

Pictures files_of(Pictures wanted, const fvv_video_config &config) {
  if (wanted != Pictures::automatic) return wanted;
  return config.codec == FVV_CODEC_OEXR ? Pictures::exr : Pictures::png;
}

const char *extension_of(Pictures pictures) {
  return pictures == Pictures::png ? "png" : pictures == Pictures::exr ? "exr" : "jpg";
}

namespace {

const char *extension_of(Meshes meshes) {
  return meshes == Meshes::ply   ? "ply"
         : meshes == Meshes::obj ? "obj"
         : meshes == Meshes::drc ? "drc"
                                 : "glb";
}

// Returns why a frame is lost; other failures than errors of the stream end the run.
std::string why_lost(fvv_status status, const fvv_diagnostic &diagnostic) {
  if (status > FVV_ERROR_DAMAGED) fvv::check(status, "memory or input", diagnostic);
  return diagnostic.status ? text_of(diagnostic) : fvv_status_text(status);
}

// Of 16 bits when the video has more than 8 and pictures are written as PNG; linear light for OpenEXR.
Samples samples_for(Pictures files, int bit_depth) {
  if (files == Pictures::exr) return Samples::linear;
  return files == Pictures::png && bit_depth > 8 ? Samples::sixteen_bits : Samples::eight_bits;
}

struct PictureTrack {
  VideoViews shown;
  PictureDecoder decoder;

  PictureTrack(const VideoViews &track, Pictures pictures)
      : shown(track), decoder(*track.video, samples_for(files_of(pictures, track.video->config),
                                                        track.video->config.bit_depth)) {}
};

class GroupDecoder {
public:
  GroupDecoder(fvv_stream *opened, const fvv_configuration &configuration, const Options &chosen,
               size_t first_frame, const FileName &file_name, cli::OutputFolder &to)
      : stream(opened), configured(configuration), first(first_frame), scene(configuration.scene),
        options(chosen), name(file_name), folder(to) {
    for (size_t i = 0; i < configuration.camera_count; i++) {
      const fvv_camera &camera = configuration.cameras[i];
      if (camera.flags & FVV_CAMERA_MOVES && options.cameras.has(camera.id)) moving.push_back(camera.id);
    }
    if (options.meshes != Meshes::none)
      if (const fvv_track *track = mesh_track_of(configuration, options.rung, nullptr))
        mesh_track = track->id;
    if (options.pictures != Pictures::none)
      for (const VideoViews &track : views_of(configuration, options.rung, options.cameras, nullptr))
        tracks.emplace_back(track, options.pictures);
  }

  // The places of pictures in the frames of this group: before any is unpacked.
  fvv_status find_tiles(size_t group, fvv_diagnostic &diagnostic) {
    for (const PictureTrack &track : tracks)
      for (const View &view : track.shown.views) {
        std::optional<fvv_tile> tile;
        const fvv_status status = tile_in_group(stream, group, *track.shown.video, view, tile, diagnostic);
        if (status < 0) return status;
        if (tile) tiles[view.tile.camera_id] = *tile;
      }
    return FVV_OK;
  }

  const std::map<uint16_t, uint64_t> &pictures() const { return written; }
  bool are_local() const { return any_local; } // positions of glTF files, as MeshRun has it

  // Why the frame is lost, or "". Frames before it that are not wanted need no call.
  std::string unpack(size_t frame, int64_t number, WrittenFrame &out) {
    fvv_frame info;
    fvv_diagnostic diagnostic = {};
    const fvv_status status = fvv_stream_frame(stream, frame, &info, &diagnostic);
    if (status < 0) return why_lost(status, diagnostic);
    std::string why;
    // All tracks continue even if one has lost the frame: later frames need them.
    std::vector<std::shared_ptr<const VideoFrame>> pictures;
    for (PictureTrack &track : tracks) {
      const fvv_status decoded = track.decoder.decode(stream, first, frame);
      if (decoded > FVV_ERROR_DAMAGED) fvv::check(decoded, "memory or input", track.decoder.diagnostic());
      if (decoded < 0 && why.empty()) why = track.decoder.why();
      pictures.push_back(track.decoder.frame());
    }
    OwnedMesh mesh;
    bool has_mesh = false;
    if (mesh_track) {
      const fvv_status decoded = fvv_stream_mesh(stream, frame, *mesh_track, &mesh, &diagnostic);
      if (decoded < 0) return why_lost(decoded, diagnostic);
      has_mesh = decoded == FVV_OK;
    }
    std::vector<uint8_t> colours;
    if (has_mesh) {
      const fvv_status found = colours_of(stream, configured, frame, *mesh_track, colours, diagnostic);
      if (found < 0) return why_lost(found, diagnostic);
    }
    if (!why.empty()) return why;
    const bool empty = mesh_track && !has_mesh && !has_valid_mesh(frame);
    const int64_t end = fvv_stream_group(stream, info.group)->end;
    out = {number, info.time, end, has_mesh, empty, mesh.texture_bits, has_mesh == (mesh_track && !empty),
           {}};
    for (const uint16_t id : moving) {
      fvv_camera camera;
      const fvv_status found = fvv_stream_camera(stream, frame, id, &camera, &diagnostic);
      if (found < 0) return why_lost(found, diagnostic);
      camera.name = nullptr;
      camera.name_size = 0;
      if (found == FVV_OK) out.moving[id] = camera;
    }
    if (has_mesh) write(mesh, colours, number, pictures);
    for (size_t i = 0; i < tracks.size(); i++)
      if (pictures[i])
        std::visit([&](const auto &picture) { write(tracks[i].shown, picture, number); }, *pictures[i]);
      else
        out.complete = false;
    return "";
  }

private:
  // The track whose pictures show the atlas, and the view of it; NULL: the frame has no picture of it.
  std::pair<size_t, const View *>
  atlas_of(const std::vector<std::shared_ptr<const VideoFrame>> &pictures) const {
    for (size_t i = 0; i < tracks.size(); i++)
      for (const View &view : tracks[i].shown.views)
        if (pictures[i] && view.tile.camera_id == no_camera) return {i, &view};
    return {0, nullptr};
  }
  const char *picture_extension(size_t track) const {
    return extension_of(files_of(options.pictures, tracks[track].shown.video->config));
  }

  void write(const fvv_mesh &coded, const std::vector<uint8_t> &colours, int64_t number,
             const std::vector<std::shared_ptr<const VideoFrame>> &pictures) {
    const geometry::Lattice lattice = lattice_of(scene.lattice_origin, scene.lattice_step);
    const std::string file = name("meshes", number, extension_of(options.meshes));
    const auto [track, atlas] = atlas_of(pictures);
    if (options.meshes == Meshes::gltf) return; // once all frames are known
    if (options.meshes == Meshes::glb) {
      std::string texture;
      // glTF knows PNG and JPEG alone.
      if (atlas && coded.texture && !std::holds_alternative<media::LinearImage>(*pictures[track]))
        texture = std::visit(
            [&, view = atlas](const auto &picture) {
              const std::vector<uint8_t> bytes = file_of(picture_of(*view, picture));
              return std::string(bytes.begin(), bytes.end());
            },
            *pictures[track]);
      scene::MeshRun run;
      append_frame(coded, colours, 0, "", run);
      bool is_local = false;
      folder.write(file, format_glb(std::move(run), lattice, scene.up_axis, texture, options.compression,
                                    folder.shown(file), &is_local));
      any_local = any_local || is_local;
      return;
    }
    const geometry::Mesh mesh = in_metres(coded, lattice);
    std::string bytes = scene::format_mesh(mesh, lattice, folder.shown(file), colours);
    if (options.meshes == Meshes::obj && atlas && !mesh.texture.empty()) {
      const std::string material = name("meshes", number, "mtl");
      const std::string texture = name(atlas->folder, number, picture_extension(track));
      folder.write(material, "newmtl frame\nKa 1 1 1\nKd 1 1 1\nillum 0\nmap_Kd ../" + texture + "\n");
      bytes.insert(0, "mtllib " + material.substr(material.rfind('/') + 1) + "\nusemtl frame\n");
    }
    folder.write(file, bytes);
  }
  std::vector<uint8_t> file_of(const media::Image &picture) const {
    return options.pictures != Pictures::jpg
               ? media::encode_png(picture)
               : media::encode_jpeg(picture, options.quality, media::Subsampling::yuv420);
  }
  std::vector<uint8_t> file_of(const media::DeepImage &picture) const { return media::encode_png(picture); }
  std::vector<uint8_t> file_of(const media::LinearImage &picture) const {
    return media::encode_half_exr(picture);
  }

  template <class Sample>
  media::BasicImage<Sample> picture_of(const View &view, const media::BasicImage<Sample> &frame) const {
    const auto tile = tiles.find(view.tile.camera_id);
    return whole_picture(frame, tile == tiles.end() ? nullptr : &tile->second, view.whole);
  }

  template <class Sample>
  void write(const VideoViews &track, const media::BasicImage<Sample> &picture, int64_t number) {
    for (const View &view : track.views) {
      const std::vector<uint8_t> bytes = file_of(picture_of(view, picture));
      folder.write(name(view.folder, number, extension_of(files_of(options.pictures, track.video->config))),
                   {reinterpret_cast<const char *>(bytes.data()), bytes.size()});
      written[view.tile.camera_id]++;
    }
  }

  // That of an earlier frame of the group (fvv.md clause 11).
  bool has_valid_mesh(size_t frame) const {
    OwnedMesh unused;
    fvv_diagnostic diagnostic = {};
    while (frame > first)
      if (fvv_stream_mesh(stream, --frame, *mesh_track, &unused, &diagnostic) != FVV_END) return true;
    return false;
  }

  fvv_stream *stream;
  const fvv_configuration &configured;
  const size_t first; // frame of the group
  const fvv_scene scene;
  const Options &options;
  const FileName &name;
  cli::OutputFolder &folder;
  std::optional<uint16_t> mesh_track;
  std::vector<PictureTrack> tracks;
  std::map<uint16_t, fvv_tile> tiles;   // of cameras in this group
  std::vector<uint16_t> moving;         // cameras
  std::map<uint16_t, uint64_t> written; // pictures, by camera
  bool any_local = false;
};

void lose(std::vector<Loss> &losses, int64_t first, int64_t last, const std::string &why) {
  if (!losses.empty() && losses.back().last + 1 == first && losses.back().why == why)
    losses.back().last = last;
  else
    losses.push_back({first, last, why});
}

} // namespace

bool writes_track(const fvv_configuration &configuration, const fvv_track &track, size_t rung) {
  const bool is_written = track.kind == FVV_TRACK_MESH || track.kind == FVV_TRACK_VIDEO ||
                          track.kind == FVV_TRACK_CALIBRATION ||
                          (track.kind == FVV_TRACK_COLOURS && !configuration.video_count);
  return is_written && in_rung(configuration, track.id, rung);
}

GroupResult unpack_group(fvv_stream *stream, const GroupPlan &plan, const Options &options,
                         LazySurvey &survey, const FileName &name, cli::OutputFolder &folder) {
  GroupResult result;
  const auto chosen = options.frames.within(plan.number, plan.number + plan.count - 1);
  // Reading the first frame loads the group's table, and only then it is known whether that is valid.
  fvv_frame first;
  fvv_diagnostic diagnostic = {};
  const fvv_status loaded = fvv_stream_group(stream, plan.group)->frame_count
                                ? fvv_stream_frame(stream, plan.frame, &first, &diagnostic)
                                : FVV_OK;
  if (loaded < 0 && loaded > FVV_ERROR_DAMAGED) fvv::check(loaded, "memory or input", diagnostic);
  const fvv_group_info &group = *fvv_stream_group(stream, plan.group);
  const fvv_configuration *configuration = nullptr;
  const auto lose_all = [&](fvv_status status) {
    for (const auto &range : chosen)
      lose(result.losses, range.first, range.last, why_lost(status, diagnostic));
    return result;
  };
  const fvv_status configured = fvv_stream_configuration(stream, plan.group, &configuration, &diagnostic);
  if (configured < 0) return lose_all(configured);
  int64_t whole = plan.count;
  std::string behind_whole;
  if (!plan.complete || !group.intact) {
    const Survey::Group surveyed = survey.group(group.offset);
    if (surveyed.whole < uint64_t(whole)) whole = int64_t(surveyed.whole);
    behind_whole = surveyed.reason.status ? text_of(surveyed.reason) : "the stream ends within its group";
  }
  GroupDecoder decoder(stream, *configuration, options, plan.frame, name, folder);
  const fvv_status found = decoder.find_tiles(plan.group, diagnostic);
  if (found < 0) return lose_all(found);
  const int64_t last = chosen.back().last - plan.number;
  for (int64_t i = 0; i <= last && i < whole; i++) {
    const int64_t number = plan.number + i;
    if (!options.frames.has(number)) continue;
    WrittenFrame written;
    const std::string why = decoder.unpack(plan.frame + size_t(i), number, written);
    if (why.empty())
      result.frames.push_back(written);
    else
      lose(result.losses, number, number, why);
  }
  result.pictures = decoder.pictures();
  result.local_origin = decoder.are_local();
  for (const auto &range : options.frames.within(plan.number + whole, plan.number + plan.count - 1))
    lose(result.losses, range.first, range.last, behind_whole);
  return result;
}

} // namespace fvv::demux
