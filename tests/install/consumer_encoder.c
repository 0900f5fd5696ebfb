/* Encodes ten frames of a turning square pyramid, seen by one camera, and decodes them again: the encoder in
 * C, with the frames of consumer_encode.cpp. */
#include <fvv/encoder.h>
#include <fvv/stream.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { width = 64, height = 48, frames = 10 };

static int tell(fvv_status status, const fvv_diagnostic *diagnostic) {
  char line[512];
  fvv_diagnostic_format(diagnostic, NULL, line, sizeof line);
  fprintf(stderr, "%s (%s)\n", line, fvv_status_text(status));
  return 1;
}

static fvv_status add_frame(fvv_encoder *encoder, int number, fvv_diagnostic *diagnostic) {
  static const uint32_t faces[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 0, 2, 1, 0, 3, 2};
  static unsigned char pixels[width * height * 3];
  const double x = cos(number / 10.0), y = sin(number / 10.0);
  const double positions[] = {x, y, 0, -y, x, 0, -x, -y, 0, y, -x, 0, 0, 0, -1};
  fvv_encoder_picture picture = {NULL, width, height, 3, 8, 0};
  fvv_encoder_frame frame = {sizeof frame};
  memset(pixels, 20 * number, sizeof pixels);
  picture.pixels = pixels;
  frame.positions = positions;
  frame.vertex_count = 5;
  frame.faces = faces;
  frame.face_count = 6;
  frame.camera_count = 1;
  frame.pictures = &picture;
  return fvv_encoder_add_frame(encoder, &frame, diagnostic);
}

static fvv_status encode(const char *path, fvv_encoder_report *report, fvv_diagnostic *diagnostic) {
  const fvv_encoder_option named[] = {{"codec", "jpeg"}};
  fvv_encoder_options options = {sizeof options};
  fvv_encoder_camera input = {sizeof input};
  fvv_camera camera;
  fvv_encoder *encoder;
  fvv_status status;
  int i;
  options.group = 5;
  options.named = named;
  options.named_count = 1;
  memset(&camera, 0, sizeof camera);
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 60;
  camera.cx = width / 2;
  camera.cy = height / 2;
  camera.rotation[0] = camera.rotation[4] = camera.rotation[8] = 1;
  camera.translation[2] = 3; /* metres in front of the camera */
  camera.r_max = fvv_camera_r_max(&camera);
  input.calibration = &camera;
  status = fvv_encoder_create_file(path, &options, &encoder, diagnostic);
  if (status >= 0) status = fvv_encoder_add_camera(encoder, &input, diagnostic);
  for (i = 0; i < frames && status >= 0; i++) status = add_frame(encoder, i, diagnostic);
  if (status >= 0) status = fvv_encoder_finish(encoder, report, diagnostic);
  fvv_encoder_destroy(encoder);
  return status;
}

static fvv_status read_at(void *user, uint64_t offset, void *out, size_t size) {
  FILE *file = user;
  if (fseek(file, (long)offset, SEEK_SET) != 0) return FVV_ERROR_IO;
  return fread(out, 1, size, file) == size ? FVV_OK : FVV_ERROR_IO;
}

/* Vertices of all frames. */
static fvv_status decode(const char *path, unsigned long *vertices, fvv_diagnostic *diagnostic) {
  FILE *file = fopen(path, "rb");
  fvv_input input = {read_at, NULL, 0};
  fvv_stream *stream = NULL;
  const fvv_configuration *configuration = NULL;
  fvv_status status;
  size_t i, track = 0;
  if (!file || fseek(file, 0, SEEK_END) != 0) return FVV_ERROR_IO;
  input.user = file;
  input.size = (uint64_t)ftell(file);
  status = fvv_stream_open(&input, NULL, NULL, &stream, diagnostic);
  if (status >= 0) status = fvv_stream_configuration(stream, 0, &configuration, diagnostic);
  while (status >= 0 && configuration->tracks[track].kind != FVV_TRACK_MESH) track++;
  for (i = 0; status >= 0 && i < fvv_stream_frame_count(stream); i++) {
    fvv_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    status = fvv_stream_mesh(stream, i, configuration->tracks[track].id, &mesh, diagnostic);
    *vertices += mesh.vertex_count;
    fvv_mesh_free(&mesh);
  }
  fvv_stream_close(stream);
  fclose(file);
  return status;
}

int main(int argc, char **argv) {
  fvv_encoder_report report = {sizeof report};
  fvv_diagnostic diagnostic = {0};
  unsigned long vertices = 0;
  fvv_status status;
  if (argc != 2) return 2;
  status = encode(argv[1], &report, &diagnostic);
  if (status < 0) return tell(status, &diagnostic);
  status = decode(argv[1], &vertices, &diagnostic);
  if (status < 0) return tell(status, &diagnostic);
  printf("%lu frames, %lu vertices\n", (unsigned long)report.frames, vertices);
  return 0;
}
