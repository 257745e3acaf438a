#include "uncertainty_internals.h"

#include "geometry/rotation_vector.h"
#include "symmetric_eigen.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_gpu_icp {

namespace {

/// The axes of turns (first 0) or of shifts (3). What is not determined counts as far more than everything else.
std::vector<Uncertainty::Axis>
axesOf(const SquareMatrix<6>& covariance, const SquareMatrix<6>& free, const std::array<bool, 6>& allowed, int first)
{
  constexpr double far_more = 1e6;
  double largest = 0;
  for (int i = first; i < first + 3; ++i)
    largest = std::max(largest, covariance[i][i]);
  if (largest == 0)
    largest = 1;
  SquareMatrix<3> block{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      block[i][j] = covariance[first + i][first + j] + far_more * largest * free[first + i][first + j];
  const SquareMatrix<3> vectors = diagonalise(block);
  std::vector<Uncertainty::Axis> axes;
  for (int k = 0; k < 3; ++k) {
    double share_held = 0;
    for (int i = 0; i < 3; ++i)
      share_held += allowed[first + i] ? 0 : vectors[i][k] * vectors[i][k];
    if (share_held > 0.5)
      continue;
    const bool determined = block[k][k] < 1e3 * largest;
    double variance = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        variance += vectors[i][k] * covariance[first + i][first + j] * vectors[j][k];
    axes.push_back({{vectors[0][k], vectors[1][k], vectors[2][k]},
                    determined ? std::sqrt(std::max(variance, 0.0)) : std::numeric_limits<double>::infinity()});
    // Of the two signs the one whose largest entry is positive.
    auto& direction = axes.back().direction;
    const auto entry = std::max_element(
        direction.begin(), direction.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
    if (*entry < 0)
      for (double& x : direction)
        x = -x;
  }
  std::sort(axes.begin(), axes.end(), [](const Uncertainty::Axis& a, const Uncertainty::Axis& b) {
    return a.deviation < b.deviation;
  });
  return axes;
}

/// The matrix as motions, the columns of the other, have it.
SquareMatrix<6> betweenMotions(const SquareMatrix<6>& matrix, const SquareMatrix<6>& motions)
{
  SquareMatrix<6> between{};
  for (int k = 0; k < 6; ++k)
    for (int l = 0; l < 6; ++l)
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j)
          between[k][l] += motions[i][k] * matrix[i][j] * motions[j][l];
  return between;
}

/// Adds weight v v^T.
void addSquare(const std::array<double, 6>& v, double weight, SquareMatrix<6>& sum)
{
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      sum[i][j] += weight * v[i] * v[j];
}

} // namespace

Uncertainty uncertaintyOf(const System& system, const Spectrum& spectrum, double sigma)
{
  const SquareMatrix<6> matrix = matrixOf(system);
  const SquareMatrix<6>& motions = spectrum.motions;
  // The system between the motions that are determined: its inverse there is the covariance.
  SquareMatrix<6> between = betweenMotions(matrix, motions);
  for (int k = 0; k < 6; ++k)
    for (int l = 0; l < 6; ++l)
      if (!spectrum.isDetermined(k) || !spectrum.isDetermined(l))
        between[k][l] = 0;
  const SquareMatrix<6> mixed = diagonalise(between);
  SquareMatrix<6> covariance{}, free{};
  Uncertainty result;
  for (int k = 0; k < 6; ++k) {
    std::array<double, 6> motion{};
    for (int i = 0; i < 6; ++i)
      for (int l = 0; l < 6; ++l)
        motion[i] += motions[i][l] * mixed[l][k];
    if (spectrum.isDetermined(k))
      addSquare(motion, sigma * sigma / between[k][k], covariance);
    if (spectrum.isFree(k)) {
      ++result.free_motions;
      // So far that its turn or its shift is of the order of one, with turns in units of what they move the lever by.
      double reach = 0;
      for (int i = 0; i < 6; ++i)
        reach = std::max(reach, std::abs(motion[i]) * (i < 3 ? system.length : 1));
      for (int i = 0; i < 6; ++i)
        motion[i] *= (i < 3 ? system.length : 1) / reach;
      addSquare(motion, 1, free);
    }
  }
  result.centre = system.centre;
  result.sigma = sigma;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      result.information[6 * i + j] = matrix[i][j];
      result.covariance[6 * i + j] = covariance[i][j];
      for (int k = 0; k < 6; ++k)
        if (spectrum.isDetermined(k))
          result.determined[6 * i + j] += motions[i][k] * spectrum.shares[k][j];
    }
  result.turns = axesOf(covariance, free, spectrum.allowed, 0);
  result.shifts = axesOf(covariance, free, spectrum.allowed, 3);
  return result;
}

RigidTransform determinedPart(const RigidTransform& guess, const RigidTransform& pose, const Uncertainty& uncertainty)
{
  const auto& centre = uncertainty.centre;
  const auto source = inverse(pose)(centre[0], centre[1], centre[2]);
  const auto from = guess(source[0], source[1], source[2]);
  const auto turn = rotationVector(compose(pose, inverse(guess)).rotation);
  std::array<double, 6> way{}, part{};
  for (int axis = 0; axis < 3; ++axis) {
    way[axis] = turn[axis];
    way[3 + axis] = centre[axis] - from[axis];
  }
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      part[i] += uncertainty.determined[6 * i + j] * way[j];
  RigidTransform result = compose({rotationBy({part[0], part[1], part[2]}), {}}, guess);
  const auto turned = result(source[0], source[1], source[2]);
  for (int axis = 0; axis < 3; ++axis)
    result.translation[axis] += from[axis] + part[3 + axis] - turned[axis];
  return result;
}

Spectrum spectrumAgainst(const SquareMatrix<6>& points, const System& system, double noise)
{
  System of_points = system;
  setMatrix(of_points, points);
  const Spectrum reference = spectrumOf(of_points);
  for (int k = 0; k < 6; ++k)
    if (reference.isFree(k))
      return spectrumOf(system);
  // In units in which the points' own matrix is the identity.
  SquareMatrix<6> unit = reference.motions;
  for (int k = 0; k < 6; ++k)
    for (int i = 0; i < 6; ++i)
      unit[i][k] *= reference.allowed[k] ? 1 / std::sqrt(reference.values[k]) : 0;
  SquareMatrix<6> seen = betweenMotions(matrixOf(system), unit);
  const SquareMatrix<6> vectors = diagonalise(seen);
  Spectrum spectrum;
  spectrum.allowed = reference.allowed;
  spectrum.noise = noise;
  for (int k = 0; k < 6; ++k) {
    spectrum.values[k] = seen[k][k];
    for (int i = 0; i < 6; ++i)
      for (int l = 0; l < 6; ++l)
        spectrum.motions[i][k] += unit[i][l] * vectors[l][k];
  }
  // Motions are of length 1 by the points' own matrix.
  for (int k = 0; k < 6; ++k)
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        spectrum.shares[k][i] += spectrum.allowed[k] && spectrum.allowed[i] ? spectrum.motions[j][k] * points[j][i] : 0;
  return spectrum;
}

} // namespace pcl_gpu_icp
