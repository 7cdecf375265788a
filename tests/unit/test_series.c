/* What becomes of quantities over time: fits to signals whose frequency and passages are known. */
#include "support/near.h"

#include "cli/series.c"

#include <stdlib.h>

enum { COUNT = 4000 };

/* Samples of 0.7 + cos(w t + 1) + 0.3 cos(5.3 w t) + 0.2 cos(17 w t). */
static cli_series signal(double w, double step, double times[COUNT], double values[COUNT]) {
  for (int k = 0; k < COUNT; k++) {
    double t = times[k] = 3 + step * k;
    values[k] = 0.7 + cos(w * t + 1) + 0.3 * cos(5.3 * w * t) + 0.2 * cos(17 * w * t);
  }
  return (cli_series){times, values, COUNT};
}

/* A frequency among others, with and without a first guess; windows hold back the rest. */
static void frequency(void **state) {
  (void)state;
  static double times[COUNT], values[COUNT];
  cli_series s = signal(8.89, 0.002, times, values); /* 11 periods */
  assert_near_rel(cli_series_frequency(&s, 8.5), 8.89, 1e-8);
  s = signal(8.89, 0.004, times, values);
  assert_near_rel(cli_series_frequency(&s, 9), 8.89, 1e-10);
  for (int k = 0; k < COUNT; k++) values[k] = 1e6 + 1e-3 * sin(3.3 * times[k]); /* little on a large mean */
  assert_near_rel(cli_series_frequency(&s, (double)NAN), 3.3, 1e-7);
  s.count = 600; /* less than two periods */
  assert_true(isnan(cli_series_frequency(&s, 3.3)));
  s.count = 3;
  assert_true(isnan(cli_series_frequency(&s, 3.3)));
}

/* Passages between samples: times, periods. */
static void passages(void **state) {
  (void)state;
  static double times[COUNT], values[COUNT];
  for (int k = 0; k < COUNT; k++) {
    times[k] = 0.01 * k;
    values[k] = cos(times[k]);
  }
  cli_series s = {times, values, COUNT};
  assert_near(cli_series_reaches(&s, 0), PI / 2, 1e-9);
  assert_near(cli_series_reaches(&s, 0.5), PI / 3, 1e-9);
  assert_near(cli_series_reaches(&s, 1), 0, 0);
  assert_true(isnan(cli_series_reaches(&s, 2)));
  assert_near(cli_series_period(&s, 0), 2 * PI, 1e-10);
  assert_near(cli_series_period(&s, 0.5), 2 * PI, 1e-9);
  assert_true(isnan(cli_series_period(&s, 1.5)));
  assert_near(cli_series_at(&s, 1), cos(1), 1e-15);
  assert_near(cli_series_at(&s, 1.0037), cos(1.0037), 1e-9);
  assert_near(cli_series_at(&s, 0.003), cos(0.003), 1e-9);
  assert_true(isnan(cli_series_at(&s, 40.5)));
  assert_near(cli_series_drift(&s), 2, 1e-5);
  s.count = 1;
  assert_near(cli_series_at(&s, 0), 1, 0);
  assert_true(isnan(cli_series_period(&s, 0)));
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(frequency), cmocka_unit_test(passages)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
