#include "system_solution.h"

#include <cmath>

namespace pcl_gpu_icp {

namespace {

using Vector = std::array<double, 6>;
using Matrix = std::array<Vector, 6>;

/// Rotates rows or columns i and j: what the two-sided Jacobi rotation does to one of their entries.
void rotate(double& a, double& b, double cosine, double sine)
{
  const double held = a;
  a = cosine * held - sine * b;
  b = sine * held + cosine * b;
}

/// Eigenvalues to the diagonal of the symmetric matrix, eigenvectors to the columns of the result: Jacobi's method
/// (Golub and Van Loan, Matrix Computations, 8.5).
Matrix diagonalise(Matrix& a)
{
  constexpr int sweeps_at_most = 32; // five or six are usual
  Matrix vectors{};
  for (int i = 0; i < 6; ++i)
    vectors[i][i] = 1;
  for (int sweep = 0; sweep < sweeps_at_most; ++sweep) {
    int rotations = 0;
    for (int i = 0; i < 5; ++i)
      for (int j = i + 1; j < 6; ++j) {
        // What double cannot add to the diagonal does not count.
        if (std::abs(a[i][i]) + std::abs(a[i][j]) == std::abs(a[i][i]) &&
            std::abs(a[j][j]) + std::abs(a[i][j]) == std::abs(a[j][j]))
          continue;
        ++rotations;
        const double zeta = (a[j][j] - a[i][i]) / (2 * a[i][j]);
        const double tangent = std::copysign(1.0, zeta) / (std::abs(zeta) + std::hypot(1.0, zeta));
        const double cosine = 1 / std::hypot(1.0, tangent), sine = cosine * tangent;
        for (int k = 0; k < 6; ++k)
          rotate(a[k][i], a[k][j], cosine, sine);
        for (int k = 0; k < 6; ++k)
          rotate(a[i][k], a[j][k], cosine, sine);
        for (int k = 0; k < 6; ++k)
          rotate(vectors[k][i], vectors[k][j], cosine, sine);
      }
    if (rotations == 0)
      break;
  }
  return vectors;
}

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

Estimate solved(const System& system, double share_of_step)
{
  // Rotations in units of what they move the lever's end by.
  const double scale[6] = {1 / system.length, 1 / system.length, 1 / system.length, 1, 1, 1};
  Matrix matrix{};
  Vector right{};
  const double* sum = system.sums.data();
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j)
      matrix[i][j] = matrix[j][i] = *sum++ * scale[i] * scale[j];
  for (int i = 0; i < 6; ++i)
    right[i] = *sum++ * scale[i];
  const Matrix vectors = diagonalise(matrix);
  double largest = 0;
  for (int i = 0; i < 6; ++i)
    largest = std::fmax(largest, matrix[i][i]);
  const double noise = system.weight() * system.row_noise * system.row_noise + largest * system.sum_noise;

  Estimate estimate;
  Vector step{};
  for (int k = 0; k < 6; ++k) {
    if (matrix[k][k] <= noise) {
      ++estimate.free_motions;
      continue;
    }
    double share = 0;
    for (int i = 0; i < 6; ++i)
      share += vectors[i][k] * right[i];
    for (int i = 0; i < 6; ++i)
      step[i] += vectors[i][k] * share / matrix[k][k];
  }
  for (double& entry : step)
    entry *= share_of_step;
  estimate.degeneracy = estimate.free_motions > 0 ? Degeneracy::Sliding : Degeneracy::None;

  StageValues& values = estimate.stages;
  values.R = rotationOf(step[0] * scale[0], step[1] * scale[1], step[2] * scale[2]);
  values.source_centroid = values.target_centroid = system.centre;
  for (int i = 0; i < 3; ++i) {
    values.target_centroid[i] += step[3 + i];
    values.t[i] = values.target_centroid[i];
    for (int j = 0; j < 3; ++j)
      values.t[i] -= values.R[3 * i + j] * system.centre[j];
  }
  return estimate;
}

} // namespace pcl_gpu_icp
