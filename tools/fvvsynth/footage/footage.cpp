// The three takes, and the truth about them.
#include "fvvsynth/footage/footage.h"

#include "cli/cli.h"
#include "fvv_cxx/parallel.h"
#include "fvv_media/movie.h"
#include "fvvsynth/capture_writer.h"
#include "fvvsynth/footage/board.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>

namespace fvv::synth {

namespace {

using Json = nlohmann::ordered_json;

constexpr uint32_t pixel_samples = 3; // along its side
constexpr size_t plate_frames = 10;
constexpr int crf = 12;         // films look like their pictures: about 48 dB of noisy ones
constexpr double clap_at = 0.2; // seconds, about: the clap is at the time of a frame

// Numbers of noise_key() and names of folders.
enum class Take : uint64_t { performance = 0, plate = 1, board = 2 };
constexpr const char *folder_of[] = {"performance", "plate", "board"};

// A camera that films, and by how much its clock is late, in samples of sound, so that the sound is exact.
struct Filmer {
  size_t number; // in the scene
  std::string name;
  uint32_t late;

  double delay() const { return double(late) / sound_rate; }
};

// By name the first of the cameras that film, which programs take as their reference: its clock is that of
// the truth.
constexpr const char *reference = "head0";

std::vector<Filmer> filmers(const Scene &scene, double latest) {
  Random random(scene.settings().seed ^ 0xc10c);
  std::vector<Filmer> out;
  for (size_t i = 0; i < scene.cameras().size(); i++) {
    const fvv_camera &camera = scene.cameras()[i];
    const std::string name(camera.name, camera.name_size);
    if (name == overhead || name == held_out) continue;
    const auto most = uint32_t(latest * sound_rate);
    const uint32_t late = most > 0 ? random.below(most) : 0;
    out.push_back({i, name, name == reference ? 0 : late});
  }
  return out;
}

// All that the takes have in common.
struct Session {
  const Scene &scene;
  const Shoot &shoot;
  cli::OutputFolder &folder;
  std::vector<Filmer> cameras;
  std::vector<BoardPose> walk;

  double frames_late(const Filmer &camera) const {
    return camera.delay() * shoot.rate.numerator / shoot.rate.denominator;
  }
  // Frames by which the slowest clock may be late, rounded up.
  size_t most_late() const {
    return size_t(std::ceil(shoot.late * shoot.rate.numerator / shoot.rate.denominator));
  }
  // Of every pose: all cameras have at least one frame of it in common.
  size_t frames_of_pose() const { return most_late() + 1; }
  size_t clap_frame() const { return size_t(clap_at * shoot.rate.numerator / shoot.rate.denominator); }
};

std::string path_of(const std::string &head, const std::string &name, const char *before, size_t frame) {
  return numbered((head + "/" + name + "/" + before).c_str(), frame, ".png");
}

using Frame = std::function<std::vector<uint8_t>(size_t frame)>; // its pixels

void write_film(const Session &session, const Filmer &filmer, Take take, size_t count, const Frame &frame,
                const media::SoundPackets *sound) {
  const fvv_camera &camera = session.scene.cameras()[filmer.number];
  media::VideoSettings settings = {};
  settings.codec = FVV_CODEC_AVC1;
  settings.width = camera.width;
  settings.height = camera.height;
  settings.quality = crf;
  settings.frame_rate = {session.shoot.rate.denominator, session.shoot.rate.numerator};
  settings.draft = true;
  const auto load = [&](size_t i) {
    media::GroupFrame<uint8_t> loaded;
    loaded.image = std::make_shared<media::Image>(media::Image{camera.width, camera.height, 3, frame(i)});
    return loaded;
  };
  const media::EncodedGroup group = media::encode_group(settings, media::GroupSource<uint8_t>(count, load));
  session.folder.write(std::string(folder_of[size_t(take)]) + "/" + filmer.name + ".mp4",
                       media::movie_file(settings, group, sound));
}

// Light as the camera's film has it.
std::vector<uint8_t> developed(const Session &session, const Filmer &filmer, const render::LightField &light,
                               Take take, size_t frame) {
  const uint64_t seed = session.scene.settings().seed;
  const uint16_t id = session.scene.cameras()[filmer.number].id;
  const Realism &film = session.shoot.realism;
  return develop(light, exposure_gains(seed, id, film.exposure), film.noise,
                 noise_key(seed, id, frame, uint64_t(take)));
}

void film_plate(const Session &session, const Filmer &filmer) {
  const render::LightField &stage = session.scene.empty_stage(filmer.number);
  write_film(
      session, filmer, Take::plate, plate_frames,
      [&](size_t frame) { return developed(session, filmer, stage, Take::plate, frame); }, nullptr);
}

void film_board(const Session &session, const Filmer &filmer) {
  render::SampleBuffer buffer(1, 1, pixel_samples);
  render::LightField light;
  size_t shown = SIZE_MAX;
  const auto frame = [&](size_t number) {
    const double at = double(number) + session.frames_late(filmer);
    const size_t pose = std::min(size_t(at / double(session.frames_of_pose())), session.walk.size() - 1);
    if (pose != shown) {
      const Board board(session.walk[pose]);
      light =
          session.scene.light_object(filmer.number, board.mesh(), board.attributes(), Board::material, buffer)
              .light;
      shown = pose;
    }
    return developed(session, filmer, light, Take::board, number);
  };
  write_film(session, filmer, Take::board, session.walk.size() * session.frames_of_pose(), frame, nullptr);
}

// What every recorder hears, by the clock of the truth.
std::vector<float> sound(const Session &session) {
  const FrameRate rate = session.shoot.rate;
  const size_t frames = session.shoot.frames + session.most_late();
  const std::vector<int16_t> ball = ball_sound(session.scene.action(), rate, frames);
  const size_t clap = size_t(std::llround(frame_time(rate, session.clap_frame()) * sound_rate));
  const std::vector<int16_t> click = clicks({clap}, ball.size());
  std::vector<float> out;
  for (size_t i = 0; i < ball.size(); i++)
    out.push_back(std::clamp((float(ball[i]) / 2 + float(click[i])) / 32768, -1.0f, 1.0f));
  return out;
}

void film_performance(const Session &session, const Filmer &filmer, const std::vector<float> &heard) {
  const Shoot &shoot = session.shoot;
  render::SampleBuffer buffer(1, 1, pixel_samples);
  const size_t flash =
      session.clap_frame() - std::min(session.clap_frame(), size_t(session.frames_late(filmer)));
  const auto frame = [&](size_t number) {
    const Filming filming(session.scene, shoot.realism, shoot.rate, number, filmer.delay());
    render::Picture picture = filming.shoot(filmer.number, buffer, number == flash ? flash_gain : 1);
    session.folder.write(path_of("truth", filmer.name, "mask_", number),
                         text_of(png(picture, 1, picture.mask)));
    return std::move(picture.rgb);
  };
  const size_t length = size_t(std::llround(frame_time(shoot.rate, shoot.frames) * sound_rate));
  const auto begin = heard.begin() + filmer.late;
  const media::SoundPackets packets =
      media::encode_sound({begin, begin + std::ptrdiff_t(std::min(length, heard.size() - filmer.late))}, 1);
  write_film(session, filmer, Take::performance, shoot.frames, frame, &packets);
}

// Of one frame by the clock of the truth: the mesh, and the picture of the camera held out, without noise.
void write_truth(const Session &session, size_t held_out_number, size_t frame) {
  const Filming filming(session.scene, {}, session.shoot.rate, frame);
  session.folder.write(numbered("truth/meshes/", frame, ".ply"),
                       text_of(ply(filming.moment().positions, session.scene.faces(), nullptr)));
  render::SampleBuffer buffer(1, 1, pixel_samples);
  const render::Picture picture = filming.shoot(held_out_number, buffer);
  session.folder.write(path_of("truth", held_out, "", frame), text_of(png(picture, 3, picture.rgb)));
  session.folder.write(path_of("truth", held_out, "mask_", frame), text_of(png(picture, 1, picture.mask)));
}

// capture.json of the truth: the films, with the calibration and the meshes. Its first frame is the first of
// which every camera has a picture.
Json true_capture(const Session &session) {
  const Shoot &shoot = session.shoot;
  const size_t first = session.most_late();
  Json cameras = Json::array();
  for (const fvv_camera &camera : session.scene.cameras()) {
    Json entry = describe(camera);
    const std::string name = entry["name"];
    if (name == overhead) continue;
    entry["masks"] = name + "/mask_%04d.png";
    const auto filmer = std::find_if(session.cameras.begin(), session.cameras.end(),
                                     [&](const Filmer &one) { return one.name == name; });
    if (filmer == session.cameras.end()) {
      entry["pictures"] = name + "/%04d.png";
    } else {
      // The picture nearest in time, and its mask.
      const auto before = size_t(std::ceil(session.frames_late(*filmer) - 0.5));
      const uint64_t numerator = uint64_t(first - before) * shoot.rate.denominator,
                     common = std::gcd(numerator, uint64_t(shoot.rate.numerator));
      entry["pictures"] = {{"video", "../performance/" + name + ".mp4"},
                           {"start", std::to_string(numerator / common) + "/" +
                                         std::to_string(shoot.rate.numerator / common)}};
      entry["masks"] = {{"pattern", entry["masks"]}, {"offset", -int(before)}};
    }
    cameras.push_back(entry);
  }
  return {{"fvv_capture", 1},
          {"name", "players"},
          {"frame_rate", rate_text(shoot.rate)},
          {"frames", {{"first", first}, {"count", shoot.frames - first}}},
          {"units", "metres"},
          {"up", "+y"},
          {"conventions", {{"pixel_centre", 0.5}}},
          {"meshes", {{"pattern", "meshes/%04d.ply"}}},
          {"cameras", cameras}};
}

Json triple(Vec3 v) {
  return {v.x, v.y, v.z};
}

// All that capture.json has no place for.
Json other_truth(const Session &session) {
  const Shoot &shoot = session.shoot;
  using Pattern = BoardPattern;
  Json cameras, poses = Json::array();
  for (const Filmer &filmer : session.cameras) {
    const uint16_t id = session.scene.cameras()[filmer.number].id;
    cameras[filmer.name] = {
        {"late", filmer.delay()},
        {"gains", triple(exposure_gains(session.scene.settings().seed, id, shoot.realism.exposure))}};
  }
  for (const BoardPose &pose : session.walk)
    poses.push_back({{"origin", triple(pose.origin)},
                     {"x", triple(pose.axes.x)},
                     {"y", triple(pose.axes.y)},
                     {"z", triple(pose.axes.z)}});
  return {{"frame_rate", rate_text(shoot.rate)},
          {"held_out", held_out},
          {"clap", {{"seconds", frame_time(shoot.rate, session.clap_frame())}}},
          {"cameras", cameras},
          {"board",
           {{"columns", Pattern::columns},
            {"rows", Pattern::rows},
            {"square", Pattern::square},
            {"marker", Pattern::marker},
            {"dictionary", "4x4_50"},
            {"frames_of_pose", session.frames_of_pose()},
            {"poses", poses}}}};
}

} // namespace

void write_footage(const Scene &scene, const Shoot &shoot, cli::OutputFolder &folder) {
  const std::vector<Filmer> cameras = filmers(scene, shoot.late);
  const std::vector<BoardPose> walk = board_walk(scene.settings().seed, shoot.poses);
  size_t held_out_number = 0;
  while (std::string(scene.cameras()[held_out_number].name, scene.cameras()[held_out_number].name_size) !=
         held_out)
    held_out_number++;
  const Session session = {scene, shoot, folder, cameras, walk};
  const size_t late = session.most_late();
  if (shoot.frames <= late)
    throw Error("--frames: expected more than " + std::to_string(late) +
                    " with --footage, by which clocks differ, found " + std::to_string(shoot.frames),
                Error::usage);
  const std::vector<float> heard = sound(session);
  // The longest pieces first.
  const size_t count = cameras.size(), pieces = 3 * count + shoot.frames - late;
  cli::Progress progress("films, and frames of the truth", pieces, "pieces");
  const auto work = [&](size_t piece) {
    if (piece >= 3 * count) return write_truth(session, held_out_number, piece - 3 * count + late);
    const Filmer &filmer = cameras[piece % count];
    if (piece < count) return film_performance(session, filmer, heard);
    if (piece < 2 * count) return film_board(session, filmer);
    film_plate(session, filmer);
  };
  fvv::parallel(shoot.threads, pieces, work, [&] { progress.step(); });
  folder.write("truth/capture.json", true_capture(session).dump(2) + "\n");
  folder.write("truth/truth.json", other_truth(session).dump(2) + "\n");
}

} // namespace fvv::synth
