// An environment of two parts, two pictures and three lights, small enough to be taken apart byte by byte.
#pragma once

#include "fvv/environment.h"
#include "fvv_catch.h"

#include <vector>

using Bytes = std::vector<uint8_t>;

// As much of a file as can be checked without decoding.
inline Bytes jpeg_file(uint8_t width, uint8_t height) {
  return {0xff, 0xd8, 0xff,   0xfe, 0,     3, 7, 0xff, 0xc0, 0,    11,
          8,    0,    height, 0,    width, 1, 1, 0x11, 0,    0xff, 0xd9};
}
inline Bytes png_file(uint8_t width, uint8_t height) {
  return {0x89, 'P', 'N', 'G', '\r',  '\n', 0x1a, '\n', 0,      0,   0,   13,   'I',  'H',  'D',
          'R',  0,   0,   0,   width, 0,    0,    0,    height, 8,   2,   0,    0,    0,    1,
          2,    3,   4,   0,   0,     0,    0,    'I',  'E',    'N', 'D', 0xae, 0x42, 0x60, 0x82};
}

// A square of two faces at height z, 8 steps wide.
inline Bytes square_mesh(int32_t z, bool texture, uint8_t profile = FVV_MESH_RAW) {
  int32_t positions[12] = {0, 0, z, 8, 0, z, 8, 8, z, 0, 8, z};
  uint32_t faces[6] = {0, 1, 2, 0, 2, 3}, coordinates[8] = {0, 0, 16, 0, 16, 16, 0, 16};
  const fvv_mesh mesh = {positions, faces, 4, 2, texture ? coordinates : nullptr, uint8_t(texture ? 4 : 0),
                         nullptr,   0,     {}};
  fvv_bytes payload = {};
  REQUIRE(fvv_mesh_encode(&mesh, profile, 7, nullptr, &payload, nullptr) == FVV_OK);
  const Bytes out(payload.data, payload.data + payload.size);
  fvv_bytes_free(&payload);
  return out;
}

struct Environment {
  std::vector<Bytes> meshes = {square_mesh(0, true), square_mesh(40, false, FVV_MESH_DRACO)};
  std::vector<Bytes> files = {jpeg_file(32, 16), png_file(5, 3)};
  std::vector<fvv_environment_part> parts = {
      {nullptr, 0, 1, {65535, 32768, 7}, FVV_PART_UNLIT | FVV_PART_CLAMPED, {-2, 0.5}, {4, 1.5}},
      {nullptr, 0, FVV_NO_PICTURE, {100, 200, 300}, FVV_PART_DOUBLE_SIDED, {0, 0}, {1, 1}}};
  std::vector<fvv_environment_picture> pictures = {{FVV_PICTURE_JPEG, 32, 16, nullptr, 0},
                                                   {FVV_PICTURE_PNG, 5, 3, nullptr, 0}};
  std::vector<fvv_light> lights = {
      {FVV_LIGHT_DIRECTIONAL,
       FVV_LIGHT_CASTS_SHADOWS,
       {0, 0, 0},
       {0, -0.6, 0.8},
       {1, 0.5, 0.25},
       1000,
       0,
       0,
       0},
      {FVV_LIGHT_POINT, 0, {1, 2, 3}, {0, 0, 0}, {1, 1, 1}, 40.5, 20, 0, 0},
      {FVV_LIGHT_SPOT, FVV_LIGHT_CASTS_SHADOWS, {0, 4, 0}, {0, -1, 0}, {0, 0, 1}, 0, 0, 0.25, 0.75}};
  double origin[3] = {-1, 0.5, 2}, step = 0.25;

  // Borrows from this.
  fvv_environment view() {
    for (size_t i = 0; i < parts.size(); i++) {
      parts[i].mesh = meshes[i].data();
      parts[i].mesh_size = meshes[i].size();
    }
    for (size_t i = 0; i < pictures.size(); i++) {
      pictures[i].data = files[i].data();
      pictures[i].size = files[i].size();
    }
    return {{origin[0], origin[1], origin[2]},
            step,
            parts.data(),
            parts.size(),
            pictures.data(),
            pictures.size(),
            lights.data(),
            lights.size(),
            nullptr,
            {}};
  }
  fvv_status encode(Bytes &out, fvv_diagnostic *diagnostic = nullptr) {
    const fvv_environment environment = view();
    fvv_bytes payload = {};
    const fvv_status status = fvv_environment_encode(&environment, nullptr, &payload, diagnostic);
    out.assign(payload.data, payload.data + payload.size);
    fvv_bytes_free(&payload);
    return status;
  }
  Bytes payload() {
    Bytes out;
    REQUIRE(encode(out) == FVV_OK);
    return out;
  }
};
