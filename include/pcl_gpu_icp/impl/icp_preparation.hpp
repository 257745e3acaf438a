#pragma once

// What IterativeClosestPoint does once, before its first iteration.
#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/stopwatch.h>

#include <pcl/common/point_tests.h>
#include <pcl/conversions.h>

#include <cmath>
#include <limits>

namespace pcl_gpu_icp {

namespace detail {

/// The largest float that is no larger than `distance` squared: what a squared float distance is compared with.
inline float squaredLimit(double distance)
{
  const double squared = distance * distance;
  if (squared >= std::numeric_limits<float>::max())
    return std::numeric_limits<float>::infinity();
  const float limit = static_cast<float>(squared);
  return limit > squared ? std::nextafter(limit, 0.0F) : limit;
}

} // namespace detail

template <typename PointSource, typename PointTarget, typename Scalar>
void IterativeClosestPoint<PointSource, PointTarget, Scalar>::prepare(const Matrix4& guess)
{
  this->nr_iterations_ = 0;
  this->converged_ = false;
  this->final_transformation_ = guess;
  this->transformation_ = Matrix4::Identity();
  result_.pipeline = pipeline_;
  result_.search = search_;
  result_.threads = getNumberOfThreads();

  finite_indices_.reset(new pcl::Indices);
  finite_indices_->reserve(this->indices_->size());
  for (const auto index : *this->indices_)
    if (pcl::isXYZFinite((*this->input_)[index]))
      finite_indices_->push_back(index);
  result_.source_points = finite_indices_->size();
  result_.source_dropped = this->indices_->size() - finite_indices_->size();

  prepareSearch();
  prepareEstimator();
  prepareCriteria();
  prepareRejectors();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void IterativeClosestPoint<PointSource, PointTarget, Scalar>::prepareSearch()
{
  const bool own_estimation = this->correspondence_estimation_ == default_correspondence_estimation_;
  const bool own_tree = this->tree_ == nearest_tree_;
  if (own_tree) {
    nearest_tree_->refresh();
    // pcl::Registration had it built before the total was taken.
    const double built = nearest_tree_->takeBuildMilliseconds();
    result_.host_times["tree"] = {built, 1};
    result_.host_times["total"].milliseconds += built;
  }
  else if (!tree_just_built_ && !this->force_no_recompute_)
    this->tree_->setInputCloud(this->target_);
  tree_just_built_ = false;
  const bool own_reciprocal =
      !this->use_reciprocal_correspondence_ || this->tree_reciprocal_ == default_reciprocal_tree_;

  matcher_.reset();
  if (own_estimation && own_tree && nearest_tree_->index() && own_reciprocal) {
    matcher_ = std::make_unique<search::Matcher>(search::pointsOf(*this->input_, finite_indices_.get()),
                                                 search::pointsOf(*this->target_),
                                                 *nearest_tree_->index(),
                                                 detail::squaredLimit(this->corr_dist_threshold_),
                                                 result_.threads);
    if (this->use_reciprocal_correspondence_)
      matcher_->requireReciprocal();
    result_.target_points = nearest_tree_->index()->size();
  }
  else {
    for (const auto& point : *this->target_)
      result_.target_points += pcl::isXYZFinite(point) ? 1 : 0;
    this->correspondence_estimation_->setInputTarget(this->target_);
  }
  result_.target_dropped = this->target_->size() - result_.target_points;
}

template <typename PointSource, typename PointTarget, typename Scalar>
void IterativeClosestPoint<PointSource, PointTarget, Scalar>::prepareEstimator()
{
  if (!estimatesOnDevice())
    return;
  const Stopwatch watch(result_.host_times, "start");
  if (!device_)
    device_ = Device::select();
  if (!estimator_) {
    estimator_ = std::make_unique<RigidEstimator>(*device_, pipeline_, detail::precisionFor<Scalar>(*device_));
    target_on_device_ = nullptr;
  }
  result_.device = estimator_->device();
  result_.precision = estimator_->precision();
  estimator_->setSource(search::pointsOf(*this->input_));
  const bool unchanged = this->tree_ == nearest_tree_ && target_on_device_ == this->target_.get() &&
                         target_revision_ == nearest_tree_->revision();
  if (!unchanged) {
    estimator_->setTarget(search::pointsOf(*this->target_));
    target_on_device_ = this->target_.get();
    target_revision_ = nearest_tree_->revision();
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void IterativeClosestPoint<PointSource, PointTarget, Scalar>::ConvergenceCriteria::startAfresh()
{
  this->correspondences_prev_mse_ = this->correspondences_cur_mse_ = std::numeric_limits<double>::max();
  this->iterations_similar_transforms_ = 0;
  this->setConvergenceState(ConvergenceCriteria::CONVERGENCE_CRITERIA_NOT_CONVERGED);
}

template <typename PointSource, typename PointTarget, typename Scalar>
void IterativeClosestPoint<PointSource, PointTarget, Scalar>::prepareCriteria()
{
  auto& criteria = *this->convergence_criteria_;
  if (auto* own = dynamic_cast<ConvergenceCriteria*>(&criteria))
    own->startAfresh();
  criteria.setMaximumIterations(this->max_iterations_);
  criteria.setRelativeMSE(this->euclidean_fitness_epsilon_);
  criteria.setTranslationThreshold(this->transformation_epsilon_);
  criteria.setRotationThreshold(this->transformation_rotation_epsilon_ > 0 ? this->transformation_rotation_epsilon_
                                                                           : 1.0 - this->transformation_epsilon_);
}

template <typename PointSource, typename PointTarget, typename Scalar>
void IterativeClosestPoint<PointSource, PointTarget, Scalar>::prepareRejectors()
{
  this->determineRequiredBlobData();
  const bool somebody_looks = !matcher_ || !estimatesOnDevice() || this->need_source_blob_ || this->update_visualizer_;
  moved_source_.reset(somebody_looks ? new PointCloudSource(*this->input_) : nullptr);

  pcl::PCLPointCloud2::Ptr target_blob(new pcl::PCLPointCloud2);
  if (this->need_target_blob_)
    pcl::toPCLPointCloud2(*this->target_, *target_blob);
  if (this->correspondence_estimation_->requiresTargetNormals())
    this->correspondence_estimation_->setTargetNormals(target_blob);
  for (const auto& rejector : this->correspondence_rejectors_) {
    if (rejector->requiresTargetPoints())
      rejector->setTargetPoints(target_blob);
    if (rejector->requiresTargetNormals() && this->target_has_normals_)
      rejector->setTargetNormals(target_blob);
  }
}

} // namespace pcl_gpu_icp
