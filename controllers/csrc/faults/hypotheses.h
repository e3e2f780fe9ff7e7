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

#endif
