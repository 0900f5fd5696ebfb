/* A program as a user of the installed library writes it: prints the frames of a file, and the vertices of
 * the first mesh track in frame 0. */
#include <fvv/stream.h>

#include <stdio.h>

static int tell(fvv_status status, const fvv_diagnostic *diagnostic, const char *name) {
  char line[512];
  fvv_diagnostic_format(diagnostic, name, line, sizeof line);
  fprintf(stderr, "%s (%s)\n", line, fvv_status_text(status));
  return 1;
}

static uint16_t mesh_track(const fvv_configuration *configuration) {
  size_t i;
  for (i = 0; i < configuration->track_count; i++)
    if (configuration->tracks[i].kind == FVV_TRACK_MESH) return configuration->tracks[i].id;
  return 0;
}

int main(int argc, char **argv) {
  fvv_input input;
  fvv_stream *stream = NULL;
  const fvv_configuration *configuration = NULL;
  fvv_mesh mesh;
  fvv_diagnostic diagnostic;
  fvv_status status;
  if (argc != 2) return 2;
  status = fvv_input_file_open(argv[1], &input, &diagnostic);
  if (status < 0) return tell(status, &diagnostic, argv[1]);
  status = fvv_stream_open(&input, NULL, NULL, &stream, &diagnostic);
  if (status < 0) return tell(status, &diagnostic, argv[1]);
  status = fvv_stream_configuration(stream, 0, &configuration, &diagnostic);
  if (status >= 0) status = fvv_stream_mesh(stream, 0, mesh_track(configuration), &mesh, &diagnostic);
  if (status < 0) return tell(status, &diagnostic, argv[1]);
  printf("fvv %s: %lu frames, %lu vertices\n", fvv_version(), (unsigned long)fvv_stream_frame_count(stream),
         (unsigned long)mesh.vertex_count);
  fvv_mesh_free(&mesh);
  fvv_stream_close(stream);
  fvv_input_file_close(&input);
  return 0;
}
