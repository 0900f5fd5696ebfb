/* Writes sound that fvvsynth does not make: stereo.m4a, AAC at 44.1 kHz, and surround.opus with six channels.
 * Each channel has chords of its own. usage: sound_files FOLDER SECONDS */
#include "make_sound.h"

#include <cstdio>
#include <cstdlib>
#include <exception>

int main(int count, char **arguments) {
  if (count != 3) {
    std::fprintf(stderr, "usage: sound_files FOLDER SECONDS\n");
    return 2;
  }
  try {
    const std::string folder = arguments[1];
    const double seconds = std::atof(arguments[2]);
    write_sound(folder + "/stereo.m4a", "aac", tones(44100, 2, seconds), 2, 44100);
    write_sound(folder + "/surround.opus", "libopus", tones(48000, 6, seconds), 6, 48000);
  } catch (const std::exception &error) {
    std::fprintf(stderr, "sound_files: %s\n", error.what());
    return 1;
  }
  return 0;
}
