/* Golden micro-rods (V49): energy, quasi-static frames and forces of three small rods with both ends clamped,
 * from independent programs in 40 digits that minimise the energy's definition over the material angles. */
#include "sim/sim.h"
#include "support/near.h"
#include "support/rods.h"

#include <string.h>

/* Input and answers. Directors are given unprojected; only the interior edges' and the free vertices' answers
 * are listed, from edge 1 and vertex 2 on. */
typedef struct golden {
  int nv;
  double rest[7][3], x[7][3], rest_m1[6][3];
  double first_m1[3], last_m1[3];
  double B[2], beta;
  double energy;
  double m1[4][3], force[3][3], projected[3][3];
} golden;

static const golden rods[] = {
    {6,
     {{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {0.30000000000000004, 0, 0}, {0.4, 0, 0}, {0.5, 0, 0}},
     {{0, 0, 0},
      {0.1, 0, 0},
      {0.19085409600397962, 0.04045084971874737, 0.010452846326765347},
      {0.2748841708178281, 0.06140190045084728, 0.06045284632676534},
      {0.3345201430093265, 0.021176929297503498, 0.12991868337266507},
      {0.36400899560553746, -0.04829445385670806, 0.19552458627171582}},
     {{0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}},
     {0, 1, 0},
     {1, 0, 0.3},
     {0.02, 0.02},
     0.015,
     0.1305099659844573,
     {{-0.3666756758532269, 0.8919355214398333, -0.26457508259742046},
      {-0.0008486524367659661, 0.9228113872525808, -0.3852511172547184},
      {0.6535681447154004, 0.745750207468877, -0.12924901652777288}},
     {{0.1409744398877782, -0.14283887774526896, 0.8284702077169468},
      {-0.23284125036674436, -1.6123030772213944, 0.09434967066069092}},
     {{-0.04878780732663207, 0.12282877375878495, -0.051273702972631785},
      {0.24215204066370316, -0.28141353735847163, -0.37084162346620275}}},
    {7,
     {{0, 0, 0},
      {0.1, 0, 0},
      {0.2, 0, 0},
      {0.30000000000000004, 0, 0},
      {0.4, 0, 0},
      {0.5, 0, 0},
      {0.6, 0, 0}},
     {{0, 0, 0},
      {0.1, 0, 0},
      {0.19563047559630356, 0.02923717047227368, 0},
      {0.2818254682593282, 0.06943055564565598, 0.03090169943749474},
      {0.35097284790227457, 0.08925824769558337, 0.10036753648339447},
      {0.3915308266695385, 0.04870026892831948, 0.18228274091229366},
      {0.40137185101430073, -0.021322257731647587, 0.2529934190309484}},
     {{0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}},
     {0, 1, 0},
     {0.2, 1, 0.4},
     {0.02, 0.06},
     0.015,
     0.19239435868691557,
     {{-0.2847613169215298, 0.9314122990957779, -0.22667624815633666},
      {-0.22153575963985953, 0.8468320641252886, -0.48352596866155334},
      {0.12199252190594642, 0.9157359755545628, -0.3828125490029818},
      {0.4268676195969417, 0.8764852731203253, 0.22261536636725998}},
     {{-0.17872420949786708, 0.5455782768894163, 1.7311057358738666},
      {-0.6446958499293498, 0.6868283847029013, 0.6416908625636925},
      {0.8401340850601001, -1.7129561769606623, -0.7642227693855741}},
     {{-0.0861977903517687, 0.2819402682796308, 1.07934216112307},
      {-0.11220194643816805, 1.165959668360596, 0.002045287128874085},
      {1.379682229700168, -0.598407479052419, -0.9793947407769266}}},
    {7,
     {{0, 0, 0},
      {0.08, 0, 0},
      {0.1964354871531196, 0.029030627471960127, 0},
      {0.28624417634208843, 0.089607353216374, 0.019101299543362336},
      {0.3474925631513182, 0.16006556239496395, 0.054938094497892366},
      {0.38629893100054546, 0.26668518179176565, 0.09400627303275116},
      {0.39660274478169805, 0.36471942137409236, 0.15323565164740738}},
     {{0, 0, 0},
      {0.08, 0, 0},
      {0.19599241497166725, -0.028920157169843252, 0.010458689129718979},
      {0.2943181544034956, -0.01858570551992876, 0.05867951527651749},
      {0.34840893038174126, 0.05319517863943178, 0.10251662995542524},
      {0.36853668152132374, 0.1673453277471355, 0.13357491536772773},
      {0.3284429262205027, 0.2573973765566967, 0.19280429398238397}},
     {{0, 0, 1}, {0, 0.1, 1}, {0.1, 0, 1}, {0.2, 0.1, 1}, {0.2, -0.2, 1}, {0.3, -0.4, 1}},
     {0, 0.2, 1},
     {1, 0.1, 0.5},
     {0.03, 0.012},
     0.02,
     0.119097163519872,
     {{-0.057109483297876296, 0.12897100364501188, 0.9900025187524767},
      {-0.4198474840063256, -0.16751825050828123, 0.8920009674435353},
      {-0.2341668912630295, -0.3720688604214642, 0.898181846922371},
      {0.46954089264858845, -0.30793333132485995, 0.8274710953199156}},
     {{-0.2649426865426753, -0.30939748158101305, 1.1852926312416725},
      {0.0479175549567962, 1.0438572209485966, -0.8790140158826979},
      {1.0036435086824607, -0.329630094335548, -0.052080805519890264}},
     {{-0.22023971059028946, -0.5448183238660025, 0.9360546266735106},
      {0.46146060897708796, 0.8194364201465004, -0.74636185527484},
      {1.1891923205122559, -0.22971718603317232, 0.07361913008274877}}}};

/* The rod as a scene: clamped vertices and frames at both ends. */
static void make(rod_case *c, const golden *g) {
  rod_case_straight(c, g->nv, 1, 1, g->beta);
  hb_rod_def *def = &c->def.rods[0];
  memcpy(def->rest, g->rest, 3 * (size_t)g->nv * sizeof(double));
  memcpy(def->initial, g->x, 3 * (size_t)g->nv * sizeof(double));
  def->rest_m1 = rod_array(3 * (g->nv - 1));
  memcpy(def->rest_m1, g->rest_m1, 3 * (size_t)(g->nv - 1) * sizeof(double));
  rod_set_bending(def, g->B[0], 0, g->B[1]);
  for (int i = 0; i < 2; i++) {
    rod_hold_vertex(def, i);
    rod_hold_vertex(def, -1 - i);
  }
  rod_hold_director(def, 0, g->first_m1, 0);
  rod_hold_director(def, -1, g->last_m1, 0);
}

/* Compares what a simulation of the rod measures with the answers. general: keeps the closed form out. */
static void check(const golden *g, bool general) {
  rod_case c;
  hb_error err;
  hb_sim *sim = NULL;
  hb_frame *frame = NULL;
  make(&c, g);
  if (general) c.def.rods[0].viscosity = rod_array(g->nv); /* all 0 */
  assert_int_equal(hb_model_create(&c.def, &c.model, &err), HB_OK);
  assert_int_equal(hb_sim_create(c.model, &sim, &err), HB_OK);
  assert_int_equal(hb_frame_create(c.model, &frame, &err), HB_OK);
  hb_sim_measure(sim, frame);
  assert_near(hb_sim_initial_correction(sim), 0, 1e-15);
  assert_near(frame->bending + frame->twisting, g->energy, 1e-13);
  assert_near(frame->kinetic, 0, 0);
  assert_near_array(frame->m1 + 3, &g->m1[0][0], 3 * (g->nv - 3), 1e-11);
  double f[21];
  memcpy(f, hb_sim_const_state(sim)->force, 3 * (size_t)g->nv * sizeof(double));
  assert_near_array(f + 6, &g->force[0][0], 3 * (g->nv - 4), 1e-11);
  for (int k = 0; k < 3 * g->nv; k++)
    f[k] *= c.model->inv_mass[k]; /* unit masses; clamped vertices feel none */
  hb_project_velocities(c.model, &c.model->rods[0], hb_sim_const_state(sim)->x, f,
                        &sim->stepper.project_work);
  assert_near_array(f + 6, &g->projected[0][0], 3 * (g->nv - 4), 1e-11);
  hb_frame_free(frame);
  hb_sim_free(sim);
  rod_case_free(&c);
}

/* G1, in closed form and by Newton. */
static void test_isotropic(void **state) {
  (void)state;
  check(&rods[0], false);
  check(&rods[0], true);
}

/* G2. */
static void test_anisotropic(void **state) {
  (void)state;
  check(&rods[1], false);
}

/* G3. */
static void test_curved(void **state) {
  (void)state;
  check(&rods[2], false);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_isotropic), cmocka_unit_test(test_anisotropic),
                                     cmocka_unit_test(test_curved)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
