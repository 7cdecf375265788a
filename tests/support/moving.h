/* A collection of smooth motions, one for every kind of force and support; used by the tests of order,
 * restart and allocation. */
#ifndef HB_TEST_MOVING_H
#define HB_TEST_MOVING_H

#include "support/scenes.h"

#define NV 9
#define EDGE 0.125
#define MASS 0.125

/* Free rod: bent and moving. */
static inline void moving_free_rod(hb_scene_def *def) {
  double xyz[3 * NV], line[3 * NV], v[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  shape_bent(NV, EDGE, (double[]){0.5, 0.3, 0.2, 0.1}, xyz);
  hb_rod_def *rod = scene_rod(def, NV, line, 0.05, 0.05, MASS);
  scene_initial(rod, xyz);
  for (int i = 0; i < NV; i++) {
    double s = (double)i / (NV - 1);
    v[3 * i] = 0.1;
    v[3 * i + 1] = 0.3 * s * s;
    v[3 * i + 2] = 0.4 * s - 0.1;
  }
  scene_velocity(rod, v);
}

/* Cantilever under gravity. */
static inline void moving_cantilever(hb_scene_def *def) {
  double line[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  hb_rod_def *rod = scene_rod(def, NV, line, 0.05, 0.05, MASS);
  scene_clamp_start(rod);
  scene_force(def, HB_FORCE_GRAVITY, "0", "0.1", "-0.5");
}

/* Both ends clamped, the far end turning in time. */
static inline void moving_twisted(hb_scene_def *def) {
  double xyz[3 * NV], line[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  shape_bent(NV, EDGE, (double[]){0.6, -0.4, 0.3, 0}, xyz);
  hb_rod_def *rod = scene_rod(def, NV, line, 0.05, 0.03, MASS);
  scene_initial(rod, xyz);
  scene_clamp_start(rod);
  scene_hold(rod, NV - 1);
  scene_hold(rod, NV - 2);
  scene_angle(rod, -1, "4*t^2 + 1");
}

/* Curved at rest, anisotropic, clamped, gravity. */
static inline void moving_anisotropic(hb_scene_def *def) {
  double xyz[3 * NV];
  shape_bent(NV, EDGE, (double[]){0.5, 0.8, 0.4, 0.3}, xyz);
  hb_rod_def *rod = scene_rod(def, NV, xyz, 0.05, 0.03, MASS);
  scene_form(rod, 0.06, 0.01, 0.02);
  scene_clamp_start(rod);
  scene_angle(rod, -1, "0.5*sin(2*t)");
  scene_force(def, HB_FORCE_GRAVITY, "0", "0.2", "-0.4");
}

/* Wind, linear and quadratic, and mass damping; moving from the start. */
static inline void moving_windy(hb_scene_def *def) {
  moving_cantilever(def);
  def->rods[0].mass_damping = 0.7;
  hb_force_def *wind = scene_force(def, HB_FORCE_WIND, "0.1", "0.8*cos(t)", "0.2*x");
  wind->linear[0] = 0.3;
  wind->linear[1] = 0.1;
  wind->quadratic[0] = 0.4;
  wind->quadratic[1] = 0.05;
}

/* Bending viscosity, from rest. */
static inline void moving_viscous(hb_scene_def *def) {
  moving_cantilever(def);
  scene_viscosity(&def->rods[0], 0.002);
}

/* Bending viscosity on an anisotropic free rod that moves from the start. */
static inline void moving_viscous_moving(hb_scene_def *def) {
  moving_free_rod(def);
  scene_form(&def->rods[0], 0.06, 0, 0.03);
  scene_viscosity(&def->rods[0], 0.005);
}

/* A clamp that is carried along and turned. */
static inline void moving_moving_clamp(hb_scene_def *def) {
  double line[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  hb_rod_def *rod = scene_rod(def, NV, line, 0.05, 0.03, MASS);
  scene_path(rod, 0, "0.1*sin(2*t)", "0.2*t^2", NULL);
  scene_tangent(rod, 0, "cos(0.6*t)", "sin(0.6*t)", "0.2*t", false);
  scene_angle(rod, 0, "2*t");
}

/* Both edges guided, the far one by its end vertex, twisted by directors that turn in space. */
static inline void moving_guided_ends(hb_scene_def *def) {
  double xyz[3 * NV], line[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  shape_bent(NV, EDGE, (double[]){0.6, -0.3, 0.2, 0.1}, xyz);
  hb_rod_def *rod = scene_rod(def, NV, line, 0.05, 0.03, MASS);
  scene_initial(rod, xyz);
  scene_path(rod, -1, NULL, NULL, "z + 0.1*sin(t)");
  scene_tangent(rod, -1, "0.98640", "0.3*t - 0.16344", "0.2*sin(t) + 0.01721", true); /* as it starts */
  scene_hold(rod, 0);
  scene_director(rod, 0, "0", "cos(0.5*t)", "sin(0.5*t)", "0.2*t");
  scene_director(rod, -1, "0", "cos(0.8*t)", "-sin(0.8*t)", NULL);
}

/* Loads of every kind, with place and time, dead and following. */
static inline void moving_loaded(hb_scene_def *def) {
  moving_cantilever(def);
  scene_force(def, HB_FORCE_POINT, "0", "0.2*sin(3*t)", "0.1")->vertex = -1;
  scene_force(def, HB_FORCE_DISTRIBUTED, "0.1", "0.3*s*x", "0.1*cos(t) + z");
  scene_force(def, HB_FORCE_PER_VERTEX, "0", "0.05", "0.02*u")->follower = true;
}

typedef struct moving_scene {
  const char *name;
  scene_builder build;
  long steps; /* per unit of time, where the first-order scheme is well in its range */
} moving_scene;

static const moving_scene moving_scenes[] = {
    {"free rod", moving_free_rod, 400},
    {"cantilever", moving_cantilever, 400},
    {"twisted", moving_twisted, 400},
    {"anisotropic", moving_anisotropic, 400},
    {"windy", moving_windy, 400},
    {"viscous", moving_viscous, 400},
    {"viscous moving", moving_viscous_moving, 400},
    {"moving clamp", moving_moving_clamp, 800},
    {"guided ends", moving_guided_ends, 800},
    {"loaded", moving_loaded, 400},
};
enum { MOVING_COUNT = sizeof moving_scenes / sizeof moving_scenes[0] };

#endif
