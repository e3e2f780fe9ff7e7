/* Hypotheses about one channel, each with the logarithm of its Bayes factor against no fault. */
#ifndef CARDSFLOW_FAULTS_HYPOTHESES_H
#define CARDSFLOW_FAULTS_HYPOTHESES_H

#include "state.h"

/* A hypothesis: log Bayes factor, and the value of its parameter. */
typedef struct {
    real factor, value;
} fault_fit;

/* `begin`: first tick of the fault. */
fault_fit faults_fit_bias(const faults *s, size_t channel, real begin);
fault_fit faults_fit_scale(const faults *s, size_t channel, real begin);
fault_fit faults_fit_stuck(const faults *s, size_t channel, real begin);
/* A length sensor that measures the length of the muscle `other`. */
fault_fit faults_fit_swap(const faults *s, size_t channel, size_t other, real begin);
/* Tensions: 0; commands multiplied by a factor; a spring with the length of the muscle. */
fault_fit faults_fit_dead(const faults *s, size_t channel, real begin);
fault_fit faults_fit_weak(const faults *s, size_t channel, real begin);
fault_fit faults_fit_jam(const faults *s, size_t channel, real begin);
/* A length sensor at a motor that does not turn. */
fault_fit faults_fit_hold(const faults *s, size_t channel, real begin);

/* A broken, weak or jammed muscle without tension sensor, from the motion. `begin`: its most probable tick. */
fault_fit faults_fit_moved(const faults *s, size_t muscle, enum fault_kind kind, real *begin);
/* With the sums S = y'z, I = y y' of the white innovations z and the signatures y: of the force, of 1 N, of 1 N/m, of the
   force in the first tick. */
fault_fit faults_fit_weakness(const real S[SIGNS], const real I[SIGNS * SIGNS]);
fault_fit faults_fit_break(const real S[SIGNS], const real I[SIGNS * SIGNS]);
fault_fit faults_fit_spring(const faults *s, size_t muscle, const real S[SIGNS], const real I[SIGNS * SIGNS], real force);
/* Log Bayes factor of an unknown load since the same time; 0 if nothing has changed. */
real faults_load_factor(faults *s);

#endif
