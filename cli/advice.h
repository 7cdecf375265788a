/* What a user can do about a run that failed. */
#ifndef HB_CLI_ADVICE_H
#define HB_CLI_ADVICE_H

#include "hebra/hebra.h"

/* Prints sentences to stderr about likely causes of a failed step: a step above the stable one, supports
 * further apart than the rod between them is long. sim: after the failure. */
void cli_advice(const hb_sim *sim);

#endif
