#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace pcl_gpu_icp {

template <std::size_t n>
using SquareMatrix = std::array<std::array<double, n>, n>;

/// Eigenvalues to the diagonal of the symmetric matrix, eigenvectors to the columns of the result: Jacobi's method
/// (Golub and Van Loan, Matrix Computations, 8.5). Where a row is zero but for its diagonal its unit vector is one.
template <std::size_t n>
SquareMatrix<n> diagonalise(SquareMatrix<n>& a)
{
  const auto rotate = [](double& first, double& second, double cosine, double sine) {
    const double held = first;
    first = cosine * held - sine * second;
    second = sine * held + cosine * second;
  };
  constexpr int sweeps_at_most = 32; // five or six are usual
  SquareMatrix<n> vectors{};
  for (std::size_t i = 0; i < n; ++i)
    vectors[i][i] = 1;
  for (int sweep = 0; sweep < sweeps_at_most; ++sweep) {
    int rotations = 0;
    for (std::size_t i = 0; i + 1 < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) {
        // What double cannot add to the diagonal does not count.
        if (std::abs(a[i][i]) + std::abs(a[i][j]) == std::abs(a[i][i]) &&
            std::abs(a[j][j]) + std::abs(a[i][j]) == std::abs(a[j][j]))
          continue;
        ++rotations;
        const double zeta = (a[j][j] - a[i][i]) / (2 * a[i][j]);
        const double tangent = std::copysign(1.0, zeta) / (std::abs(zeta) + std::sqrt(1 + zeta * zeta));
        const double cosine = 1 / std::sqrt(1 + tangent * tangent), sine = cosine * tangent;
        for (std::size_t k = 0; k < n; ++k)
          rotate(a[k][i], a[k][j], cosine, sine);
        for (std::size_t k = 0; k < n; ++k)
          rotate(a[i][k], a[j][k], cosine, sine);
        for (std::size_t k = 0; k < n; ++k)
          rotate(vectors[k][i], vectors[k][j], cosine, sine);
      }
    if (rotations == 0)
      break;
  }
  return vectors;
}

} // namespace pcl_gpu_icp
