/* Link = twist + writhe in every frame of every scene whose rods have held ends; and what winding them up and
 * letting them pass through themselves does to it. */
#include "support/near.h"

#include "hebra/hebra.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Prints if the tests are asked to be talkative. */
#define say(...)                                                                                             \
  do {                                                                                                       \
    if (getenv("HEBRA_TEST_VERBOSE")) print_message(__VA_ARGS__);                                            \
  } while (0)

/* A scene that runs. */
typedef struct running {
  hb_scene_def def;
  hb_model *model;
  hb_sim *sim;
  hb_frame *frame;
} running;

/* From a file of scenes/, or from a text. */
static void begin(running *r, const char *name, const char *text) {
  hb_error err = {HB_OK, ""};
  char path[700];
  memset(r, 0, sizeof *r);
  snprintf(path, sizeof path, "%s/scenes/%s", HEBRA_SOURCE_DIR, name ? name : "");
  hb_status status = text ? hb_scene_parse(text, strlen(text), "scene", ".", NULL, 0, &r->def, &err)
                          : hb_scene_read(path, NULL, 0, &r->def, &err);
  if (status || hb_model_create(&r->def, &r->model, &err)) fail_msg("%s", err.text);
}

/* Simulation and frame. */
static void start(running *r) {
  hb_error err = {HB_OK, ""};
  if (hb_sim_create(r->model, &r->sim, &err) || hb_frame_create(r->model, &r->frame, &err))
    fail_msg("%s", err.text);
}

/* Frees it. */
static void end(running *r) {
  hb_frame_free(r->frame);
  hb_sim_free(r->sim);
  hb_model_free(r->model);
  hb_scene_def_free(&r->def);
}

/* The link of a rod now, which must close to round-off. */
static hb_link look(running *r, int rod) {
  hb_link link;
  hb_error err = {HB_OK, ""};
  hb_sim_measure(r->sim, r->frame);
  assert_int_equal(hb_frame_link(r->model, r->frame, rod, &link, &err), HB_OK);
  assert_true(link.defined);
  assert_at_most(link.error, 1e-12);
  return link;
}

/* Steps. */
static void advance(running *r, long steps) {
  hb_error err = {HB_OK, ""};
  if (hb_sim_advance(r->sim, steps, &err)) fail_msg("%s", err.text);
}

/* The gallery: frames as the run would write them, from the beginning, within a budget of pairs of edges. */
static void gallery(void **state) {
  (void)state;
  static const char *const rooms[] = {"", "statics/", "rings/"};
  int scenes = 0;
  for (int room = 0; room < 3; room++) {
    char path[600];
    snprintf(path, sizeof path, "%s/scenes/%s", HEBRA_SOURCE_DIR, rooms[room]);
    DIR *directory = opendir(path);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));) {
      size_t length = strlen(entry->d_name);
      if (length < 5 || strcmp(entry->d_name + length - 5, ".yaml") != 0) continue;
      char name[400];
      running r;
      int defined = 0, frames = 0, first = -1;
      double worst = 0;
      snprintf(name, sizeof name, "%s%s", rooms[room], entry->d_name);
      begin(&r, name, NULL);
      for (int k = 0; k < r.model->rod_count; k++)
        if (hb_link_defined(r.model, k)) {
          defined++;
          if (first < 0) first = k;
        }
      if (defined > 0) {
        start(&r);
        double pairs = 0;
        for (; pairs < 3e5 && frames < 40; frames++) {
          for (int k = 0; k < r.model->rod_count; k++)
            if (hb_link_defined(r.model, k)) {
              worst = fmax(worst, look(&r, k).error);
              pairs += 0.5 * r.model->rods[k].nv * r.model->rods[k].nv;
            }
          advance(&r, r.def.output.every);
        }
        scenes++;
        say("%-32s %3d rods, %2d frames, off by at most %.1e\n", name, defined, frames, worst);
      }
      end(&r);
    }
    closedir(directory);
  }
  assert_true(scenes >= 6);
}

#define ROD                                                                                                  \
  "rods:\n  - rest: {line: {to: [1, 0, 0], vertices: 31}}\n    bending: 1\n    twisting: 1\n"                \
  "    linear_density: 1\n    damping: {mass: 20}\n    lengths: initial\n    start: {clamp: true, "          \
  "material_angle: 0}\n"

/* A straight rod between fixed clamps that was wound up by w turns has twist + writhe = w while it buckles:
 * the number is that of the scene. */
static void winding_is_kept(void **state) {
  (void)state;
  running r;
  begin(&r, NULL,
        "method: {time_step: 2e-4, duration: 1}\n" ROD
        "    initial: {displace: [0, 0.2*sin(pi*u)^2, 0.05*sin(2*pi*u)^2]}\n"
        "    end: {clamp: true, material_angle: 2*pi*2.3}\n");
  start(&r);
  hb_link link = look(&r, 0);
  assert_near(link.twist + link.writhe, 2.3, 1e-12);
  for (int n = 0; n < 20; n++) {
    advance(&r, 100);
    link = look(&r, 0);
    assert_near(link.twist + link.writhe, 2.3, 1e-12);
  }
  say("buckled: twist %.4f, writhe %.4f, closing %.4f\n", link.twist, link.writhe, link.closing);
  assert_true(fabs(link.writhe) > 0.05);
  end(&r);
}

/* A formula that turns the end winds it: twist + writhe follows the formula, turn after turn. */
static void turning_ends(void **state) {
  (void)state;
  running r;
  begin(&r, NULL,
        "method: {time_step: 2e-4, duration: 1}\n" ROD "    initial: {displace: [0, 0.05*sin(pi*u)^2, 0]}\n"
        "    end: {clamp: true, material_angle: 30*t}\n");
  start(&r);
  double offset = look(&r, 0).twist + look(&r, 0).writhe;
  for (int n = 1; n <= 10; n++) {
    advance(&r, 100);
    hb_link link = look(&r, 0);
    assert_near(link.twist + link.writhe - offset, 30 * 0.02 * n / (2 * 3.14159265358979323846), 1e-12);
  }
  end(&r);
}

/* Ends that are free to turn have no link. */
static void free_ends(void **state) {
  (void)state;
  running r;
  hb_link link;
  hb_error err = {HB_OK, ""};
  begin(&r, NULL, "method: {time_step: 2e-4, duration: 1}\n" ROD);
  start(&r);
  hb_sim_measure(r.sim, r.frame);
  assert_int_equal(hb_frame_link(r.model, r.frame, 0, &link, &err), HB_OK);
  assert_false(link.defined);
  assert_false(hb_link_defined(r.model, 0));
  end(&r);
}

/* All of it. */
int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(gallery), cmocka_unit_test(winding_is_kept),
                                     cmocka_unit_test(turning_ends), cmocka_unit_test(free_ends)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
