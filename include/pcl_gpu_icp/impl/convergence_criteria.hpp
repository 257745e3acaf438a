#pragma once

#include <pcl_gpu_icp/convergence_criteria.h>

#include <cmath>
#include <limits>

namespace pcl_gpu_icp {

namespace detail {

/// PCL's default but for its last bit, so that a caller's own 1e-12 is told from it.
constexpr double default_absolute_mse = 1e-12 - 2e-28;
static_assert(default_absolute_mse < 1e-12);

} // namespace detail

template <typename Scalar>
ConvergenceCriteria<Scalar>::ConvergenceCriteria(const int& iterations,
                                                 const Matrix4& increment,
                                                 const pcl::Correspondences& correspondences)
: pcl::registration::DefaultConvergenceCriteria<Scalar>(iterations, increment, correspondences)
{
  this->mse_threshold_absolute_ = detail::default_absolute_mse;
}

template <typename Scalar>
void ConvergenceCriteria<Scalar>::startAfresh(double spacing)
{
  threshold_ = this->mse_threshold_absolute_;
  if (threshold_ == detail::default_absolute_mse)
    threshold_ = 1e-10 * spacing * spacing;
  this->correspondences_prev_mse_ = this->correspondences_cur_mse_ = std::numeric_limits<double>::max();
  this->iterations_similar_transforms_ = 0;
  earlier_.clear();
  this->setConvergenceState(ConvergenceCriteria::CONVERGENCE_CRITERIA_NOT_CONVERGED);
}

template <typename Scalar>
bool ConvergenceCriteria<Scalar>::hasConverged()
{
  // The order of the tests is that of pcl::registration::DefaultConvergenceCriteria.
  this->convergence_state_ = ConvergenceCriteria::CONVERGENCE_CRITERIA_NOT_CONVERGED;
  if (this->iterations_ >= this->max_iterations_) {
    this->convergence_state_ = this->failure_after_max_iter_
                                   ? ConvergenceCriteria::CONVERGENCE_CRITERIA_FAILURE_AFTER_MAX_ITERATIONS
                                   : ConvergenceCriteria::CONVERGENCE_CRITERIA_ITERATIONS;
    if (!this->failure_after_max_iter_)
      return true;
  }
  const auto& increment = this->transformation_;
  const double rotation_cosine = 0.5 * (increment(0, 0) + increment(1, 1) + increment(2, 2) - 1);
  const double translation_sq =
      increment(0, 3) * increment(0, 3) + increment(1, 3) * increment(1, 3) + increment(2, 3) * increment(2, 3);
  const double previous = this->correspondences_prev_mse_;
  const double step = std::abs(mean_squared_distance_ - previous);
  constexpr double last_digits = 1e-5; // far above float's own
  const bool recurs = !earlier_.insert(mean_squared_distance_).second && step <= last_digits * previous;
  const double change = recurs ? 0 : step;
  this->correspondences_cur_mse_ = mean_squared_distance_;

  auto reached = ConvergenceCriteria::CONVERGENCE_CRITERIA_NOT_CONVERGED;
  if (rotation_cosine >= this->rotation_threshold_ && translation_sq <= this->translation_threshold_)
    reached = ConvergenceCriteria::CONVERGENCE_CRITERIA_TRANSFORM;
  else if (change < threshold_)
    reached = ConvergenceCriteria::CONVERGENCE_CRITERIA_ABS_MSE;
  else if (change / previous < this->mse_threshold_relative_)
    reached = ConvergenceCriteria::CONVERGENCE_CRITERIA_REL_MSE;
  if (reached == ConvergenceCriteria::CONVERGENCE_CRITERIA_NOT_CONVERGED)
    this->iterations_similar_transforms_ = 0;
  else if (this->iterations_similar_transforms_ >= this->max_iterations_similar_transforms_) {
    this->convergence_state_ = reached;
    return true;
  }
  else
    ++this->iterations_similar_transforms_;
  this->correspondences_prev_mse_ = mean_squared_distance_;
  return false;
}

} // namespace pcl_gpu_icp
