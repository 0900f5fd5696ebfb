#include "fvv_view/frame.h"

#include "fvv_cxx/owned.h"
#include "fvv_demux/frame_plan.h"
#include "fvv_demux/meshes.h"
#include "fvv_demux/picture_decoder.h"
#include "fvv_demux/views.h"
#include "fvv_media/colour.h"
#include "fvv_media/frame.h"
#include "fvv_media/video.h"
#include "fvv_render/local_origin.h"

#include <algorithm>

namespace fvv::view {

namespace {

void add(const fvv_visibility &found, std::vector<CameraWeights> &out) {
  const size_t count = found.header.vertex_count;
  for (size_t i = 0; i < found.header.camera_count; i++) {
    CameraWeights camera = {found.cameras[i], std::vector<uint8_t>(count)};
    if (std::any_of(out.begin(), out.end(), [&](const auto &c) { return c.camera == camera.camera; }))
      continue;
    fvv_visibility_weights(found.states + i * count, count, camera.weights.data());
    out.push_back(std::move(camera));
  }
}

// Of all visibility tracks of mesh, which is that of the frame on that track; of a camera in two of them the
// first one is used. A track that is lost or unknown adds a line to losses. where: the beginning of these
// lines. Throws Error when reading fails.
std::vector<CameraWeights> load_visibility(fvv_stream *stream, size_t frame,
                                           const fvv_configuration &configuration, size_t rung,
                                           uint16_t mesh_track, const std::string &where,
                                           std::vector<std::string> &losses) {
  std::vector<uint16_t> tracks;
  for (size_t i = 0; i < configuration.track_count; i++)
    if (configuration.tracks[i].kind == FVV_TRACK_VISIBILITY &&
        in_rung(configuration, configuration.tracks[i].id, rung))
      tracks.push_back(configuration.tracks[i].id);
  std::vector<CameraWeights> out;
  for (const uint16_t track : tracks) {
    const fvv_visibility *found = nullptr;
    fvv_diagnostic diagnostic = {};
    const fvv_status status = fvv_stream_visibility(stream, frame, track, &found, &diagnostic);
    if (status < 0 && status > FVV_ERROR_DAMAGED) fvv::check(status, where, diagnostic);
    if (status < 0)
      losses.push_back(where + ": no visibility of track " + std::to_string(track) +
                       ", depth maps take its place: " + demux::text_of(diagnostic));
    else if (status == FVV_OK && found->header.mesh_track == mesh_track)
      add(*found, out);
  }
  return out;
}

// The place of a frame: those of its group before it may be needed to decode it.
struct Place {
  size_t group, first, frame;
};

Place find(fvv_stream *stream, const InputFile &file, int64_t number, const fvv_limits *limits) {
  demux::LazySurvey survey(file, limits);
  const std::string text = std::to_string(number);
  const demux::Plan plan = demux::make_plan(stream, file, demux::Selection::parse("frame", text), survey);
  for (const demux::GroupPlan &group : plan.groups)
    if (number >= group.number && number < group.number + group.count)
      return {group.group, group.frame, group.frame + size_t(number - group.number)};
  for (const demux::Loss &loss : plan.losses)
    if (number >= loss.first && number <= loss.last)
      throw Error(file.path() + ": frame " + text + " is lost: " + loss.why);
  throw Error(option_name("frame") + ": frame " + text + " is not in the stream, which has " +
                  std::to_string(plan.count),
              Error::usage);
}

media::BasicImage<float> display_values(media::LinearImage image) {
  for (float &value : image.pixels) value = float(media::srgb_of_linear(double(value)));
  return image;
}

std::shared_ptr<const render::EnvironmentImage> environment_image(const std::string &file) {
  media::Image image = media::decode_image(reinterpret_cast<const uint8_t *>(file.data()), file.size(), 3,
                                           "picture of the environment");
  auto out = std::make_shared<render::EnvironmentImage>();
  *out = {image.width, image.height, std::move(image.pixels)};
  return out;
}

render::EnvironmentPart
environment_part(const scene::EnvironmentPart &source, const render::Vec3 &origin,
                 const std::vector<std::shared_ptr<const render::EnvironmentImage>> &pictures) {
  render::EnvironmentPart out;
  out.positions = render::positions_from(origin, source.mesh.positions);
  out.faces = source.mesh.faces;
  out.texture = source.mesh.texture;
  if (source.picture) out.picture = pictures[*source.picture];
  out.colour = {source.colour[0], source.colour[1], source.colour[2]};
  out.double_sided = source.double_sided;
  out.clamped = source.clamped;
  return out;
}

class Loader {
public:
  Loader(const InputFile &the_file, int64_t the_number, const LoadOptions &options)
      : file(the_file), number(the_number), stream(demux::open_stream(file, options.limits)),
        place(find(stream.get(), file, number, options.limits)),
        where(file.path() + ": frame " + std::to_string(number)), memory(options.memory), rung(options.rung) {
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_stream_configuration(stream.get(), place.group, &configuration, &diagnostic), where,
               diagnostic);
  }

  Frame load(bool pictures) {
    Frame out;
    out.file = file.path();
    out.number = number;
    out.up = configuration->scene.up_axis;
    out.origin = render::local_origin(configuration->scene.lattice_origin, configuration->scene.lattice_step);
    out.texturing = configuration->texturing;
    load_cameras(out);
    load_mesh(out);
    std::vector<demux::VideoViews> tracks;
    if (pictures) tracks = demux::views_of(*configuration, rung, {}, nullptr);
    for (const demux::VideoViews &track : tracks) demux::decoding_memory(where, {track}, memory);
    for (const demux::VideoViews &track : tracks) load_track(track, out);
    load_environment(out);
    return out;
  }

private:
  // The name is the configuration's, which does not outlive the stream.
  static fvv_camera nameless(fvv_camera camera) {
    camera.name = nullptr;
    camera.name_size = 0;
    return camera;
  }

  // A moving camera without calibration in this frame is absent (fvv.md, clause 9.6).
  void load_cameras(Frame &out) {
    for (size_t i = 0; i < configuration->camera_count; i++) {
      fvv_camera camera;
      fvv_diagnostic diagnostic = {};
      const fvv_status status =
          fvv_stream_camera(stream.get(), place.frame, configuration->cameras[i].id, &camera, &diagnostic);
      fvv::check(status, where, diagnostic);
      if (status != FVV_END) out.cameras.push_back(render::camera_from(out.origin, nameless(camera)));
    }
  }

  void load_mesh(Frame &out) {
    const fvv_track *track = demux::mesh_track_of(*configuration, rung, nullptr);
    if (!track) throw Error(where + ": the stream has no meshes");
    OwnedMesh mesh;
    fvv_diagnostic diagnostic = {};
    // A mesh is valid until the next one of its group (fvv.md clause 11); before the first the stage is
    // empty.
    size_t frame = place.frame + 1;
    fvv_status status = FVV_END;
    while (status == FVV_END && frame > place.first)
      status = fvv_stream_mesh(stream.get(), --frame, track->id, &mesh, &diagnostic);
    fvv::check(status, where, diagnostic);
    if (status == FVV_END) return;
    out.positions.resize(3 * size_t(mesh.vertex_count));
    const double *lattice = configuration->scene.lattice_origin;
    const double origin[3] = {lattice[0] - out.origin.x, lattice[1] - out.origin.y,
                              lattice[2] - out.origin.z};
    fvv_lattice_to_floats(origin, configuration->scene.lattice_step, mesh.lattice, mesh.vertex_count,
                          out.positions.data());
    out.faces.assign(mesh.faces, mesh.faces + 3 * size_t(mesh.face_count));
    if (mesh.normals || mesh.texture) load_normals(mesh, out);
    out.bits = load_visibility(stream.get(), frame, *configuration, rung, track->id, where, out.losses);
    load_colours(frame, track->id, out);
  }

  void load_colours(size_t frame, uint16_t mesh_track, Frame &out) {
    const uint8_t *colours = nullptr;
    uint32_t count = 0;
    fvv_diagnostic diagnostic = {};
    const fvv_status status =
        fvv_stream_colours(stream.get(), frame, mesh_track, &colours, &count, &diagnostic);
    if (status < 0 && status > FVV_ERROR_DAMAGED) fvv::check(status, where, diagnostic);
    if (status < 0) out.losses.push_back(where + ": no colours of vertices: " + demux::text_of(diagnostic));
    if (status == FVV_OK) out.colours.assign(colours, colours + 3 * size_t(count));
  }

  // Those that are sent; else computed, but as one over the seams of an atlas (fvv.md, clause 8.12). Without
  // either, the renderer's own are the same.
  void load_normals(const fvv_mesh &mesh, Frame &out) const {
    std::vector<float> normals(3 * size_t(mesh.vertex_count));
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_mesh_normals(&mesh, nullptr, normals.data(), &diagnostic), where, diagnostic);
    for (size_t i = 0; i < normals.size(); i += 3)
      out.normals.push_back({normals[i], normals[i + 1], normals[i + 2]});
  }

  // The tile of the camera in the frames of the group; returns why it is lost, or "".
  std::string find_tile(const fvv_video_layout &video, const demux::View &view,
                        std::optional<fvv_tile> &tile) {
    fvv_diagnostic diagnostic = {};
    const fvv_status status = demux::tile_in_group(stream.get(), place.group, video, view, tile, diagnostic);
    if (status < 0 && status > FVV_ERROR_DAMAGED) fvv::check(status, where, diagnostic);
    return status < 0 ? demux::text_of(diagnostic) : "";
  }

  void load_track(const demux::VideoViews &track, Frame &out) {
    const bool wide = track.video->config.codec == FVV_CODEC_OEXR;
    demux::PictureDecoder decoder(*track.video, wide ? demux::Samples::linear : demux::Samples::sixteen_bits);
    const fvv_status status = decoder.decode(stream.get(), place.first, place.frame);
    if (status < 0 && status > FVV_ERROR_DAMAGED) fvv::check(status, where, decoder.diagnostic());
    std::string why = status == FVV_END ? "track " + std::to_string(track.video->track) + " has none"
                      : status < 0      ? decoder.why()
                                        : "";
    media::DeepImage picture;
    media::BasicImage<float> wide_picture;
    if (why.empty() && wide) wide_picture = display_values(std::get<media::LinearImage>(*decoder.frame()));
    if (why.empty() && !wide) picture = std::get<media::DeepImage>(*decoder.frame());
    for (const demux::View &view : track.views) {
      const fvv_camera *camera = out.camera(view.tile.camera_id);
      if (!camera) continue; // an atlas, or not calibrated
      std::optional<fvv_tile> tile;
      if (why.empty()) why = find_tile(*track.video, view, tile);
      if (why.empty() && !tile) continue; // no picture in this group
      if (why.empty()) {
        Picture one = {};
        one.camera = fvv_camera_of_tile(camera, &*tile);
        if (wide)
          one.wide = media::extract(wide_picture, *tile);
        else
          one.image = media::extract(picture, *tile);
        out.pictures.push_back(std::move(one));
      } else {
        out.losses.push_back(where + ": no picture of camera " + std::to_string(camera->id) + ": " + why);
      }
    }
  }

  void check_picture(const std::string &bytes) const {
    fvv_environment_picture picture = {};
    picture.data = reinterpret_cast<const uint8_t *>(bytes.data());
    picture.size = bytes.size();
    if (fvv_environment_picture_inspect(&picture, nullptr) != FVV_OK) return; // decoding gives the reason
    // 8 bits as they are unpacked, and as they are kept.
    media::check_memory(where + ": decoding a picture of the environment of " +
                            std::to_string(picture.width) + " x " + std::to_string(picture.height) +
                            " pixels",
                        uint64_t(picture.width) * picture.height * 6, memory);
  }

  void load_environment(Frame &out) {
    std::vector<std::string> lost;
    const scene::Environment source =
        demux::unpack_environment(stream.get(), place.group, *configuration, lost).environment;
    for (const std::string &why : lost) out.losses.push_back(where + ": no environment: " + why);
    for (const std::string &picture : source.pictures) check_picture(picture);
    try {
      std::vector<std::shared_ptr<const render::EnvironmentImage>> pictures;
      for (const std::string &one : source.pictures) pictures.push_back(environment_image(one));
      for (const scene::EnvironmentPart &part : source.parts)
        out.environment.push_back(environment_part(part, out.origin, pictures));
    } catch (const Error &error) {
      out.environment.clear();
      out.losses.push_back(where + ": no environment: " + error.what());
    }
  }

  const InputFile &file;
  const int64_t number;
  const demux::Stream stream;
  const Place place;
  const std::string where;
  const media::MemoryLimit memory;
  const size_t rung;
  const fvv_configuration *configuration = nullptr;
};

} // namespace

const fvv_camera *Frame::camera(uint16_t id) const {
  const auto found = std::find_if(cameras.begin(), cameras.end(), [&](const auto &c) { return c.id == id; });
  return found == cameras.end() ? nullptr : &*found;
}

const CameraWeights *Frame::bits_of(uint16_t camera) const {
  const auto found =
      std::find_if(bits.begin(), bits.end(), [&](const auto &b) { return b.camera == camera; });
  return found == bits.end() ? nullptr : &*found;
}

std::string Frame::camera_ids() const {
  std::string out;
  for (const fvv_camera &camera : cameras) out += (out.empty() ? "" : ", ") + std::to_string(camera.id);
  return out.empty() ? "none" : out;
}

Frame load_frame(const InputFile &file, int64_t number, const LoadOptions &options) {
  return Loader(file, number, options).load(options.pictures);
}

} // namespace fvv::view
