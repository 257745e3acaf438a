#include "system_solution.h"

#include <cmath>

namespace pcl_gpu_icp {

namespace {

/// About x by alpha, then about y by beta, then about z by gamma.
std::array<double, 9> rotationOf(double alpha, double beta, double gamma)
{
  const double ca = std::cos(alpha), sa = std::sin(alpha), cb = std::cos(beta), sb = std::sin(beta);
  const double cg = std::cos(gamma), sg = std::sin(gamma);
  return {cg * cb,
          -sg * ca + cg * sb * sa,
          sg * sa + cg * sb * ca,
          sg * cb,
          cg * ca + sg * sb * sa,
          -cg * sa + sg * sb * ca,
          -sb,
          cb * sa,
          cb * ca};
}

} // namespace

SquareMatrix<6> matrixOf(const System& system)
{
  SquareMatrix<6> matrix{};
  const double* sum = system.sums.data();
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j)
      matrix[i][j] = matrix[j][i] = *sum++;
  return matrix;
}

void setMatrix(System& system, const SquareMatrix<6>& matrix)
{
  double* sum = system.sums.data();
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j)
      *sum++ = matrix[i][j];
}

Spectrum spectrumOf(const System& system)
{
  Spectrum spectrum;
  spectrum.allowed = unknownsOf(system.motions);
  std::array<double, 6> scale{};
  for (int i = 0; i < 6; ++i)
    scale[i] = !spectrum.allowed[i] ? 0 : i < 3 ? 1 / system.length : 1;
  SquareMatrix<6> matrix = matrixOf(system);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      matrix[i][j] *= scale[i] * scale[j];
  spectrum.motions = diagonalise(matrix);
  double largest = 0;
  for (int k = 0; k < 6; ++k) {
    spectrum.values[k] = matrix[k][k];
    largest = std::fmax(largest, matrix[k][k]);
    for (int i = 0; i < 6; ++i) {
      spectrum.shares[k][i] = scale[i] > 0 ? spectrum.motions[i][k] / scale[i] : 0;
      spectrum.motions[i][k] *= scale[i];
    }
  }
  spectrum.noise = system.weight() * system.row_noise * system.row_noise + largest * system.sum_noise;
  return spectrum;
}

Estimate solved(const System& system, double share_of_step)
{
  const Spectrum spectrum = spectrumOf(system);
  const double* right = &system.sums[21];
  Estimate estimate;
  std::array<double, 6> step{};
  for (int k = 0; k < 6; ++k) {
    if (spectrum.isFree(k))
      ++estimate.free_motions;
    if (!spectrum.isDetermined(k))
      continue;
    double share = 0;
    for (int i = 0; i < 6; ++i)
      share += spectrum.motions[i][k] * right[i];
    for (int i = 0; i < 6; ++i)
      step[i] += spectrum.motions[i][k] * share / spectrum.values[k];
  }
  for (double& entry : step)
    entry *= share_of_step;
  estimate.degeneracy = estimate.free_motions > 0 ? Degeneracy::Sliding : Degeneracy::None;

  StageValues& values = estimate.stages;
  const double turn = system.turns_by_halves ? 0.5 : 1;
  RigidTransform motion{rotationOf(turn * step[0], turn * step[1], turn * step[2]), {step[3], step[4], step[5]}};
  if (system.turns_by_halves)
    motion = compose({motion.rotation, {}}, motion);
  values.R = motion.rotation;
  values.source_centroid = values.target_centroid = system.centre;
  for (int i = 0; i < 3; ++i) {
    values.target_centroid[i] += motion.translation[i];
    values.t[i] = values.target_centroid[i];
    for (int j = 0; j < 3; ++j)
      values.t[i] -= values.R[3 * i + j] * system.centre[j];
  }
  return estimate;
}

} // namespace pcl_gpu_icp
