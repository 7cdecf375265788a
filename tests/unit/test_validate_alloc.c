/* Every allocation of the reader of check files, of a point and of the verdicts may fail: a sentence, nothing
 * left behind. */
#include "support/failing_alloc.h"
#include "support/near.h"

#include "cli/common.c"
#include "cli/probe.c"
#include "cli/series.c"
#include "cli/validate_judge.c"
#include "cli/validate_point.c"
#include "cli/validate_read.c"

static const char *const files[] = {"elastica-tip", "ring-spinning", "time-step", "strip-tip",
                                    "euler-trace",  "modes-free",    "capstan"};

/* Reads, rehearses, and computes what is quick. */
static hb_status trial(void *context, hb_error *err) {
  char path[400];
  int k = *(int *)context;
  cli_case *c = NULL;
  snprintf(path, sizeof path, "%s/scenes/validation/%s.check.yaml", HEBRA_SOURCE_DIR, files[k]);
  hb_status status = cli_case_read(path, &c, err);
  if (!status) status = cli_case_rehearse(c, err);
  if (!status && k < 2) {
    cli_point points[CLI_CASE_POINTS] = {{.of = NULL}};
    cli_validation v = {
        .cases = &c, .case_count = 1, .points = points, .point_count = c->variants * c->mesh_count};
    for (int i = 0; !status && i < v.point_count; i++) {
      points[i] = (cli_point){.of = c, .variant = i / c->mesh_count, .mesh = i % c->mesh_count};
      if (i == 0) cli_point_compute(&points[i], true);
      status = points[i].err.status;
      if (status) *err = points[i].err;
    }
    if (!status) status = cli_validation_judge(&v, err);
    hb_free(v.verdicts);
    cli_point_free(&points[0]);
  }
  cli_case_free(c);
  return status;
}

/* All files; where a scene is large, only every seventh allocation. */
static void every_allocation(void **state) {
  (void)state;
  for (int k = 0; k < (int)(sizeof files / sizeof files[0]); k++)
    failing_alloc_loop(trial, &k, k < 2 ? 7 : 3);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(every_allocation)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
