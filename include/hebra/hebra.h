/* hebra/hebra.h - the whole public face. */
#ifndef HEBRA_H
#define HEBRA_H
#include "hebra/base.h"
#include "hebra/curve.h"
#include "hebra/formula.h"
#include "hebra/model.h"
#include "hebra/modes.h"
#include "hebra/output.h"
#include "hebra/plug.h"
#include "hebra/render.h"
#include "hebra/scene.h"
#include "hebra/sim.h"
#include "hebra/state.h"
#include "hebra/statics.h"
#include "hebra/trace.h"
#endif
