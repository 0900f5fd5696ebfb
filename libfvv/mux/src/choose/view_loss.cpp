#include "mux/src/choose/view_loss.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/parallel.h"
#include "fvv_media/frame.h"
#include "fvv_render/held_out.h"
#include "fvv_render/local_origin.h"
#include "mux/src/choose/choices.h"
#include "mux/src/ladder/view_rungs.h"
#include "mux/src/layout.h"
#include "mux/src/meshes/decoded_meshes.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/options/presets.h"
#include "mux/src/pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace fvv::mux {

namespace {

constexpr size_t tried_frames = 2; // encoded for each candidate
constexpr std::array<double, 2> tried_psnr = {least_camera_psnr, 42};
constexpr std::array<double, 3> coarser_errors = {0.175, 0.2, 0.3}; // pixels
constexpr std::array<double, 3> finer_errors = {0.1, 0.075, 0.05};
constexpr std::array<double, 2> stricter_thresholds = {0.15, 0.25}; // cosines
constexpr double psnr_step = 0.5;
constexpr double most_growth = 1.05; // of the bytes
// What a loss of the goal is worth, of the bytes.
constexpr double bytes_of_goal = 0.03;
constexpr int most_measured = 4; // combinations
constexpr double exact = 80;     // dB, that only rounding is left
// Of lower rungs, below the pictures of the first; meshes by their error over that of the first.
constexpr std::array<double, 4> lower_psnr = {3, 6, 9, 12};
constexpr std::array<double, 4> coarser_times = {1.25, 1.6, 2, 2.5};
constexpr double least_lower_psnr = 26; // dB
// What pays for a way of blending that is not the players' own.
constexpr double least_blend_gain = 0.02; // dB

struct Surface {
  std::vector<float> positions; // from origin_of() the plan's lattice
  std::vector<uint32_t> faces;

  render::Mesh mesh() const {
    return {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3};
  }
};

// Of each camera with a tile, in the order of tracks and tiles.
using Tiles = std::vector<media::DeepImage>;

struct Pictures {
  double psnr = 0;           // dB
  double bytes = 0;          // of a group
  std::vector<Tiles> frames; // that are tried
};

struct Meshes {
  double max_error = 0;          // as ErrorBudget::value
  double step = 0;               // of the lattice
  double bytes = 0;              // of a group
  bool loses = false;            // faces or the thickness of pieces, by rounding to the lattice
  std::vector<Surface> surfaces; // of each frame
};

// bytes of the samples of a few frames, as those of a group of count.
double of_group(const std::vector<size_t> &bytes, size_t count) {
  double rest = 0;
  for (size_t i = 1; i < bytes.size(); i++) rest += double(bytes[i]);
  return double(bytes[0]) + (bytes.size() > 1 ? rest / double(bytes.size() - 1) * double(count - 1) : 0);
}

const media::DeepImage &deep(const media::DeepImage &image) {
  return image;
}
media::DeepImage deep(const media::Image &image) {
  return media::with_samples<uint16_t>(image);
}

// The video frames of a track.
template <class Sample> struct Source {
  std::vector<media::BasicImage<Sample>> pictures;
  std::vector<media::Image> foreground;

  bool masked() const {
    const auto shows = [](const media::Image &mask) {
      return std::any_of(mask.pixels.begin(), mask.pixels.end(), [](uint8_t m) { return m > 127; });
    };
    return std::any_of(foreground.begin(), foreground.end(), shows);
  }
};

// The middle group, or the nearest one that begins with a mesh.
size_t tried_group(const Plan &plan) {
  const size_t middle = middle_group(plan);
  for (size_t off = 0; off < plan.group_count(); off++)
    for (const size_t group : {middle + off, middle - off})
      if (group < plan.group_count() && plan.has_mesh(plan.first_of(group))) return group;
  return middle;
}

// A few frames of a group, and what a stream makes of them.
class Trial {
public:
  Trial(const Plan &of, const SampledScene &sampled, const Tiling &cameras, double following)
      : plan(of), scene(sampled), tiling(cameras), delta_frames(following), room(of.options.threads),
        group(tried_group(of)), first(of.first_of(group)) {
    while (count < std::min(plan.frames_of(group), tried_frames) && plan.has_mesh(first + count)) count++;
    executor = [this](size_t items, const std::function<void(size_t)> &work) {
      fvv::parallel(plan.options.threads, items, [&](size_t i) {
        plan.observer.check_cancelled();
        work(i);
      });
    };
    frames.resize(count);
    media::with_sample_type(plan.options.codec, plan.options.bit_depth, [&](auto sample) {
      if constexpr (!std::is_same_v<decltype(sample), float>) load<decltype(sample)>();
      return 0;
    });
  }

  // 0: no group begins with a mesh.
  size_t frame_count() const { return count; }
  int64_t first_frame() const { return plan.capture.frames.number(int64_t(first)); }

  // Borrows all that it is given. NULL: those of the source. number: of frames.
  std::vector<render::HeldOutFrame> with(const Meshes *meshes, const Pictures *pictures,
                                         size_t number) const {
    std::vector<render::HeldOutFrame> out;
    for (size_t i = 0; i < number; i++)
      out.push_back(shown(frames[i], meshes ? meshes->surfaces[i] : frames[i].source,
                          pictures ? pictures->frames[i] : frames[i].pictures));
    return out;
  }

  render::ViewOptions view_options(const fvv_texturing &texturing) const {
    render::ViewOptions out;
    out.blend = render::Blend(texturing.blend);
    out.threshold = texturing.threshold;
    out.best = std::min<uint32_t>(texturing.best, render::max_best);
    out.depth_test.samples = 1; // as for the inset
    out.depth_test.bias = texturing.depth_bias;
    out.depth_test.slope = texturing.depth_slope;
    out.inset = out.blend == render::Blend::paper && !plan.options.texture_inset ? 0 : texturing.inset;
    out.executor = executor;
    return out;
  }

  // max_error: none: as the plan has it. step: of the lattice; none: by the error.
  Meshes meshes(const std::optional<MaxError> &max_error, const std::optional<double> &step = {}) const;
  // target: dB; none: as the options say.
  Pictures pictures(std::optional<double> target);

private:
  struct Frame {
    Surface source;
    std::vector<std::optional<fvv_camera>> cameras; // of each tile; those without calibration show nothing
    Tiles pictures;
    std::vector<media::Image> masks; // empty ones count whole
    std::map<size_t, size_t> places; // of the capture's cameras among these
  };

  template <class Sample> void load() {
    std::vector<Source<Sample>> &tracks = std::get<std::vector<Source<Sample>>>(sources);
    tracks.resize(plan.tracks.size());
    for (Source<Sample> &track : tracks) {
      track.pictures.resize(count);
      track.foreground.resize(count);
    }
    executor(count, [&](size_t i) { load_frame(i, tracks); });
  }

  template <class Sample> void load_frame(size_t i, std::vector<Source<Sample>> &tracks) {
    Frame &frame = frames[i];
    const int64_t number = plan.capture.frames.number(int64_t(first + i));
    geometry::Mesh mesh = scene.mesh(number);
    const render::Vec3 origin = origin_of(plan.lattice.lattice);
    frame.source = {render::positions_from(origin, mesh.positions), mesh.faces};
    if (i == 0) {
      if (plan.capture.flip_faces) geometry::flip_faces(mesh); // as in the file
      tried.emplace(plan.capture, std::vector<SampledMesh>{{number, std::move(mesh)}}, tiling);
    }
    for (size_t t = 0; t < plan.tracks.size(); t++) {
      const VideoTrack &track = plan.tracks[t];
      const std::vector<fvv_tile> &tiles = track.tiles_of(group);
      for (size_t k = 0; k < tiles.size(); k++) {
        const scene::Camera &camera = plan.capture.cameras[track.tiling.cameras[k]];
        frame.places[track.tiling.cameras[k]] = frame.cameras.size();
        frame.cameras.emplace_back();
        if (!camera.is_calibrated(number)) continue;
        const fvv_camera calibration = camera.calibration_at(number);
        frame.cameras.back() = render::camera_from(origin, fvv_camera_of_tile(&calibration, &tiles[k]));
      }
      Picture<Sample> picture = load_picture<Sample>(plan, track, first + i, true);
      cut(track, deep(picture.image), frame.pictures);
      if (picture.mask.pixels.empty())
        frame.masks.resize(frame.pictures.size());
      else
        cut(track, picture.mask, frame.masks);
      tracks[t].pictures[i] = std::move(picture.image);
      tracks[t].foreground[i] = std::move(picture.mask);
    }
  }

  template <class Image> void cut(const VideoTrack &track, const Image &from, std::vector<Image> &to) const {
    for (const fvv_tile &tile : track.tiles_of(group)) {
      const fvv_rect &at = tile.destination;
      to.push_back(media::crop(from, at.x, at.y, at.width, at.height));
    }
  }

  static render::HeldOutFrame shown(const Frame &frame, const Surface &surface, const Tiles &pictures) {
    render::HeldOutFrame out = {surface.mesh(), {}};
    // In the order of the capture, whatever that of tiles: rungs differ in it.
    for (const auto &[camera, k] : frame.places)
      if (frame.cameras[k])
        out.views.push_back({{*frame.cameras[k], pictures[k].pixels.data()},
                             frame.masks[k].pixels.empty() ? nullptr : frame.masks[k].pixels.data()});
    return out;
  }

  template <class Sample> Pictures encode(size_t track, std::optional<double> target);

  const Plan &plan;
  const SampledScene &scene;
  const Tiling &tiling;
  const double delta_frames;
  EncoderRoom room;
  render::Executor executor;
  const size_t group, first;
  size_t count = 0;
  std::vector<Frame> frames;
  std::tuple<std::vector<Source<uint8_t>>, std::vector<Source<uint16_t>>> sources; // of each track
  std::optional<SampledScene> tried; // the first frame, for decimation
};

template <class Sample> Pictures Trial::encode(size_t index, std::optional<double> target) {
  const VideoTrack &track = plan.tracks[index];
  media::VideoSettings settings = {plan.options.codec,          track.tiling.width,
                                   track.tiling.height,         int(plan.options.quality.value),
                                   plan.capture.frame_duration, plan.options.bit_depth};
  if (!plan.options.quality.is_psnr) settings.parts = plan.options.quality.value - settings.quality;
  settings.effort = row_of(plan.options.preset).pictures;
  const Source<Sample> &of = std::get<std::vector<Source<Sample>>>(sources)[index];
  auto source =
      media::GroupSource<Sample>::borrowed(of.pictures, of.masked() ? of.foreground : media::no_masks);
  source.reserve = [this](uint64_t bytes) { return room.reserve(bytes); };
  const media::MeasuredGroup measured =
      target ? media::choose_quality(settings, source, *target, *target <= least_camera_psnr)
             : media::encode_measured(settings, source);
  Pictures out;
  out.psnr = measured.psnr;
  const fvv_video_config config = media::config_of(settings, measured.group);
  media::Decoder decoder(config);
  std::vector<size_t> bytes;
  for (const media::Sample &sample : measured.group.samples) {
    bytes.push_back(sample.bytes.size());
    cut(track, decoder.decode<uint16_t>(sample.bytes.data(), sample.bytes.size()), out.frames.emplace_back());
  }
  out.bytes = of_group(bytes, plan.frames_of(group));
  return out;
}

Pictures Trial::pictures(std::optional<double> target) {
  std::vector<Pictures> tracks(plan.tracks.size());
  executor(tracks.size(), [&](size_t k) {
    media::with_sample_type(plan.options.codec, plan.options.bit_depth, [&](auto sample) {
      if constexpr (!std::is_same_v<decltype(sample), float>) tracks[k] = encode<decltype(sample)>(k, target);
      return 0;
    });
  });
  Pictures out;
  out.psnr = INFINITY;
  out.frames.resize(count);
  for (Pictures &track : tracks) {
    out.psnr = std::min(out.psnr, track.psnr);
    out.bytes += track.bytes;
    for (size_t i = 0; i < count; i++)
      std::move(track.frames[i].begin(), track.frames[i].end(), std::back_inserter(out.frames[i]));
  }
  if (target) out.psnr = *target;
  return out;
}

Meshes Trial::meshes(const std::optional<MaxError> &max_error, const std::optional<double> &step) const {
  Plan part = plan;
  if (max_error) part.options.max_error = max_error;
  if (step) part.options.step = {*step, !plan.capture.scale_unknown};
  part.options.track = Track::never; // takes long, and changes little of what is seen
  part.tracking.on = false;
  part.error = choose_budget(part.options, scene);
  part.lattice = choose_lattice(part.options, scene, part.error, part.has_constant_topology, delta_frames);
  part.groups = {{first, count, plan.tick_of(first), plan.tick_of(first + count - 1) + 1}};
  MeshTrack track;
  track.id = plan.meshes[0].id;
  track.lattice = part.lattice;
  track.decimation = choose_decimation(part.options, *tried, part.error, part.lattice, part.normals);
  track.loader = std::make_shared<MeshLoader>(part, track.decimation, tiling);
  std::vector<MeshFrame> encoded;
  if (part.has_constant_topology) {
    encoded = encode_meshes(part, track, first, count);
  } else {
    std::vector<std::vector<MeshFrame>> each(count);
    executor(count, [&](size_t i) { each[i] = encode_meshes(part, track, first + i, 1); });
    for (std::vector<MeshFrame> &one : each) encoded.push_back(std::move(one[0]));
  }
  Meshes out;
  out.max_error = part.error.value;
  out.step = part.lattice.lattice.step;
  DecodedMeshes decoded(plan.capture.path);
  std::vector<size_t> bytes;
  for (size_t i = 0; i < encoded.size(); i++) {
    bytes.push_back(encoded[i].payload.size());
    const QuantisationLoss &loss = encoded[i].loss;
    out.loses = out.loses || loss.flat.pieces || loss.share > most_quantisation_loss;
    const fvv_mesh &mesh = decoded.next(encoded[i], i + 1 < encoded.size() && !encoded[i + 1].key);
    out.surfaces.push_back(
        {metres_of(mesh, part.lattice.lattice), {mesh.faces, mesh.faces + 3 * size_t(mesh.face_count)}});
  }
  out.bytes = of_group(bytes, plan.frames_of(group));
  return out;
}

// What candidates lose of what the source's meshes and pictures show, in the last frames.
class Judge {
public:
  Judge(const Trial &of, const render::ViewOptions &how, size_t count)
      : trial(of), options(how), number(count), frames(trial.with(nullptr, nullptr, count)),
        drawn(frames, options), measure(frames, drawn), score(measure.held_out_sum(drawn)) {}

  // Of cameras that are drawn from the others. NULL: those of the source.
  render::ViewScore held_out(const Meshes *meshes, const Pictures *pictures) const {
    return held_out(meshes, pictures, options);
  }
  render::ViewScore held_out(const Meshes *meshes, const Pictures *pictures,
                             const render::ViewOptions &how) const {
    return measure.held_out_sum(render::DrawnFrames(trial.with(meshes, pictures, number), how));
  }
  // Frames of the same cameras.
  render::ViewScore held_out(const std::vector<render::HeldOutFrame> &shown) const {
    return measure.held_out_sum(render::DrawnFrames(shown, options));
  }
  // Half-way between cameras, against the source.
  render::ViewScore between(const Meshes *meshes, const Pictures *pictures) const {
    const std::vector<render::HeldOutFrame> shown = trial.with(meshes, pictures, number);
    return render::BetweenMeasure(frames, drawn).score(render::DrawnFrames(shown, options));
  }
  const render::ViewScore &of_source() const { return score; }
  size_t pixels() const { return measure.pixels(); }

private:
  const Trial &trial;
  const render::ViewOptions options;
  const size_t number;
  const std::vector<render::HeldOutFrame> frames;
  const render::DrawnFrames drawn;
  const render::ViewMeasure measure;
  const render::ViewScore score;
};

fvv_texturing texturing_or_default(const Plan &plan) {
  if (const std::optional<fvv_texturing> known = texturing_of(plan)) return *known;
  fvv_texturing out;
  fvv_texturing_default(&out);
  return out;
}

struct Blend {
  fvv_texturing texturing;
  double gain = 0; // dB, over that of the players or of the options
  std::vector<BlendCandidate> tried = {};
};

// Of the ways of blending that options leave open the best for cameras that are drawn from the others. Only
// stricter ones are tried, a higher threshold and fewer cameras: cameras that are left out are further from
// the others than viewers are, so more mixing looks better here than it is. For that reason the paper's
// blend, which does not prefer near cameras, is never chosen (docs/encoding/view-loss.md).
Blend choose_blend(const Plan &plan, const Trial &trial) {
  const Options &options = plan.options;
  const fvv_texturing given = texturing_or_default(plan);
  // Only what all of them show is compared: players draw colours of vertices on the rest.
  fvv_texturing strictest = given;
  if (!options.texture_threshold) strictest.threshold = std::max(given.threshold, stricter_thresholds.back());
  const Judge judge(trial, trial.view_options(strictest), 1); // many ways, of which few differ by little
  if (judge.pixels() < render::least_compared) return {given};
  const double before = judge.held_out(nullptr, nullptr, trial.view_options(given)).luma_error();
  Blend best = {given};
  std::vector<BlendCandidate> tried = {{given.threshold, given.best, 0}};
  const auto consider = [&](const fvv_texturing &one) {
    const double error = judge.held_out(nullptr, nullptr, trial.view_options(one)).luma_error();
    const double gain = render::loss_db(error, before);
    tried.push_back({one.threshold, one.best, gain});
    if (gain > best.gain) best = {one, gain};
  };
  for (const double threshold : stricter_thresholds) {
    fvv_texturing one = given;
    one.threshold = threshold;
    if (!options.texture_threshold && threshold > given.threshold) consider(one);
  }
  fvv_texturing one = best.texturing;
  one.best = 2;
  if (!options.texture_best) consider(one);
  if (best.gain < least_blend_gain) best = {given};
  best.tried = std::move(tried);
  return best;
}

// What pictures of a quality lose, by those that were tried.
class PictureCurve {
public:
  struct Point {
    Pictures pictures;
    double error; // beyond that of the source's pictures
  };
  explicit PictureCurve(std::vector<Point> by_rising_psnr) : points(std::move(by_rising_psnr)) {}

  const Pictures &finest() const { return points.back().pictures; }
  // NULL: they were not tried.
  const Pictures *tried(double psnr) const {
    for (const Point &point : points)
      if (point.pictures.psnr == psnr) return &point.pictures;
    return nullptr;
  }
  double lowest() const { return points.front().pictures.psnr; }
  double highest() const { return points.back().pictures.psnr; }
  double bytes(double psnr) const {
    return std::exp(between(
        psnr, [](double db) { return db; }, [](const Point &p) { return std::log(p.pictures.bytes); }));
  }
  // Errors rise as the noise does.
  double error(double psnr) const {
    return between(
        psnr, [](double db) { return std::pow(10, -db / 10); }, [](const Point &p) { return p.error; });
  }

private:
  template <class At, class Value> double between(double psnr, const At &at, const Value &value) const {
    size_t k = 1;
    while (k + 1 < points.size() && points[k].pictures.psnr < psnr) k++;
    if (points.size() == 1) return value(points[0]);
    const Point &a = points[k - 1], &b = points[k];
    const double part = (at(psnr) - at(a.pictures.psnr)) / (at(b.pictures.psnr) - at(a.pictures.psnr));
    return value(a) + part * (value(b) - value(a));
  }

  std::vector<Point> points;
};

struct TriedMeshes {
  Meshes meshes;
  double error;
};

// What bytes and a loss cost together: a loss as large as the goal counts as much as some bytes. As a
// logarithm of bytes.
double price_of(double bytes, double error, double error_without, double goal) {
  return std::log(bytes) + bytes_of_goal * render::loss_db(error_without, error) / goal;
}

size_t camera_count(const Plan &plan) {
  size_t count = 0;
  for (const VideoTrack &track : plan.tracks) count += track.tiling.cameras.size();
  return count;
}

// First those of the budget that holds without the choice. Then finer ones, as long as the price falls with
// the cheapest pictures; if none does, coarser ones, as long as they lose no more than the goal. Last those
// on a coarser lattice, unless that takes faces away or makes pieces flat: of meshes that change from frame
// to frame each frame pays for the lattice, and spends on triangles what that leaves.
std::vector<TriedMeshes> try_meshes(const Plan &plan, const Trial &trial, const Judge &judge,
                                    const PictureCurve &curve, double goal) {
  std::vector<TriedMeshes> out;
  const double pictures = curve.bytes(curve.lowest());
  const auto price = [&](const TriedMeshes &one) {
    return price_of(one.meshes.bytes + pictures, one.error, out[0].error, goal);
  };
  const auto attempt = [&](const std::optional<MaxError> &error, const std::optional<double> &step = {}) {
    Meshes meshes = trial.meshes(error, step);
    if (meshes.loses && !out.empty() && !out[0].meshes.loses) return double(INFINITY);
    const double seen = judge.held_out(&meshes, nullptr).luma_error();
    out.push_back({std::move(meshes), seen});
    return render::loss_db(out[0].error, seen);
  };
  attempt(std::nullopt);
  const Options &options = plan.options;
  if (options.max_error || plan.error.is_length || options.step || options.triangles ||
      options.keep_geometry || !plan.meshes[0].decimation.on)
    return out;
  for (const double pixels : finer_errors) {
    if (attempt(MaxError{pixels, MaxError::pixels}) == INFINITY) break;
    if (price(out.back()) >= price(out[out.size() - 2])) break;
  }
  // Colours of vertices, which few cameras leave much to, are coarser on coarser meshes.
  const double coarsest = camera_count(plan) < cameras_all_round ? coarser_errors[0] : coarser_errors.back();
  if (out.size() == 2)
    for (const double pixels : coarser_errors)
      if (pixels > coarsest || attempt(MaxError{pixels, MaxError::pixels}) > goal) break;
  if (plan.has_constant_topology || plan.capture.lattice) return out;
  const double coarser = geometry::round_down_125(2.51 * plan.lattice.lattice.step); // the next of 1, 2, 5
  for (const double pixels : {plan.error.value, coarser_errors[0], coarser_errors[1]})
    if (pixels > coarsest || attempt(MaxError{pixels, MaxError::pixels}, coarser) > goal) break;
  return out;
}

// Noise is alike in all frames: one is enough. judge: of any.
PictureCurve try_pictures(const Plan &plan, Trial &trial, const Judge &judge) {
  std::vector<PictureCurve::Point> points;
  const auto attempt = [&](std::optional<double> target) {
    Pictures pictures = trial.pictures(target);
    const double error = judge.held_out(nullptr, &pictures).luma_error() - judge.of_source().luma_error();
    points.push_back({std::move(pictures), error});
  };
  const Quality &quality = plan.options.quality;
  if (quality.by_default)
    for (const double target : tried_psnr) attempt(target);
  else
    attempt(quality.is_psnr ? std::optional<double>(quality.value) : std::nullopt);
  return PictureCurve(std::move(points));
}

struct Combination {
  size_t meshes = 0;
  double psnr = 0, bytes = 0, error = 0;
};

// All of meshes and pictures, with errors added up.
std::vector<Combination> combinations(const std::vector<TriedMeshes> &meshes, const PictureCurve &curve) {
  std::vector<Combination> out;
  const double range = curve.highest() - curve.lowest(); // not a number: pictures without an error
  const size_t steps = range > 0 ? size_t(range / psnr_step) : 0;
  for (size_t k = 0; k < meshes.size(); k++)
    for (size_t i = 0; i <= steps; i++) {
      const double psnr = i ? curve.lowest() + double(i) * psnr_step : curve.lowest();
      out.push_back({k, psnr, meshes[k].meshes.bytes + curve.bytes(psnr),
                     meshes[k].error + std::max(0.0, curve.error(psnr))});
    }
  return out;
}

// Of those that are hardly larger than the first and lose at most what is allowed against it: the lowest
// price.
Combination cheapest(const std::vector<Combination> &all, const Combination &without, double allowed,
                     double goal) {
  Combination best = without;
  const auto price = [&](const Combination &one) {
    return price_of(one.bytes, one.error, without.error, goal);
  };
  for (const Combination &one : all)
    if (one.bytes <= most_growth * without.bytes && render::loss_db(without.error, one.error) <= allowed &&
        price(one) < price(best))
      best = one;
  return best;
}

// What of the candidates was measured as a whole in place of added up.
void note_measured(ViewReport &found, const Meshes &meshes, double psnr, const Pictures &pictures) {
  for (ViewCandidate &one : found.candidates)
    if (one.max_error == meshes.max_error && one.step == meshes.step && one.psnr == psnr) {
      one.bytes = meshes.bytes + pictures.bytes;
      one.loss = found.loss;
      one.is_measured = true;
    }
}

std::string obstacle(const Plan &plan) {
  const bool encoded = std::any_of(plan.tracks.begin(), plan.tracks.end(),
                                   [](const VideoTrack &t) { return bool(t.encoded); });
  return !plan.has_meshes()                     ? "there are no meshes"
         : plan.capture.atlas                   ? "the atlas has the colours of the surface"
         : encoded                              ? "pictures that come encoded stay as they are"
         : camera_count(plan) < 2               ? "there are no two cameras with pictures"
         : plan.options.codec == FVV_CODEC_OEXR ? "pictures in OpenEXR stay as they are"
         : plan.options.bit_rate                ? "the bit rate decides about pictures"
                                                : "";
}

// The same unit as the plan's.
MaxError error_of(const Plan &plan, double value) {
  return {value, !plan.error.is_length        ? MaxError::pixels
                 : plan.capture.scale_unknown ? MaxError::plain
                                              : MaxError::metres};
}

// Qualities below those of the first rung with meshes as fine as its own, and coarser. Errors of meshes and
// pictures are added up. judge: of any frames.
std::vector<RungCandidate> try_rungs(const Plan &plan, Trial &trial, const Judge &judge,
                                     const Judge &of_pictures, const TriedMeshes &first, double first_psnr) {
  std::vector<RungCandidate> meshes = {{0, 1, first.meshes.bytes, first.error}};
  const Options &options = plan.options;
  if (plan.meshes[0].decimation.on && !options.triangles && options.mesh_ladder != MeshLadder::off)
    for (const double times : coarser_times) {
      const Meshes coarse = trial.meshes(error_of(plan, first.meshes.max_error * times), first.meshes.step);
      if (coarse.loses && !first.meshes.loses) break;
      meshes.push_back({0, times, coarse.bytes, judge.held_out(&coarse, nullptr).luma_error()});
    }
  std::vector<RungCandidate> out;
  for (const double below : lower_psnr) {
    const double psnr = first_psnr - below;
    if (psnr < std::min(least_lower_psnr, first_psnr - lower_psnr[0])) break;
    const Pictures pictures = trial.pictures(psnr);
    const double error =
        of_pictures.held_out(nullptr, &pictures).luma_error() - of_pictures.of_source().luma_error();
    for (const RungCandidate &one : meshes)
      out.push_back({psnr, one.times, one.bytes + pictures.bytes, one.error + std::max(0.0, error)});
  }
  return out;
}

// With the tracks of a lower rung in place of all.
Plan rung_alone(const Plan &plan, size_t rung) {
  Plan out = plan;
  add_rungs(out);
  const auto is_other = [&](const VideoTrack &track) { return track.rung != rung; };
  out.tracks.erase(std::remove_if(out.tracks.begin(), out.tracks.end(), is_other), out.tracks.end());
  return out;
}

// Of quality, error or bytes, in place of what views may lose. A ladder's first rung has set its own.
bool states_goal(const Options &options) {
  return !options.quality.by_default || options.max_error || options.bit_rate;
}

// What keeps a choice from being made that no option asks for.
std::string default_obstacle(const Plan &plan) {
  if (plan.capture.memory)
    return "frames that come one after the other are packed without a look at them beforehand, but for " +
           option_name("view-loss", "0.1dB");
  return row_of(plan.options.preset).view_loss ? "" : preset_reason(plan.options.preset);
}

} // namespace

ViewChoice choose_by_view_loss(const Plan &plan, const SampledScene &scene, const Tiling &tiling,
                               double delta_frames) {
  ViewChoice choice;
  const Options &options = plan.options;
  const bool by_default = !options.view_loss && !states_goal(options);
  ViewReport &found = choice.report;
  found.goal = by_default ? default_view_loss : options.view_loss.value_or(0);
  if (!(found.goal > 0)) return choice;
  found.reason = obstacle(plan);
  if (by_default && found.reason.empty()) found.reason = default_obstacle(plan);
  if (!found.reason.empty()) return choice;
  Trial trial(plan, scene, tiling, delta_frames);
  if (!trial.frame_count()) {
    found.reason = "every group begins with an empty stage";
    return choice;
  }
  // Meshes and pictures are judged by the blend as it was: a stricter one shows fewer pixels of cameras that
  // are drawn from the others, and its gain is of those that it shows.
  const render::ViewOptions given = trial.view_options(texturing_or_default(plan));
  const Blend blend = choose_blend(plan, trial);
  choice.texturing = blend.texturing;
  const Judge judge(trial, given, trial.frame_count());
  if (judge.pixels() < render::least_compared) {
    found.reason = "cameras share too little surface to tell what views lose";
    return choice;
  }
  if (judge.of_source().psnr() > exact) {
    found.reason = "cameras draw each other exactly, so their views tell nothing";
    return choice;
  }
  found.is_measured = true;
  found.frame = trial.first_frame();
  const Judge of_pictures(trial, given, 1);
  const PictureCurve curve = try_pictures(plan, trial, of_pictures);
  const std::vector<TriedMeshes> meshes = try_meshes(plan, trial, judge, curve, found.goal + blend.gain);
  const std::vector<Combination> all = combinations(meshes, curve);
  // Meshes as they would be, and the best pictures that were tried.
  const Combination without =
      *std::find_if(all.rbegin(), all.rend(), [](const Combination &one) { return one.meshes == 0; });
  found.psnr_without = judge.held_out(&meshes[0].meshes, &curve.finest()).psnr();
  found.blends = blend.tried;
  for (const Combination &one : all) {
    if (!std::isfinite(one.psnr)) continue; // pictures without an error
    const Meshes &of = meshes[one.meshes].meshes;
    found.candidates.push_back(
        {of.max_error, of.step, one.psnr, one.bytes, render::loss_db(without.error, one.error) - blend.gain});
  }
  Combination best;
  std::optional<Pictures> encoded;
  const Pictures *pictures = nullptr;
  render::ViewScore seen;
  // Errors of meshes and pictures rarely add up exactly: what is measured of both decides.
  double allowed = found.goal + blend.gain;
  for (int tries = 0; tries < most_measured; tries++) {
    best = tries + 1 < most_measured ? cheapest(all, without, allowed, found.goal) : without;
    pictures = curve.tried(best.psnr);
    if (!pictures) pictures = &encoded.emplace(trial.pictures(best.psnr));
    seen = judge.held_out(&meshes[best.meshes].meshes, pictures);
    found.loss = found.psnr_without - seen.psnr() - blend.gain;
    note_measured(found, meshes[best.meshes].meshes, best.psnr, *pictures);
    if (found.loss <= found.goal) break;
    allowed = std::min(allowed, render::loss_db(without.error, best.error)) - (found.loss - found.goal);
  }
  const Meshes &chosen = meshes[best.meshes].meshes;
  found.psnr = best.psnr;
  found.is_length = plan.error.is_length;
  found.is_paper = choice.texturing.blend == FVV_BLEND_PAPER;
  found.threshold = choice.texturing.threshold;
  found.best = choice.texturing.best;
  found.max_error = chosen.max_error;
  found.step = chosen.step;
  found.bytes = chosen.bytes + pictures->bytes;
  found.held_out_psnr = seen.psnr() + blend.gain;
  found.held_out_ssim = seen.ssim();
  found.between_psnr = judge.between(&chosen, pictures).psnr();
  found.finest_psnr = judge.of_source().psnr();
  found.finest_ssim = judge.of_source().ssim();
  found.bytes_without = without.bytes;
  Plan with_rungs = plan;
  if (options.ladder_by_views && std::isfinite(best.psnr)) {
    const RungCandidate first = {best.psnr, 1, best.bytes, best.error};
    const std::vector<Rung> rungs =
        choose_view_rungs(first, try_rungs(plan, trial, judge, of_pictures, meshes[best.meshes], best.psnr));
    if (rungs.size() > 1) choice.ladder = with_rungs.options.ladder = rungs;
  }
  for (size_t rung = 1; rung < with_rungs.rung_count(); rung++) {
    const double psnr = target_psnr_of(with_rungs, rung, pictures->psnr);
    const Plan lower = rung_alone(with_rungs, rung);
    Trial smaller(lower, scene, tiling, delta_frames);
    const Pictures coarse = smaller.pictures(psnr);
    Meshes own = meshes[best.meshes].meshes;
    const bool has_own = plan.meshes[0].decimation.on && plan.options.mesh_ladder != MeshLadder::off;
    if (has_own)
      own = trial.meshes(error_of(plan, chosen.max_error / with_rungs.rung_detail(rung)), chosen.step);
    const render::ViewScore shown = judge.held_out(smaller.with(&own, &coarse, trial.frame_count()));
    found.rungs.push_back(
        {with_rungs.rung_scale(rung), psnr, own.max_error, found.psnr_without - shown.psnr() - blend.gain});
  }
  return choice;
}

} // namespace fvv::mux
