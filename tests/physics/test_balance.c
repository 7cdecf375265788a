/* The energy balance: kinetic and stored energy against the work of loads and supports and what damping took.
 * What is left over is made by the scheme, and falls with the order that the scheme claims; with every
 * integrator, in lanes and outside of them. */
#include "support/near.h"

#include "hebra/hebra.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Prints if the tests are asked to be talkative. */
#define say(...)                                                                                             \
  do {                                                                                                       \
    if (getenv("HEBRA_TEST_VERBOSE")) print_message(__VA_ARGS__);                                            \
  } while (0)

#define STEPS 200 /* of the coarsest run */

/* Loads that have a potential and loads that have none, a support that moves and turns, damping. */
#define BODY                                                                                                 \
  "gravity: [0, 0, -9.81]\n"                                                                                 \
  "forces:\n"                                                                                                \
  "  - {point: [0.02*sin(20*t), 0.01, 0], vertex: -1}\n"                                                     \
  "  - {distributed: [0, 0.1*x, 0]}\n"                                                                       \
  "rods:\n"                                                                                                  \
  "  - rest: {line: {to: [0.5, 0, 0], vertices: 11}}\n"                                                      \
  "    initial: {displace: [0, 0, 0.02*sin(2*pi*s)]}\n"                                                      \
  "    lengths: initial\n"                                                                                   \
  "    bending: %s\n"                                                                                        \
  "    twisting: 0.002\n"                                                                                    \
  "    linear_density: 0.05\n"                                                                               \
  "    damping: {mass: 2}\n"                                                                                 \
  "    start: {position: [x, 'y + 0.02*(1 - cos(15*t))', z], tangent: fixed, material_angle: 40*t^2}\n"

/* What a run makes of its balance and of each of the parts. */
typedef struct books {
  double balance, parts[3], energy;
} books;

/* One run to the same time. */
static books run(const char *bending, const char *integrator, hb_lane_choice lanes, int refine) {
  char text[2000];
  hb_scene_def def;
  hb_model *model = NULL;
  hb_sim *sim = NULL;
  hb_frame *frame = NULL;
  hb_error err = {HB_OK, ""};
  int length = snprintf(text, sizeof text, "method: {time_step: 1e-3/%d, duration: 1, integrator: %s}\n",
                        refine, integrator);
  snprintf(text + length, sizeof text - (size_t)length, BODY, bending);
  if (hb_scene_parse(text, strlen(text), "scene", ".", NULL, 0, &def, &err)) fail_msg("%s", err.text);
  def.method.lanes = lanes;
  if (hb_model_create(&def, &model, &err) || hb_sim_create(model, &sim, &err) ||
      hb_frame_create(model, &frame, &err) || hb_sim_advance(sim, (long)STEPS * refine, &err))
    fail_msg("%s", err.text);
  hb_sim_measure(sim, frame);
  books b = {frame->balance,
             {frame->work_loads, frame->work_supports, frame->dissipated},
             frame->kinetic + frame->bending + frame->twisting};
  hb_frame_free(frame);
  hb_sim_free(sim);
  hb_model_free(model);
  hb_scene_def_free(&def);
  return b;
}

/* The order, from the two finest of three runs. */
static void falls_with_the_order(void **state) {
  (void)state;
  static const char *const bendings[] = {"2e-3", "[1e-3, 2e-3]"};
  for (int k = 0; hb_integrators[k]; k++)
    for (int general = 0; general < 2; general++)
      for (int lanes = 0; lanes < 2; lanes++) {
        const hb_integrator *scheme = hb_integrators[k];
        books b[3];
        for (int n = 0; n < 3; n++)
          b[n] = run(bendings[general], scheme->name, lanes ? HB_LANES_PORTABLE : HB_LANES_OFF, 2 << n);
        double order = log2(fabs(b[1].balance / b[2].balance));
        say("%-16s %-8s %-6s balance %.1e %.1e %.1e: order %.2f; loads %.3g, supports %.3g, dissipated %.3g, "
            "energy %.3g\n",
            scheme->name, general ? "general" : "plain", lanes ? "lanes" : "", b[0].balance, b[1].balance,
            b[2].balance, order, b[2].parts[0], b[2].parts[1], b[2].parts[2], b[2].energy);
        assert_near(order, scheme->order, 0.1);
        for (int n = 0; n < 3; n++) assert_true(fabs(b[2].parts[n]) > 20 * fabs(b[2].balance));
      }
}

/* All of it. */
int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(falls_with_the_order)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
