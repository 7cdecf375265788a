/* Runs a fuzz target over kept inputs without libFuzzer: fuzz_NAME FILE_OR_DIRECTORY ... */
#include <dirent.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Feeds one file to the target. False if it cannot be read. */
static bool replay_file(const char *path) {
  FILE *file = fopen(path, "rb");
  if (!file) return false;
  size_t size = 0, room = 0;
  uint8_t *data = NULL;
  for (;;) {
    if (size == room) {
      room = room ? 2 * room : 4096;
      uint8_t *grown = realloc(data, room);
      if (!grown) break;
      data = grown;
    }
    size_t got = fread(data + size, 1, room - size, file);
    if (got == 0) break;
    size += got;
  }
  bool sound = ferror(file) == 0;
  fclose(file);
  /* An exact copy, so that the address sanitizer sees a read behind the end. */
  uint8_t *exact = sound ? malloc(size ? size : 1) : NULL;
  if (exact) {
    memcpy(exact, data, size);
    LLVMFuzzerTestOneInput(exact, size);
  }
  sound = exact != NULL;
  free(exact);
  free(data);
  return sound;
}

/* Feeds all files of a directory; the number of files, -1 if it is no directory. */
static long replay_directory(const char *path) {
  DIR *directory = opendir(path);
  if (!directory) return -1;
  long count = 0;
  for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
    char name[4096];
    if (entry->d_name[0] == '.') continue;
    snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
    if (!replay_file(name)) fprintf(stderr, "cannot read %s\n", name);
    count++;
  }
  closedir(directory);
  return count;
}

/* Replays everything that is named; fails if nothing was there to replay. */
int main(int argc, char **argv) {
  long total = 0;
  for (int i = 1; i < argc; i++) {
    long count = replay_directory(argv[i]);
    if (count < 0) count = replay_file(argv[i]) ? 1 : 0;
    printf("%s: %ld inputs\n", argv[i], count);
    total += count;
  }
  return total > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
