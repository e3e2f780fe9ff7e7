/* Policy: a multilayer perceptron that computes commands from observations.

   Its numbers are one array; see policy_open for their order. */
#ifndef CARDSFLOW_POLICY_H
#define CARDSFLOW_POLICY_H

#include <stddef.h>

/* Parts of an observation: joint positions; velocities times the step; the task coordinates; reference minus
   position; velocity of the reference times the step; activations of muscles. */
enum policy_part { POLICY_Q, POLICY_QD, POLICY_Y, POLICY_ERROR, POLICY_RATE, POLICY_ACTIVATIONS, POLICY_PARTS };

enum policy_activation { POLICY_LINEAR, POLICY_TANH, POLICY_RELU, POLICY_ELU, POLICY_SIGMOID, POLICY_ACTIVATIONS_END };

typedef struct {
    size_t inputs, outputs, layers, parts, activations;
    size_t width;                /* of the widest layer, at least the inputs */
    double step, max_input;      /* in [s]; largest sound input after normalisation */
    int is_sigmoid;              /* whether muscles have excitations as in MyoSuite */
    const double *part;          /* enum policy_part */
    const double *activation;    /* index of each activation among the states of muscles */
    const double *target;        /* of each output: 0 force or torque, 1 command; its index */
    const double *mean, *scale;  /* normalised input: (input - mean) scale */
    const double *network;       /* layers */
    const double *low, *high, *fallback; /* of the outputs */
} policy;

/* Read numbers: inputs, outputs, layers, parts, activations, step, max_input, is_sigmoid; part, activation,
   target (2 each), mean, scale; each layer: rows, columns, enum policy_activation, weights row by row, bias;
   low, high, fallback. The numbers must outlive the policy. Return nonzero if they are malformed. */
int policy_open(policy *p, const double *numbers, size_t count);

/* Compute outputs, within low and high. `scratch` has 2 width numbers. Return 0; or 1 if an input is not
   finite or beyond max_input, or a result is not finite: the outputs are then the fallback. */
int policy_evaluate(const policy *p, const double *inputs, double *scratch, double *outputs);

#endif
