// Losses: what a squared residual s costs, rho(s), and the weight that its pair gets for it, rho'(s), by a scale c in
// the residuals' unit. All are s where s is far below c^2. Written as in Barron, A General and Adaptive Robust Loss
// Function (CVPR 2019), and for Huber (1964) and Tukey as in Zhang, Parameter Estimation Techniques (1997).
#ifndef PCL_GPU_ICP_LOSS_H
#define PCL_GPU_ICP_LOSS_H

#include "layout.h"

typedef struct {
  uint function; // LOSS_
  real scale_sq; // c^2
} Loss;

static inline lane loss_weight(lane s, Loss loss)
{
  const lane ratio = s / loss.scale_sq;
  if (loss.function == LOSS_HUBER)
    return 1 / sqrt(fmax(ratio, (lane)1));
  if (loss.function == LOSS_CAUCHY)
    return 1 / (1 + ratio);
  if (loss.function == LOSS_GEMAN_MCCLURE)
    return 1 / ((1 + ratio) * (1 + ratio));
  if (loss.function == LOSS_TUKEY) {
    const lane rest = fmax(1 - ratio, (lane)0);
    return rest * rest;
  }
  return exp(-ratio); // LOSS_WELSCH
}

static inline lane loss_cost(lane s, Loss loss)
{
  const lane ratio = s / loss.scale_sq;
  if (loss.function == LOSS_HUBER) {
    const lane beyond = sqrt(fmax(ratio, (lane)1)); // 1 within c
    return fmin(s, loss.scale_sq) + 2 * loss.scale_sq * (beyond - 1);
  }
  if (loss.function == LOSS_CAUCHY)
    return loss.scale_sq * log1p(ratio);
  if (loss.function == LOSS_GEMAN_MCCLURE)
    return s / (1 + ratio);
  if (loss.function == LOSS_TUKEY) {
    const lane rest = fmax(1 - ratio, (lane)0);
    return loss.scale_sq * ((1 - rest * rest * rest) / 3);
  }
  return -loss.scale_sq * expm1(-ratio); // LOSS_WELSCH
}

#endif
