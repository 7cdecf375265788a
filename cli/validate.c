/* hebra validate: cases with known answers, computed and compared. */
#include "cli/validate.h"
#include "base/clock.h"
#include "base/memory.h"
#include "base/threads.h"
#include "cli/cli.h"
#include "output/file.h"

#include <dirent.h>
#include <getopt.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* The arguments. */
typedef struct options {
  const char *cases, *output; /* directories; NULL: not given */
  bool fast, list, no_plots, quiet, json;
  int threads; /* 0: one per processor */
  char **names;
  int name_count;
} options;

/* What the threads share. */
typedef struct crew {
  cli_validation *v;
  atomic_int next, done;
  bool terminal, quiet;
} crew;

/* Parses argv; an exit status, or -1 to go on. */
static int parse(int argc, char **argv, options *opt) {
  static const struct option longs[] = {{"output", required_argument, NULL, 'o'},
                                        {"cases", required_argument, NULL, 'c'},
                                        {"threads", required_argument, NULL, 't'},
                                        {"fast", no_argument, NULL, 'f'},
                                        {"list", no_argument, NULL, 'l'},
                                        {"no-plots", no_argument, NULL, 'n'},
                                        {"quiet", no_argument, NULL, 'q'},
                                        {"json", no_argument, NULL, 'j'},
                                        {NULL, 0, NULL, 0}};
  *opt = (options){.threads = 0};
  opterr = 0;
  optind = 1;
  for (int c; (c = getopt_long(argc, argv, ":o:q", longs, NULL)) != -1;) {
    char *end = NULL;
    switch (c) {
    case 'o': opt->output = optarg; break;
    case 'c': opt->cases = optarg; break;
    case 'f': opt->fast = true; break;
    case 'l': opt->list = true; break;
    case 'n': opt->no_plots = true; break;
    case 'q': opt->quiet = true; break;
    case 'j': opt->json = true; break;
    case 't': {
      long n = strtol(optarg, &end, 10);
      if (*end || end == optarg || n < 1 || n > HB_THREADS_MAX)
        return cli_usage(&cli_verb_validate, "--threads \"%s\" is not a whole number from 1 to %d", optarg,
                         HB_THREADS_MAX);
      opt->threads = (int)n;
      break;
    }
    case ':': return cli_usage(&cli_verb_validate, "%s needs a value", argv[optind - 1]);
    default: return cli_usage(&cli_verb_validate, "%s is not an option", argv[optind - 1]);
    }
  }
  opt->names = argv + optind;
  opt->name_count = argc - optind;
  return -1;
}

/* Does the text end like this? */
static bool ends_with(const char *text, const char *end) {
  size_t n = strlen(text), m = strlen(end);
  return n > m && strcmp(text + n - m, end) == 0;
}

/* Is there a directory of that name? */
static bool is_directory(const char *path) {
  struct stat about;
  return stat(path, &about) == 0 && S_ISDIR(about.st_mode);
}

/* Where the cases are: as asked for, below the current directory, or beside the program (installed, or in the
 * directory where it was built). */
static hb_status find_directory(const options *opt, char path[PATH_MAX], hb_error *err) {
  static const char *const places[] = {"../share/hebra/scenes/validation", "../../scenes/validation",
                                       "../scenes/validation"};
  char program[PATH_MAX] = "";
  if (opt->cases) {
    if (!is_directory(opt->cases) || strlen(opt->cases) >= PATH_MAX)
      return hb_fail(err, HB_ERR_INPUT, "--cases %s: there is no directory of that name", opt->cases);
    snprintf(path, PATH_MAX, "%s", opt->cases);
    return HB_OK;
  }
  snprintf(path, PATH_MAX, "scenes/validation");
  if (is_directory(path)) return HB_OK;
  ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
  program[length > 0 ? length : 0] = 0;
  char *slash = strrchr(program, '/');
  if (slash) *slash = 0;
  for (size_t k = 0; slash && k < sizeof places / sizeof places[0]; k++)
    if (snprintf(path, PATH_MAX, "%.3000s/%s", program, places[k]) < PATH_MAX && is_directory(path))
      return HB_OK;
  return hb_fail(err, HB_ERR_INPUT,
                 "there is no directory scenes/validation here or beside the program; --cases DIR names one");
}

/* Adds the case of a check file. */
static hb_status add_case(cli_validation *v, const char *path, hb_error *err) {
  cli_case *c = NULL;
  hb_status status = cli_case_read(path, &c, err);
  if (status) return status;
  cli_case **grown = hb_realloc(v->cases, (size_t)v->case_count + 1, sizeof *v->cases);
  if (!grown) {
    cli_case_free(c);
    return hb_fail_memory(err, "cases");
  }
  v->cases = grown;
  v->cases[v->case_count++] = c;
  return HB_OK;
}

/* Order of cases: by number, then by name; those without a number last. */
static int by_number(const void *a, const void *b) {
  const cli_case *p = *(cli_case *const *)a, *q = *(cli_case *const *)b;
  int order = strcmp(p->id ? p->id : "~", q->id ? q->id : "~");
  return order ? order : strcmp(p->name, q->name);
}

/* Every NAME.check.yaml of a directory. */
static hb_status read_directory(cli_validation *v, const char *directory, hb_error *err) {
  DIR *listing = opendir(directory);
  hb_status status = HB_OK;
  if (!listing) return hb_fail(err, HB_ERR_INPUT, "%s: the directory of cases cannot be opened", directory);
  for (struct dirent *entry; !status && (entry = readdir(listing));) {
    if (!ends_with(entry->d_name, ".check.yaml")) continue;
    char *path = hb_file_join(directory, "%s", entry->d_name);
    status = path ? add_case(v, path, err) : hb_fail_memory(err, "name of a case");
    hb_free(path);
  }
  closedir(listing);
  if (!status && v->case_count == 0)
    return hb_fail(err, HB_ERR_INPUT, "%s: the directory holds no file NAME.check.yaml", directory);
  if (!status) qsort(v->cases, (size_t)v->case_count, sizeof *v->cases, by_number);
  return status;
}

/* A file of the user: the check file itself, or the scene that has one beside it. */
static hb_status add_file(cli_validation *v, const char *path, hb_error *err) {
  size_t length = strlen(path);
  char *beside = hb_alloc(length + 16, 1);
  if (!beside) return hb_fail_memory(err, "name of a case");
  const char *dot = strrchr(path, '.');
  snprintf(beside, length + 16, "%.*s.check.yaml", (int)(dot - path), path);
  bool own = ends_with(path, ".check.yaml") || access(beside, F_OK) != 0;
  hb_status status = add_case(v, own ? path : beside, err);
  hb_free(beside);
  return status;
}

/* Is the argument a file, not the name of a case? */
static bool is_file(const char *argument) {
  return ends_with(argument, ".yaml") || ends_with(argument, ".yml") || strchr(argument, '/');
}

/* Keeps the named cases, or the fast ones; the others are freed. */
static hb_status select_cases(cli_validation *v, const options *opt, hb_error *err) {
  int names = 0, kept = 0;
  for (int n = 0; n < opt->name_count; n++) {
    bool known = is_file(opt->names[n]);
    names += !known;
    for (int k = 0; !known && k < v->case_count; k++)
      known = strcmp(opt->names[n], v->cases[k]->name) == 0 ||
              (v->cases[k]->id && strcmp(opt->names[n], v->cases[k]->id) == 0);
    if (!known)
      return hb_fail(err, HB_ERR_INPUT, "there is no case \"%s\"; hebra validate --list shows them all",
                     opt->names[n]);
  }
  for (int k = 0; k < v->case_count; k++) {
    cli_case *c = v->cases[k];
    bool wanted = names == 0;
    for (int n = 0; !wanted && n < opt->name_count; n++)
      wanted = strcmp(opt->names[n], c->name) == 0 || (c->id && strcmp(opt->names[n], c->id) == 0);
    if (opt->fast && !c->fast && c->deed != CLI_NOT_YET) wanted = false;
    if (wanted)
      v->cases[kept++] = c;
    else
      cli_case_free(c);
  }
  v->case_count = kept;
  return HB_OK;
}

/* Cases that were asked for, all understood. */
static hb_status gather(cli_validation *v, const options *opt, hb_error *err) {
  char directory[PATH_MAX];
  int files = 0;
  for (int n = 0; n < opt->name_count; n++) files += is_file(opt->names[n]);
  hb_status status = HB_OK;
  if (files < opt->name_count || opt->name_count == 0) {
    status = find_directory(opt, directory, err);
    if (!status) status = read_directory(v, directory, err);
  }
  if (!status) status = select_cases(v, opt, err);
  for (int n = 0; !status && n < opt->name_count; n++)
    if (is_file(opt->names[n])) status = add_file(v, opt->names[n], err);
  for (int k = 0; !status && k < v->case_count; k++) status = cli_case_rehearse(v->cases[k], err);
  return status;
}

/* Points of all cases, slow cases first so that none is left running alone at the end; within a case in
 * order. */
static hb_status make_points(cli_validation *v, hb_error *err) {
  size_t count = 0;
  for (int k = 0; k < v->case_count; k++)
    count += (size_t)v->cases[k]->variants * (size_t)v->cases[k]->mesh_count;
  v->points = hb_alloc(count, sizeof *v->points);
  if (!v->points) return hb_fail_memory(err, "points of cases");
  for (int fast = 0; fast < 2; fast++)
    for (int k = 0; k < v->case_count; k++) {
      const cli_case *c = v->cases[k];
      if (c->fast != (fast == 1) || c->deed == CLI_NOT_YET) continue;
      for (int i = 0; i < c->variants * c->mesh_count; i++)
        v->points[v->point_count++] =
            (cli_point){.of = c, .variant = i / c->mesh_count, .mesh = i % c->mesh_count};
    }
  return HB_OK;
}

/* Takes point after point until none is left. */
static void work(void *context, int index, int worker) {
  crew *all = context;
  (void)index;
  (void)worker;
  for (int k; (k = atomic_fetch_add(&all->next, 1)) < all->v->point_count;) {
    cli_point *p = &all->v->points[k];
    cli_point_compute(p, p->mesh == p->of->mesh_count - 1);
    int done = atomic_fetch_add(&all->done, 1) + 1, total = all->v->point_count;
    if (all->quiet) continue;
    if (all->terminal)
      fprintf(stderr, "\r%d of %d points, %s \033[K", done, total, p->of->name);
    else if (done * 10 / total != (done - 1) * 10 / total)
      fprintf(stderr, "%3d%%  %d of %d points\n", done * 100 / total, done, total);
  }
}

/* All points on all threads. */
static hb_status compute(cli_validation *v, const options *opt, hb_error *err) {
  hb_pool *pool = NULL;
  crew all = {.v = v, .terminal = isatty(STDERR_FILENO) == 1, .quiet = opt->quiet};
  int threads = opt->threads ? opt->threads : hb_processors();
  if (threads > v->point_count) threads = v->point_count > 0 ? v->point_count : 1;
  hb_status status = hb_pool_create(threads, &pool, err);
  if (status) return status;
  double started = hb_clock_now();
  v->threads = hb_pool_threads(pool);
  hb_pool_run(pool, v->threads, work, &all);
  v->seconds = hb_clock_now() - started;
  hb_pool_free(pool);
  if (all.terminal && !all.quiet) fprintf(stderr, "\r\033[K");
  return HB_OK;
}

/* Names, files and titles. */
static void print_list(const cli_validation *v) {
  for (int k = 0; k < v->case_count; k++) {
    const cli_case *c = v->cases[k];
    printf("%-4s %-28s %-9s %-5s %s%s%s%s\n", c->id ? c->id : "", c->name, cli_deed_words[c->deed],
           c->fast ? "fast" : "", c->title, c->not_yet ? " (" : "", c->not_yet ? c->not_yet : "",
           c->not_yet ? ")" : "");
  }
}

/* Plots, reports, table. Without gnuplot there are no plots, and a word about it. */
static hb_status publish(const cli_validation *v, const options *opt, hb_error *err) {
  const char *directory = opt->output ? opt->output : "out/validate";
  hb_error missing = {HB_OK, ""};
  bool plots = !opt->no_plots;
  hb_status status = plots ? cli_validation_plot(v, directory, &missing) : HB_OK;
  if (status == HB_ERR_MISSING) {
    fprintf(stderr, "note: no plots: %s\n", missing.text);
    plots = false;
  } else if (status)
    return hb_fail(err, status, "%s", missing.text);
  status = cli_validation_report(v, directory, plots, err);
  if (status) return status;
  cli_validation_print(v, opt->json ? stderr : stdout, opt->quiet);
  if (!opt->quiet) fprintf(stderr, "reports in %s/report.md and %s/report.json\n", directory, directory);
  if (!opt->json) return HB_OK;
  char *path = hb_file_join(directory, "report.json"), buffer[4096];
  FILE *file = path ? fopen(path, "rb") : NULL;
  for (size_t n; file && (n = fread(buffer, 1, sizeof buffer, file)) > 0;) fwrite(buffer, 1, n, stdout);
  if (file) fclose(file);
  hb_free(path);
  return HB_OK;
}

/* The verb. */
static int validate_verb(int argc, char **argv) {
  options opt;
  cli_validation v = {.case_count = 0};
  hb_error err = {HB_OK, ""};
  int result = parse(argc, argv, &opt);
  if (result >= 0) return result;
  hb_status status = gather(&v, &opt, &err);
  if (!status && opt.list)
    print_list(&v);
  else {
    if (!status) status = make_points(&v, &err);
    if (!status) status = compute(&v, &opt, &err);
    if (!status) status = cli_validation_judge(&v, &err);
    if (!status) status = publish(&v, &opt, &err);
  }
  result = status ? cli_fail("validate", &err) : CLI_DONE;
  for (int k = 0; !status && k < v.case_count; k++)
    if (!opt.list && !cli_case_holds(&v, v.cases[k])) result = CLI_FAILED;
  for (int k = 0; k < v.point_count; k++) cli_point_free(&v.points[k]);
  for (int k = 0; k < v.case_count; k++) cli_case_free(v.cases[k]);
  hb_free(v.points);
  hb_free(v.verdicts);
  hb_free(v.cases);
  return result;
}

const cli_verb cli_verb_validate = {
    "validate", "compute cases with known answers and compare",
    "usage: hebra validate [CASE ...] [--fast] [--cases DIR] [-o DIR] [--threads N] [--no-plots] [--quiet] "
    "[--json]\n"
    "       hebra validate --list\n"
    "\n"
    "Computes scenes whose results are known (formulas, published numbers, other programs), compares, and "
    "measures\n"
    "how the errors fall on finer meshes. Prints what was expected, found, and allowed; leaves in DIR\n"
    "  report.md, NAME.png   for people: a table, a section and a plot for every case\n"
    "  report.json           the same for programs\n"
    "\n"
    "  CASE                  name or number of a case (--list shows them), or a check file of your own; "
    "default: all\n"
    "  --fast                only those that are computed in a moment\n"
    "  --list                show the cases, compute nothing\n"
    "  --cases DIR           directory of the cases (default: scenes/validation here, or beside the "
    "program)\n"
    "  -o, --output DIR      where the reports go (default out/validate)\n"
    "  --threads N           points computed at a time (default: one for each processor)\n"
    "  --no-plots            without plots (they need gnuplot)\n"
    "  -q, --quiet           no progress; of the results only what fails, and the last line\n"
    "  --json                print report.json to standard output, and the table to standard error\n"
    "\n"
    "Exit status: 0 all hold, 1 something fails, 2 the input is wrong.\n"
    "\n"
    "example: hebra validate V02 V12 -o out/validate\n",
    validate_verb};
