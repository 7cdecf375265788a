/* The stages of compiling definitions into a model (compile.c calls them in this order). */
#ifndef HB_MODEL_COMPILE_H
#define HB_MODEL_COMPILE_H

#include "hebra/model.h"
#include "math/vec3.h"

/* Fails with "path:line:column: sentence" where the place is known. */
hb_status hb_compile_fail(const hb_scene_def *def, int line, int column, hb_error *err, const char *format,
                          ...) HB_PRINTF(5, 6);
/* Adds a sentence to model->notes. */
hb_status hb_compile_note(hb_model *model, hb_error *err, const char *format, ...) HB_PRINTF(3, 4);

/* Every rule about numbers of one rod that the tables rely on. */
hb_status hb_compile_check_rod(const hb_scene_def *def, int rod, hb_error *err);
double hb_compile_least_tolerance(const hb_method_def *method);
hb_status hb_compile_check_scene(const hb_scene_def *def, hb_error *err);
/* Is the last of nv vertices of a polyline at the place of the first? */
bool hb_compile_is_closed(const double *x, int nv);
/* Rest lengths, curvatures, twists, stiffnesses of one rod into the tables. */
void hb_compile_rest(hb_model *model, int rod);
/* Direction in which the first (last) edge of a rod that is clamped at its end vertex has to be held, from
 * that which it has in the initial shape; after hb_compile_rest. */
hb_v3 hb_compile_wall(const hb_model *model, int rod, const hb_support_def *support, hb_v3 direction);
/* Prescribed vertices and frames, spans and panels of all rods; allocates their tables. */
hb_status hb_compile_supports(hb_model *model, hb_error *err);

#endif
