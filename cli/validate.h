/* hebra validate: cases with known answers. A case is a scene and a check file that says what is done with
 * the scene, what is read from the result and what it has to be (docs/guide/validate.md).
 *
 * A case has points: one for every column of `vary` on every mesh. Points know nothing of one another and are
 * computed by any thread; they are judged afterwards, in their order. */
#ifndef HB_CLI_VALIDATE_H
#define HB_CLI_VALIDATE_H

#include "hebra/hebra.h"
#include "scene/tree.h"

#include <stdio.h>

enum { CLI_CASE_READS = 40, CLI_CASE_EXPECTS = 32, CLI_CASE_SETTINGS = 24, CLI_CASE_POINTS = 400 };

/* What is done with the scene. */
typedef enum cli_deed {
  CLI_NOT_YET,   /* nothing: the case is only listed */
  CLI_START,     /* the initial state is measured */
  CLI_SOLVE,     /* as hebra solve */
  CLI_RUN,       /* as hebra run */
  CLI_THRESHOLD, /* the value of a setting from which on the equilibrium has more unstable modes */
  CLI_TRACE,     /* the value of a parameter where the branch of equilibria meets another one */
  CLI_MODES,     /* as hebra modes */
  CLI_DEED_COUNT
} cli_deed;

/* How a quantity that changes in a run becomes a number. */
typedef enum cli_over {
  CLI_LAST,      /* its last value; the only one where nothing moves */
  CLI_AT,        /* its value at a time */
  CLI_MOST,      /* its largest value */
  CLI_LEAST,     /* its smallest value */
  CLI_DRIFT,     /* largest distance from its first value */
  CLI_PERIOD,    /* mean time between passages through a level in the same sense */
  CLI_FREQUENCY, /* circular frequency of a harmonic oscillation, by a fit */
  CLI_REACHES,   /* first time at which it passes a value */
  CLI_OVER_COUNT
} cli_over;

/* What an expectation is about, which decides how it is judged. */
typedef enum cli_kind {
  CLI_EXACT,  /* answer of the discrete problem itself: held on every mesh */
  CLI_SMOOTH, /* answer of the smooth rod: held on the finest mesh, approached at an order */
  CLI_ROUGH   /* an estimate: held on the finest mesh, with a wide tolerance */
} cli_kind;

/* A number that is read from the result; its name may stand in formulas. */
typedef struct cli_read {
  const char *name;
  cli_over over;
  const hb_node *node;  /* text that says what: "position.z[-1]" */
  const hb_node *value; /* time, level, first guess; NULL: none */
} cli_read;

/* A number that is known. Nodes are formulas, worked out at every point. */
typedef struct cli_expect {
  const char *name;
  cli_kind kind;
  const hb_node *find, *is;       /* is: formula, list by column of vary, of lists by mesh, or by mesh */
  bool same;                      /* is: same - as at the first point */
  double within, absolute, limit; /* tolerances: relative, absolute, of the extrapolated value; 0: none */
  double order, order_within;     /* order of convergence and what it may be off; 0: none */
} cli_expect;

/* A case as its check file says it. Texts belong to the tree. */
typedef struct cli_case {
  char *path, *scene; /* files */
  char name[64];      /* of the file, without folder and ending */
  const char *id, *title, *source, *note, *not_yet;
  bool fast;
  cli_deed deed;
  hb_node *root;
  const hb_node *options; /* mapping of the deed */
  const hb_node *set, *vary, *meshes, *size;
  int variants, mesh_count; /* at least 1 */
  cli_read reads[CLI_CASE_READS];
  int read_count;
  cli_expect expects[CLI_CASE_EXPECTS];
  int expect_count;
} cli_case;

/* What one point gave. */
typedef struct cli_point {
  const cli_case *of;
  int variant, mesh;
  hb_error err; /* status HB_OK: the numbers below are there */
  double size;  /* of the mesh, 0: none given */
  double found[CLI_CASE_EXPECTS], expected[CLI_CASE_EXPECTS];
  double seconds;
  double *shape; /* 3 per vertex: where the rods are at the end; NULL: not kept */
  int *rods;     /* number of vertices of every rod, then 0 */
} cli_point;

/* One expectation at one column of vary, over all meshes. */
typedef struct cli_verdict {
  const cli_case *of;
  const cli_expect *expect;
  int variant;
  bool good;
  double found, expected, error, tolerance; /* of the mesh that decides; error and tolerance of one kind */
  bool relative;                            /* they are relative */
  double order, limit_error;                /* measured; NAN: not asked for */
  double share;                             /* error over tolerance, the largest of all that is asked for */
  const char *why; /* what is wrong, NULL: nothing; "" where the point itself failed */
} cli_verdict;

/* Everything of one call. */
typedef struct cli_validation {
  cli_case **cases;
  int case_count;
  cli_point *points;
  int point_count;
  cli_verdict *verdicts;
  int verdict_count;
  double seconds; /* wall */
  int threads;
} cli_validation;

/* ---- validate_read.c: check files ------------------------------------------------------------------------
 */
/* Reads and checks a file. Every mistake is "file:line:column: key: sentence". *out is to be freed with
 * cli_case_free. */
hb_status cli_case_read(const char *path, cli_case **out, hb_error *err);
void cli_case_free(cli_case *c); /* NULL is allowed */
/* Words of the deeds, of the reductions over time, of the kinds. */
extern const char *const cli_deed_words[], *const cli_over_words[], *const cli_kind_words[];

/* ---- validate_point.c: the work --------------------------------------------------------------------------
 */
/* Fills a point whose `of`, variant and mesh are set; failures stay in point->err. keep: keep the shape. */
void cli_point_compute(cli_point *point, bool keep);
void cli_point_free(cli_point *point);
/* Reads the scene of a case and looks whether all names and formulas can be understood, without computing. */
hb_status cli_case_rehearse(const cli_case *c, hb_error *err);

/* ---- validate_judge.c ------------------------------------------------------------------------------------
 */
/* Compares found and expected; makes the list of verdicts. */
hb_status cli_validation_judge(cli_validation *v, hb_error *err);
/* Did everything hold in this case? A case that is only listed: true. */
bool cli_case_holds(const cli_validation *v, const cli_case *c);
/* The first point of a case; its points are in order of columns, then meshes. */
const cli_point *cli_case_points(const cli_validation *v, const cli_case *c);
/* What tells a column of vary from the others: "P = 3"; "" if there is only one. */
void cli_case_label(const cli_case *c, int variant, char *text, size_t size);

/* ---- validate_report.c, validate_plot.c ------------------------------------------------------------------
 */
/* Table on a stream; failures: only what does not hold. */
void cli_validation_print(const cli_validation *v, FILE *to, bool failures);
/* DIR/report.md and DIR/report.json; plots: pictures lie beside them. */
hb_status cli_validation_report(const cli_validation *v, const char *directory, bool plots, hb_error *err);
/* DIR/NAME.png for every case that was computed, by gnuplot. HB_ERR_MISSING if it is not installed. */
hb_status cli_validation_plot(const cli_validation *v, const char *directory, hb_error *err);

#endif
