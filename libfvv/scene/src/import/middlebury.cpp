// *_par.txt of the Middlebury multi-view stereo evaluation (Seitz et al. 2006): the number of pictures, then
// "NAME k11
// ... k33 r11 ... r33 t1 t2 t3" for each, P = K [R t], no distortion. The README of the data only says that
// the origin is top left; pixel centres are taken to lie at integers, as was usual at the time.

#include "fvv_scene/file_io.h"
#include "scene/src/import/camera.h"

namespace fvv::import {

Calibration read_middlebury(const std::string &file, uint32_t width, uint32_t height) {
  const std::string bytes = scene::read_file(file, max_text_size);
  Lines lines(bytes, file);
  std::string_view line;
  if (!lines.next_content(line)) throw Error(file + ": expected the number of pictures, found nothing");
  const auto first = words_of(line);
  if (first.size() != 1) lines.fail("expected the number of pictures alone, found " + scene::quote(line));
  const int64_t count = lines.integer(first[0], "the number of pictures", 1, UINT16_MAX);
  std::vector<scene::Camera> cameras;
  std::vector<std::string> pictures, places;
  while (lines.next_content(line)) {
    const auto words = words_of(line);
    if (words.size() != 22)
      lines.fail("expected a name and 21 numbers (K, R, t), found " + std::to_string(words.size()) +
                 " words");
    double values[21];
    for (int i = 0; i < 21; i++) values[i] = lines.real(words[1 + i], "K, R or t");
    const double *k = values;
    if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
      lines.fail("expected K with k21 = k31 = k32 = 0 and k33 = 1, found others");
    scene::Camera camera;
    fvv_camera &model = camera.calibration;
    model.id = static_cast<uint16_t>(cameras.size());
    model.width = width;
    model.height = height;
    model.fx = k[0];
    model.skew = k[1];
    model.cx = k[2] + 0.5;
    model.fy = k[4];
    model.cy = k[5] + 0.5;
    std::copy(values + 9, values + 18, model.rotation);
    std::copy(values + 18, values + 21, model.translation);
    cameras.push_back(std::move(camera));
    pictures.emplace_back(words[0]);
    places.push_back(lines.where());
    if (static_cast<int64_t>(cameras.size()) > count)
      lines.fail("expected " + std::to_string(count) + " pictures as the first line says, found more");
  }
  if (static_cast<int64_t>(cameras.size()) != count)
    lines.fail("expected " + std::to_string(count) + " pictures as the first line says, found " +
               std::to_string(cameras.size()));
  const std::vector<std::string> names = names_of_pictures(pictures);
  Calibration calibration;
  for (size_t i = 0; i < cameras.size(); i++) {
    cameras[i].set_name(names[i]);
    append(calibration, std::move(cameras[i]), places[i]);
  }
  return calibration;
}

} // namespace fvv::import
