/* hebra VERB ...: finds the verb and hands over. */
#include "cli/cli.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>

/* All verbs, in the order of `hebra --help`. */
static const cli_verb *const verbs[] = {&cli_verb_run,   &cli_verb_solve, &cli_verb_trace,   &cli_verb_modes,
                                        &cli_verb_check, &cli_verb_info,  &cli_verb_export,  &cli_verb_render,
                                        &cli_verb_plot,  &cli_verb_bench, &cli_verb_validate};
enum { VERB_COUNT = sizeof verbs / sizeof verbs[0], LONGEST_WORD = 32 };

/* The text of `hebra --help`. */
static void print_help(FILE *to) {
  fputs("hebra simulates elastic rods: bending, twisting, inextensible, in three dimensions.\n\n"
        "usage: hebra VERB ...\n\n",
        to);
  for (int i = 0; i < VERB_COUNT; i++) fprintf(to, "  %-8s %s\n", verbs[i]->name, verbs[i]->summary);
  fputs("\n  hebra VERB --help   what a verb does, its arguments, an example\n"
        "  hebra --version     version of the program and of the library\n\n"
        "Exit status: 0 done, 1 the run failed, 2 the input is wrong.\n\n"
        "Example:\n"
        "  hebra run scenes/thesis-2-catenary.yaml -o out/catenary\n"
        "  hebra render out/catenary/trajectory.h5 -o out/catenary/picture.png\n",
        to);
}

/* Smallest number of letters to insert, drop or exchange between two words; a long word counts as far away.
 */
static int word_distance(const char *a, const char *b) {
  int previous[LONGEST_WORD + 1], current[LONGEST_WORD + 1];
  int length_a = (int)strlen(a), length_b = (int)strlen(b);
  if (length_a > LONGEST_WORD || length_b > LONGEST_WORD) return LONGEST_WORD;
  for (int j = 0; j <= length_b; j++) previous[j] = j;
  for (int i = 1; i <= length_a; i++) {
    current[0] = i;
    for (int j = 1; j <= length_b; j++) {
      int best = previous[j - 1] + (a[i - 1] != b[j - 1]);
      if (previous[j] + 1 < best) best = previous[j] + 1;
      if (current[j - 1] + 1 < best) best = current[j - 1] + 1;
      current[j] = best;
    }
    memcpy(previous, current, sizeof previous);
  }
  return previous[length_b];
}

/* The verb that a mistyped word comes closest to. */
static const cli_verb *nearest_verb(const char *word) {
  const cli_verb *best = verbs[0];
  for (int i = 1; i < VERB_COUNT; i++)
    if (word_distance(word, verbs[i]->name) < word_distance(word, best->name)) best = verbs[i];
  return best;
}

/* The verb of this name, NULL if there is none. */
static const cli_verb *find_verb(const char *name) {
  for (int i = 0; i < VERB_COUNT; i++)
    if (strcmp(name, verbs[i]->name) == 0) return verbs[i];
  return NULL;
}

/* True if a verb's arguments ask for help, up to a lone `--`. */
static bool wants_help(int argc, char **argv) {
  for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++)
    if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) return true;
  return false;
}

/* Prints a verb's help; it ends in one line break whatever the text does. */
static int print_verb_help(const cli_verb *verb) {
  size_t length = strlen(verb->help);
  printf("%s%s", verb->help, length > 0 && verb->help[length - 1] == '\n' ? "" : "\n");
  return CLI_DONE;
}

/* Does what the arguments say. */
static int obey(int argc, char **argv) {
  const char *word = argv[1];
  if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "help") == 0) {
    const cli_verb *verb = argc > 2 ? find_verb(argv[2]) : NULL;
    if (verb) return print_verb_help(verb);
    print_help(stdout);
    return CLI_DONE;
  }
  if (strcmp(word, "--version") == 0) {
    printf("hebra %s (library %s)\n", HB_VERSION, hb_version());
    return CLI_DONE;
  }
  const cli_verb *verb = find_verb(word);
  if (!verb) {
    fprintf(stderr, "hebra: there is no verb '%s'; the nearest one is '%s'.\nhebra --help lists all verbs.\n",
            word, nearest_verb(word)->name);
    return CLI_BAD_INPUT;
  }
  return wants_help(argc - 1, argv + 1) ? print_verb_help(verb) : verb->run(argc - 1, argv + 1);
}

/* Finds out what is wanted. Output that could not be written (a full disk) turns success into failure. */
int main(int argc, char **argv) {
  if (argc < 2) {
    print_help(stderr);
    return CLI_BAD_INPUT;
  }
  signal(SIGXFSZ, SIG_IGN); /* a file that may grow no more is an error of the write, with a sentence */
  int status = obey(argc, argv);
  if (fflush(stdout) != 0 || ferror(stdout)) {
    fputs("hebra: cannot write to standard output\n", stderr);
    if (status == CLI_DONE) status = CLI_FAILED;
  }
  return status;
}
