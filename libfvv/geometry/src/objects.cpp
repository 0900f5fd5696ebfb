#include "fvv_geometry/objects.h"
#include "fvv_geometry/pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fvv::objects {

namespace {

constexpr double least_area = 0.01; // of the largest piece
constexpr size_t most_places = 300; // of a piece
constexpr double least_life = 0.2;  // seconds
constexpr double remembered = 1;    // seconds, of an object without a piece
constexpr double overlaps = 0.3;    // the least fraction of places of the smaller piece near the larger one
constexpr double clear = 0.25;      // by how much an assignment has to be better than the next one to be sure
constexpr size_t most_assignments = 4096;

// The radius of a ball with that surface.
double ball_radius(double area) {
  return std::sqrt(area / (4 * 3.14159265358979));
}

// The fraction of the places of the smaller piece that are near those of the larger one, after a has moved by
// shift.
double overlap(const Piece &a, Vec3 shift, const Piece &b) {
  const bool a_is_smaller = a.area <= b.area;
  const Piece &small = a_is_smaller ? a : b, &large = a_is_smaller ? b : a;
  const Vec3 way = a_is_smaller ? shift : -shift;
  const double spacing = std::sqrt(large.area / double(large.places.size()));
  const double near = 0.35 * ball_radius(small.area) + spacing;
  if (length(small.centre + way - large.centre) > small.radius + large.radius + near) return 0;
  size_t count = 0;
  for (const Vec3 &place : small.places) {
    const Vec3 moved = place + way;
    count += std::any_of(large.places.begin(), large.places.end(), [&](const Vec3 &other) {
      const Vec3 apart = other - moved;
      return dot(apart, apart) <= near * near;
    });
  }
  return double(count) / double(small.places.size());
}

double likeness(double a, double b) {
  return std::min(a, b) / std::max(a, b);
}

// What was one piece in the frame before: an object, or several that touch.
struct Holder {
  std::vector<size_t> objects; // by rising index
  Piece piece;
  Vec3 step; // from frame to frame
};

// An object without a piece.
struct Lost {
  size_t object;
  Piece piece;
  Vec3 step;
  size_t frame; // the last with a piece
};

class Follower {
public:
  Follower(size_t frames, double seconds)
      : memory(std::max<size_t>(1, size_t(remembered / seconds))), frame_count(frames) {}

  void add(const std::vector<Piece> &pieces);
  Following finish(double seconds);

private:
  // Of each piece of the frame: what it continues, and what it takes up besides.
  struct Heir {
    std::optional<size_t> of;       // index in holders
    std::vector<size_t> taken;      // likewise
    std::vector<size_t> given;      // objects of a holder that came apart; else those of `of` and `taken`
    bool is_part = false;           // of a holder that came apart
    std::optional<size_t> came_off; // an object
  };

  void match(const std::vector<Piece> &pieces, std::vector<Heir> &heirs, std::vector<bool> &used) const;
  void merge(const std::vector<Piece> &pieces, std::vector<Heir> &heirs, const std::vector<bool> &used);
  void part(const std::vector<Piece> &pieces, std::vector<Heir> &heirs);
  std::vector<size_t> objects_of(const Piece &piece, const Heir &heir);
  std::optional<size_t> found_again(const Piece &piece);
  void note_touch(const std::vector<size_t> &objects, size_t last_frame);

  const size_t memory, frame_count;
  size_t frame = 0;
  std::vector<Holder> holders;
  std::vector<Lost> lost;
  // Of each object its last piece that was no other's, and how it moved.
  std::vector<Piece> alone;
  std::vector<Vec3> steps;
  std::vector<size_t> alone_at;
  Following out;
};

// One piece for each holder, the best pairs first.
void Follower::match(const std::vector<Piece> &pieces, std::vector<Heir> &heirs,
                     std::vector<bool> &used) const {
  struct Pair {
    double value;
    size_t holder, piece;
  };
  std::vector<Pair> pairs;
  for (size_t h = 0; h < holders.size(); h++)
    for (size_t p = 0; p < pieces.size(); p++) {
      const double value = overlap(holders[h].piece, holders[h].step, pieces[p]) *
                           likeness(holders[h].piece.area, pieces[p].area);
      if (value >= overlaps) pairs.push_back({value, h, p});
    }
  // Something quick, that does not move as it did: by its size, near to where it was.
  for (size_t h = 0; h < holders.size(); h++)
    for (size_t p = 0; p < pieces.size(); p++) {
      const Piece &from = holders[h].piece;
      const double reach = 3 * from.radius + 2 * length(holders[h].step);
      const double away = length(pieces[p].centre - from.centre) / reach;
      const double alike = likeness(from.area, pieces[p].area);
      if (away < 1 && alike > 0.6) pairs.push_back({overlaps * (1 - away) * alike, h, p});
    }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair &a, const Pair &b) { return a.value > b.value; });
  for (const Pair &pair : pairs) {
    if (used[pair.holder] || heirs[pair.piece].of) continue;
    used[pair.holder] = true;
    heirs[pair.piece].of = pair.holder;
  }
}

// What has no piece of its own any more is in another one, or lost.
void Follower::merge(const std::vector<Piece> &pieces, std::vector<Heir> &heirs,
                     const std::vector<bool> &used) {
  for (size_t h = 0; h < holders.size(); h++) {
    if (used[h]) continue;
    double most = 0;
    size_t into = 0;
    for (size_t p = 0; p < pieces.size(); p++) {
      const double value = std::max(overlap(holders[h].piece, holders[h].step, pieces[p]),
                                    overlap(holders[h].piece, {}, pieces[p]));
      if (heirs[p].of && value > most) {
        most = value;
        into = p;
      }
    }
    if (most >= overlaps)
      heirs[into].taken.push_back(h);
    else
      for (const size_t object : holders[h].objects)
        lost.push_back({object, alone[object], holders[h].step, frame - 1});
  }
}

// Pieces that continue nothing and lie where a holder was: several objects come apart, or one loses a piece.
void Follower::part(const std::vector<Piece> &pieces, std::vector<Heir> &heirs) {
  std::vector<std::vector<size_t>> parts(holders.size());
  for (size_t p = 0; p < pieces.size(); p++) {
    if (heirs[p].of) continue;
    double most = 0;
    size_t from = 0;
    for (size_t h = 0; h < holders.size(); h++) {
      const double value = overlap(holders[h].piece, holders[h].step, pieces[p]);
      if (value > most) {
        most = value;
        from = h;
      }
    }
    if (most >= overlaps) parts[from].push_back(p);
  }
  for (size_t h = 0; h < holders.size(); h++) {
    const std::vector<size_t> &objects = holders[h].objects;
    if (parts[h].empty()) continue;
    if (objects.size() == 1) {
      for (const size_t p : parts[h]) heirs[p].came_off = objects[0];
      continue;
    }
    std::vector<size_t> all = parts[h];
    for (size_t p = 0; p < pieces.size(); p++)
      if (heirs[p].of == h) all.insert(all.begin(), p);
    std::sort(all.begin(), all.end());
    double assignments = 1;
    for (size_t k = 0; k < objects.size(); k++) assignments *= double(all.size());
    if (all.size() > objects.size() || assignments > double(most_assignments)) continue;
    // Every object in one of the pieces, and none of these empty, as sizes and last known places fit best.
    std::vector<size_t> where(objects.size(), 0), best_where;
    double best = INFINITY, next = INFINITY;
    for (size_t n = 0; n < size_t(assignments); n++) {
      size_t rest = n;
      std::vector<double> areas(all.size(), 0);
      double cost = 0;
      for (size_t k = 0; k < objects.size(); k++, rest /= all.size()) {
        where[k] = rest % all.size();
        const Piece &piece = pieces[all[where[k]]], &was = alone[objects[k]];
        areas[where[k]] += was.area;
        const double since = double(frame - alone_at[objects[k]]);
        // For how long it went on as it moved is not known.
        const Vec3 expected = was.centre + steps[objects[k]] * std::min(since, 3.0);
        cost += length(piece.centre - expected) / (2 * was.radius + piece.radius);
      }
      bool is_whole = true;
      for (size_t k = 0; k < all.size(); k++) {
        is_whole = is_whole && areas[k] > 0;
        if (areas[k] > 0) cost += 2 * std::abs(std::log(areas[k] / pieces[all[k]].area));
      }
      if (!is_whole) continue;
      if (cost < best) {
        next = best;
        best = cost;
        best_where = where;
      } else {
        next = std::min(next, cost);
      }
    }
    for (const size_t p : all) {
      heirs[p].of = h;
      heirs[p].is_part = true;
    }
    for (size_t k = 0; k < objects.size(); k++) heirs[all[best_where[k]]].given.push_back(objects[k]);
    for (Touch &touch : out.touches)
      if (touch.last + 1 == frame && touch.objects == objects) touch.is_sure = next - best >= clear;
  }
}

// An object that was lost near by, of that size.
std::optional<size_t> Follower::found_again(const Piece &piece) {
  double nearest = 1;
  std::optional<size_t> best;
  for (size_t i = 0; i < lost.size(); i++) {
    const Lost &one = lost[i];
    const double since = double(frame - one.frame);
    const Vec3 expected = one.piece.centre + one.step * since;
    const double reach = 3 * one.piece.radius + length(one.step) * since;
    const double away = length(piece.centre - expected) / reach;
    if (likeness(one.piece.area, piece.area) > 0.6 && away < nearest) {
      nearest = away;
      best = i;
    }
  }
  if (!best) return {};
  const size_t object = lost[*best].object;
  lost.erase(lost.begin() + ptrdiff_t(*best));
  return object;
}

std::vector<size_t> Follower::objects_of(const Piece &piece, const Heir &heir) {
  std::vector<size_t> objects = heir.given;
  if (heir.of && !heir.is_part) objects = holders[*heir.of].objects;
  for (const size_t h : heir.taken)
    objects.insert(objects.end(), holders[h].objects.begin(), holders[h].objects.end());
  if (objects.empty()) {
    if (const std::optional<size_t> known = heir.came_off ? std::nullopt : found_again(piece)) {
      objects = {*known};
    } else {
      objects = {out.objects.size()};
      out.objects.emplace_back();
      out.objects.back().path.resize(frame_count);
      alone.push_back(piece);
      steps.emplace_back();
      alone_at.push_back(frame);
      if (heir.came_off) out.splits.push_back({*heir.came_off, objects[0], frame});
    }
  }
  std::sort(objects.begin(), objects.end());
  return objects;
}

void Follower::note_touch(const std::vector<size_t> &objects, size_t at) {
  for (Touch &touch : out.touches)
    if (touch.last + 1 == at && touch.objects == objects) {
      touch.last = at;
      return;
    }
  out.touches.push_back({objects, at, at, true});
}

void Follower::add(const std::vector<Piece> &pieces) {
  lost.erase(
      std::remove_if(lost.begin(), lost.end(), [&](const Lost &one) { return frame - one.frame > memory; }),
      lost.end());
  std::vector<Heir> heirs(pieces.size());
  std::vector<bool> used(holders.size());
  match(pieces, heirs, used);
  merge(pieces, heirs, used);
  part(pieces, heirs);
  std::vector<Holder> now;
  for (size_t p = 0; p < pieces.size(); p++) {
    const Heir &heir = heirs[p];
    Holder holder = {objects_of(pieces[p], heir), pieces[p], {}};
    const bool goes_on = heir.of && !heir.is_part && heir.taken.empty();
    if (goes_on) holder.step = pieces[p].centre - holders[*heir.of].piece.centre;
    for (const size_t object : holder.objects) out.objects[object].path[frame] = pieces[p].centre;
    if (holder.objects.size() > 1) {
      note_touch(holder.objects, frame);
    } else {
      const size_t object = holder.objects[0];
      out.objects[object].radius = std::max(out.objects[object].radius, pieces[p].radius);
      if (out.objects[object].area == 0) out.objects[object].area = pieces[p].area;
      alone[object] = pieces[p];
      steps[object] = holder.step;
      alone_at[object] = frame;
    }
    now.push_back(std::move(holder));
  }
  holders = std::move(now);
  frame++;
}

Following Follower::finish(double seconds) {
  const size_t least =
      std::min(size_t(std::ceil(least_life / seconds - 1e-9)), std::max<size_t>(1, frame_count / 2));
  std::vector<size_t> number(out.objects.size(), SIZE_MAX);
  std::vector<Object> kept;
  for (size_t i = 0; i < out.objects.size(); i++) {
    const auto &path = out.objects[i].path;
    const auto there =
        size_t(std::count_if(path.begin(), path.end(), [](const auto &c) { return c.has_value(); }));
    if (there < least) continue;
    number[i] = kept.size();
    kept.push_back(std::move(out.objects[i]));
  }
  Following result;
  result.objects = std::move(kept);
  for (Touch &touch : out.touches) {
    std::vector<size_t> objects;
    for (const size_t object : touch.objects)
      if (number[object] != SIZE_MAX) objects.push_back(number[object]);
    touch.objects = std::move(objects);
    if (touch.objects.size() > 1) result.touches.push_back(std::move(touch));
  }
  for (const Split &split : out.splits)
    if (number[split.from] != SIZE_MAX && number[split.object] != SIZE_MAX)
      result.splits.push_back({number[split.from], number[split.object], split.frame});
  return result;
}

} // namespace

std::vector<Piece> pieces_of(const geometry::Mesh &mesh) {
  const decimate::Pieces found = decimate::find_pieces(mesh, decimate::first_alike(mesh, false));
  const auto corner = [&](size_t i) {
    const double *p = &mesh.positions[3 * size_t(mesh.faces[i])];
    return Vec3{p[0], p[1], p[2]};
  };
  std::vector<Piece> all(found.faces.size());
  std::vector<Vec3> origins(all.size()), sums(all.size());
  std::vector<bool> has_origin(all.size());
  for (size_t f = 0; f < mesh.face_count(); f++) {
    const uint32_t piece = found.of_vertex[mesh.faces[3 * f]];
    // From its first corner: in coordinates of maps little would be left of the sums.
    if (!has_origin[piece]) origins[piece] = corner(3 * f);
    has_origin[piece] = true;
    const Vec3 middle = (corner(3 * f) - origins[piece]) + (corner(3 * f + 1) - origins[piece]) +
                        (corner(3 * f + 2) - origins[piece]);
    const double area = decimate::face_area(mesh, f);
    sums[piece] += middle * (area / 3);
    all[piece].area += area;
  }
  std::vector<size_t> vertices(all.size());
  for (const uint32_t piece : found.of_vertex)
    if (piece != UINT32_MAX) vertices[piece]++;
  for (size_t i = 0; i < all.size(); i++)
    if (all[i].area > 0) all[i].centre = origins[i] + sums[i] * (1 / all[i].area);
  std::vector<size_t> seen(all.size());
  for (size_t v = 0; v < mesh.vertex_count(); v++) {
    const uint32_t piece = found.of_vertex[v];
    if (piece == UINT32_MAX) continue;
    const double *p = &mesh.positions[3 * v];
    const Vec3 place{p[0], p[1], p[2]};
    all[piece].radius = std::max(all[piece].radius, length(place - all[piece].centre));
    if (seen[piece]++ % (1 + vertices[piece] / most_places) == 0) all[piece].places.push_back(place);
  }
  double largest = 0;
  for (const Piece &piece : all) largest = std::max(largest, piece.area);
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&](const Piece &p) { return !(p.area > 0) || p.area < least_area * largest; }),
            all.end());
  std::stable_sort(all.begin(), all.end(), [](const Piece &a, const Piece &b) { return a.area > b.area; });
  return all;
}

Following follow(const std::vector<std::vector<Piece>> &frames, double seconds) {
  Follower follower(frames.size(), seconds);
  for (const std::vector<Piece> &pieces : frames) follower.add(pieces);
  return follower.finish(seconds);
}

} // namespace fvv::objects
