/* A fishing rod, by hand: no scene file, only the library. It is clamped at its lower end and sags under its
 * weight and that of a fish that bites after one second. Prints the tip and the energies, and leaves a
 * trajectory.
 *
 *   cc -std=c17 example.c $(pkg-config --cflags --libs hebra) -o example && ./example */
#include <hebra/hebra.h>

#include <stdio.h>

enum { VERTICES = 41 };

/* Everything that the definition points to; it must outlive the simulation. */
typedef struct fishing_rod {
  double shape[3 * VERTICES], mass[VERTICES], B[3 * (VERTICES - 1)], beta[VERTICES];
  hb_support_def supports[3];
  hb_force_def forces[2];
  hb_rod_def rod;
  hb_scene_def scene;
} fishing_rod;

/* Length 3 m, carbon fibre, tapering from 8 mm to 2 mm radius: stiffness and mass from the section. */
static hb_status make_rod(fishing_rod *f, hb_error *err) {
  const double foot[3] = {0, 0, 0}, top[3] = {1.5, 0, 2.6}, E = 60e9, G = 20e9, density = 1600;
  hb_status status = hb_curve_line(foot, top, VERTICES, f->shape, err);
  double edge = hb_curve_length(f->shape, VERTICES) / (VERTICES - 1);
  for (int i = 0; !status && i < VERTICES; i++) {
    hb_section section = {.kind = HB_SECTION_CIRCLE, .a = 0.008 - 0.006 * i / (VERTICES - 1)};
    hb_section_moduli m;
    status = hb_section_compute(&section, E, G, density, &m, err);
    if (status) break;
    bool end = i == 0 || i == VERTICES - 1;
    f->mass[i] = m.mass_per_length * edge * (end ? 0.5 : 1.0);
    f->beta[i] = m.beta;
    if (i + 1 < VERTICES) { /* B11, B12, B22 of the edge */
      f->B[3 * i] = f->B[3 * i + 2] = m.B11;
      f->B[3 * i + 1] = 0;
    }
  }
  hb_rod_def_init(&f->rod);
  f->rod.nv = VERTICES;
  f->rod.rest = f->rod.initial = f->shape; /* starts in its rest shape */
  f->rod.mass = f->mass;
  f->rod.B = f->B;
  f->rod.beta = f->beta;
  f->rod.mass_damping = 1.0;
  f->rod.radius = 0.008;
  return status;
}

/* The lowest edge is held: its first vertex, its direction, its material frame. */
static void clamp_foot(fishing_rod *f) {
  const hb_support_kind kinds[3] = {HB_SUPPORT_POSITION, HB_SUPPORT_TANGENT, HB_SUPPORT_ANGLE};
  for (int k = 0; k < 3; k++) {
    hb_support_def_init(&f->supports[k]);
    f->supports[k].kind = kinds[k];
    f->supports[k].index = 0;
    f->supports[k].held = true;
  }
  f->rod.supports = f->supports;
  f->rod.support_count = 3;
}

/* Weight, and the fish: formulas, compiled once. */
static hb_status load(fishing_rod *f, hb_error *err) {
  hb_status status = HB_OK;
  for (int k = 0; k < 2; k++) hb_force_def_init(&f->forces[k]);
  f->forces[0].kind = HB_FORCE_GRAVITY;
  f->forces[1].kind = HB_FORCE_POINT;
  f->forces[1].vertex = -1; /* the last one */
  status = hb_formula_constant(-9.81, &f->forces[0].value[2], err);
  if (!status) status = hb_formula_parse("-8*step(t - 1)", HB_VARS_ALL, NULL, 0, &f->forces[1].value[2], err);
  return status;
}

/* The definition, the model compiled from it, the simulation on it. */
static hb_status simulate(fishing_rod *f, hb_model **model, hb_sim **sim, hb_frame **frame,
                          hb_writer **writer, hb_error *err) {
  hb_scene_def_init(&f->scene);
  f->scene.rods = &f->rod;
  f->scene.rod_count = 1;
  f->scene.forces = f->forces;
  f->scene.force_count = 2;
  f->scene.method.time_step = 1e-4;
  f->scene.method.duration = 3;
  hb_status status = hb_model_create(&f->scene, model, err);
  if (!status) status = hb_sim_create(*model, sim, err);
  if (!status) status = hb_frame_create(*model, frame, err);
  if (status) return status;
  long steps = hb_sim_total_steps(*sim), every = 500;
  status = hb_writer_create("example.h5", *model, 1 + steps / every, writer, err);
  puts("   time      tip x      tip z     kinetic     bending     balance");
  for (long n = 0; !status && n <= steps; n++) {
    if (n > 0) status = hb_sim_step(*sim, err);
    if (status || n % every != 0) continue;
    hb_sim_measure(*sim, *frame);
    const double *tip = (*frame)->position + 3 * (VERTICES - 1);
    printf("%7.3f %10.6f %10.6f %11.6f %11.6f %11.2e\n", (*frame)->time, tip[0], tip[2], (*frame)->kinetic,
           (*frame)->bending, (*frame)->balance);
    status = hb_writer_add(*writer, *frame, err);
  }
  return status;
}

/* Builds, runs, frees what it built, says what went wrong. */
int main(void) {
  static fishing_rod f; /* all zero */
  hb_model *model = NULL;
  hb_sim *sim = NULL;
  hb_frame *frame = NULL;
  hb_writer *writer = NULL;
  hb_error err = {.status = HB_OK};
  hb_status status = make_rod(&f, &err);
  clamp_foot(&f);
  if (!status) status = load(&f, &err);
  if (!status) status = simulate(&f, &model, &sim, &frame, &writer, &err);
  hb_status closing = hb_writer_close(writer, status ? NULL : &err);
  if (!status) status = closing;
  hb_frame_free(frame);
  hb_sim_free(sim);
  hb_model_free(model);
  for (int k = 0; k < 2; k++)
    for (int c = 0; c < 3; c++) hb_formula_free(f.forces[k].value[c]);
  if (status) fprintf(stderr, "example: %s\n", err.text);
  return status == HB_OK ? 0 : 1;
}
