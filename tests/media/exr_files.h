/* OpenEXR files of many kinds by OpenEXR's C++ library, for the tests of fvv_media. */
#ifndef FVV_TESTS_MEDIA_EXR_FILES_H
#define FVV_TESTS_MEDIA_EXR_FILES_H

#include "fvv_media/exr.h"
#include "pictures.h"

#include <ImfCompression.h>
#include <ImfPixelType.h>

constexpr uint32_t exr_width = 23, exr_height = 38;

struct ExrKind {
  OPENEXR_IMF_NAMESPACE::Compression compression = OPENEXR_IMF_NAMESPACE::ZIP_COMPRESSION;
  OPENEXR_IMF_NAMESPACE::PixelType type = OPENEXR_IMF_NAMESPACE::HALF;
  std::vector<std::string> channels = {"R", "G", "B"};
  int tile = 0;     /* side; 0: scan lines */
  int sampling = 1; /* of the last channel, along x */
  int overscan = 0; /* pixels by which the data window is larger on each side */
  int first_x = 0, first_y = 0;
  bool decreasing = false;
  float red_x = 0;    /* of the chromaticities; 0: none are written */
  size_t comment = 0; /* characters */
};

/* What write_exr writes: 0 ... 1, exact in half and float. */
float exr_sample(const std::string &channel, uint32_t x, uint32_t y);

/* Writes a file of exr_width x exr_height; returns its name. */
std::string write_exr(const std::string &name, const ExrKind &kind);
void write_two_parts(const std::string &name);
void write_deep(const std::string &name);

/* One float channel of a file. */
std::vector<float> read_channel(const std::string &name, const std::string &channel, int width, int height);

#endif
