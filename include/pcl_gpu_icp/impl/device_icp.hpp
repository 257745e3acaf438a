#pragma once

#include <pcl_gpu_icp/device_icp.h>
#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/impl/device_icp_correspondences.hpp>
#include <pcl_gpu_icp/impl/device_icp_lane.hpp>
#include <pcl_gpu_icp/impl/device_icp_preparation.hpp>
#include <pcl_gpu_icp/impl/matrix.hpp>
#include <pcl_gpu_icp/parallel_for.h>
#include <pcl_gpu_icp/stopwatch.h>

#include <pcl/common/point_tests.h>
#include <pcl/conversions.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace pcl_gpu_icp {

namespace detail {

template <typename State>
Reason reasonOf(State state)
{
  using Criteria = pcl::registration::DefaultConvergenceCriteria<float>;
  switch (static_cast<int>(state)) {
  case Criteria::CONVERGENCE_CRITERIA_ITERATIONS:
    return Reason::Iterations;
  case Criteria::CONVERGENCE_CRITERIA_TRANSFORM:
    return Reason::Transform;
  case Criteria::CONVERGENCE_CRITERIA_ABS_MSE:
    return Reason::AbsoluteMse;
  case Criteria::CONVERGENCE_CRITERIA_REL_MSE:
    return Reason::RelativeMse;
  case Criteria::CONVERGENCE_CRITERIA_NO_CORRESPONDENCES:
    return Reason::NoCorrespondences;
  case Criteria::CONVERGENCE_CRITERIA_FAILURE_AFTER_MAX_ITERATIONS:
    return Reason::FailureAfterIterations;
  default:
    return Reason::NotRun;
  }
}

template <typename PointT>
bool hasField(const char* name)
{
  for (const auto& field : pcl::getFields<PointT>())
    if (field.name == name)
      return true;
  return false;
}

} // namespace detail

template <typename PclIcp>
DeviceIcp<PclIcp>::DeviceIcp()
: nearest_tree_(new NearestTargetTree)
, default_reciprocal_tree_(this->tree_reciprocal_)
{
  this->tree_ = nearest_tree_;
  this->convergence_criteria_.reset(new Criteria(this->nr_iterations_, this->transformation_, *this->correspondences_));
  default_transformation_estimation_ = this->Registration::transformation_estimation_;
  default_correspondence_estimation_ = this->correspondence_estimation_;
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::setDevice(const Device& device)
{
  device_ = device;
  if (plane_estimation_)
    plane_estimation_->setDevice(device);
  kept_source_normals_ = kept_target_normals_ = {};
  matcher_.reset();
  estimator_.reset();
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::setPipeline(Pipeline pipeline)
{
  pipeline_ = pipeline;
  estimator_.reset();
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::setMetric(Metric metric)
{
  of_both_ = knowsBothSurfaces(metric) ? std::optional(metric) : std::nullopt;
  if (metric == Metric::Plane && !plane_estimation_) {
    plane_estimation_ = pcl::make_shared<PlaneEstimation>();
    if (device_)
      plane_estimation_->setDevice(*device_);
  }
  if (metric == Metric::Plane)
    this->Registration::transformation_estimation_ = plane_estimation_;
  else
    this->Registration::transformation_estimation_ = default_transformation_estimation_;
}

template <typename PclIcp>
Metric DeviceIcp<PclIcp>::getMetric() const
{
  if (of_both_)
    return *of_both_;
  return dynamic_cast<const PlaneEstimation*>(this->Registration::transformation_estimation_.get()) ? Metric::Plane
                                                                                                    : Metric::Point;
}

template <typename PclIcp>
unsigned int DeviceIcp<PclIcp>::getNumberOfThreads() const
{
  return effectiveThreads(threads_);
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::setInputSource(const PointCloudSourceConstPtr& cloud)
{
  if (!cloud || cloud->empty()) {
    PCL_ERROR("[pcl_gpu_icp::%s::setInputSource] Invalid or empty point cloud dataset given!\n",
              this->getClassName().c_str());
    this->input_.reset();
    return;
  }
  Base::setInputSource(cloud);
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::setInputTarget(const PointCloudTargetConstPtr& cloud)
{
  if (!cloud || cloud->empty()) {
    PCL_ERROR("[pcl_gpu_icp::%s::setInputTarget] Invalid or empty point cloud dataset given!\n",
              this->getClassName().c_str());
    this->target_.reset();
    return;
  }
  Base::setInputTarget(cloud);
  // PCL asks the source's fields here.
  this->target_has_normals_ = detail::hasField<PointTarget>("normal_x");
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::align(PointCloudSource& output)
{
  align(output, Matrix4::Identity());
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::align(PointCloudSource& output, const Matrix4& guess)
{
  this->converged_ = false;
  this->nr_iterations_ = 0;
  this->final_transformation_ = this->transformation_ = this->previous_transformation_ = Matrix4::Identity();
  result_ = {};
  if (!canStart())
    return;
  tree_just_built_ = this->target_cloud_updated_ && !this->force_no_recompute_;
  nearest_tree_->setDeferred(search_ == CorrespondenceSearch::DeviceKdTree);
  Base::align(output, guess);
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::endBeforeTheStart(const std::string& why)
{
  result_.reason = Reason::Error;
  result_.message = why;
  PCL_ERROR("[pcl_gpu_icp::%s::align] %s\n", this->getClassName().c_str(), why.c_str());
}

template <typename PclIcp>
bool DeviceIcp<PclIcp>::canStart()
{
  if (!this->input_)
    endBeforeTheStart("there is no source: setInputSource() was given no cloud, or an empty one");
  else if (!this->target_)
    endBeforeTheStart("there is no target: setInputTarget() was given no cloud, or an empty one");
  else
    return indicesAreValid();
  return false;
}

template <typename PclIcp>
std::optional<pcl::index_t> DeviceIcp<PclIcp>::strayIndex() const
{
  if (!this->indices_ || this->fake_indices_)
    return std::nullopt;
  const auto count = static_cast<std::ptrdiff_t>(this->input_->size());
  const auto stray = std::find_if(
      this->indices_->begin(), this->indices_->end(), [&](auto index) { return index < 0 || index >= count; });
  return stray == this->indices_->end() ? std::nullopt : std::optional(*stray);
}

template <typename PclIcp>
bool DeviceIcp<PclIcp>::indicesAreValid()
{
  const auto stray = strayIndex();
  if (stray)
    endBeforeTheStart("index " + std::to_string(*stray) + " of setIndices() is outside of the source's " +
                      std::to_string(this->input_->size()) + " points");
  return !stray;
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::computeTransformation(PointCloudSource& output, const Matrix4& guess)
{
  result_ = {};
  try {
    const Stopwatch total(result_.host_times, "total");
    prepare(guess);
    const auto acceleration = accelerated_ ? std::optional(leverOf(takingPart())) : std::nullopt;
    const RigidTransform start = startOf(guess);
    report(start, judged(iterate(*this, start, acceleration), start));
  } catch (const Cancelled& cancelled) {
    this->converged_ = false;
    this->final_transformation_ = guess;
    result_.reason = Reason::Cancelled;
    result_.message = cancelled.what();
  } catch (const std::exception& error) {
    PCL_ERROR("[pcl_gpu_icp::%s::computeTransformation] %s\n", this->getClassName().c_str(), error.what());
    this->converged_ = false;
    this->final_transformation_ = guess;
    result_.reason = Reason::Error;
    result_.message = error.what();
    result_.error = std::current_exception();
  }
  result_.converged = this->converged_;
  result_.iterations = this->nr_iterations_;
  moved_source_.reset();
  moves_as_pcl_ = false;

  if (!with_output_)
    return;
  if (usesAllPoints())
    output = *this->input_;
  else
    pcl::copyPointCloud(*this->input_, *this->indices_, output);
  const PointCloudSource untransformed = output;
  this->transformCloud(untransformed, output, this->final_transformation_);
}

template <typename PclIcp>
RigidTransform DeviceIcp<PclIcp>::estimateIncrement(const RigidTransform& pose)
{
  if (!estimatesOnDevice() && !matcherEstimates()) {
    this->Registration::transformation_estimation_->estimateRigidTransformation(
        *moved_source_, *this->target_, *this->correspondences_, this->transformation_);
    if (planes_) {
      increment_ = planes_->getEstimate();
      result_.degeneracy = increment_.degeneracy;
      result_.free_motions = increment_.free_motions;
      return increment_.transform;
    }
    return detail::toRigidTransform<Scalar>(this->transformation_);
  }
  if (usesEstimator()) {
    const Stopwatch watch(result_.host_times, "estimate");
    increment_ = estimator_->estimate(matches_.data(), matches_.size(), pose);
  }
  result_.degeneracy = increment_.degeneracy;
  result_.free_motions = increment_.free_motions;
  // The criteria look at how far the increment moves the origin: R and t are rounded each for itself here.
  this->transformation_ = detail::toMatrix<Scalar>(increment_.transform);
  return increment_.transform;
}

template <typename PclIcp>
bool DeviceIcp<PclIcp>::finished(const RigidTransform& /*increment*/, const RigidTransform& pose)
{
  this->final_transformation_ = matrixOf(pose);
  ++this->nr_iterations_;
  result_.searched.push_back(std::exchange(searched_, 0));

  if (iteration_callback_)
    iteration_callback_(this->nr_iterations_, std::sqrt(mean_squared_distance_), result_.searched.back());
  if (moves_as_pcl_)
    this->transformCloud(*moved_source_, *moved_source_, this->transformation_);
  if (this->update_visualizer_) {
    if (!moves_as_pcl_)
      this->transformCloud(*this->input_, *moved_source_, this->final_transformation_);
    pcl::Indices source_indices, target_indices;
    for (const pcl::Correspondence& c : *this->correspondences_) {
      source_indices.push_back(c.index_query);
      target_indices.push_back(c.index_match);
    }
    this->update_visualizer_(*moved_source_, source_indices, *this->target_, target_indices);
  }

  this->converged_ = static_cast<bool>(*this->convergence_criteria_);
  return this->convergence_criteria_->getConvergenceState() != Criteria::CONVERGENCE_CRITERIA_NOT_CONVERGED;
}

template <typename PclIcp>
std::array<double, 3> DeviceIcp<PclIcp>::anchor() const
{
  return usesEstimator()      ? estimator_->sourcePivot()
         : matcherEstimates() ? matcher_->sourcePivot()
                              : std::array<double, 3>{};
}

template <typename PclIcp>
typename DeviceIcp<PclIcp>::Matrix4 DeviceIcp<PclIcp>::matrixOf(const RigidTransform& pose) const
{
  return detail::toMatrix<Scalar>(rounded<Scalar>(estimatesRigidly() ? nearestRigid(pose, anchor()) : pose, anchor()));
}

template <typename PclIcp>
std::string DeviceIcp<PclIcp>::whyTooFewMatched() const
{
  if (result_.source_points == 0)
    return "No point of the source is finite.";
  if (result_.target_points == 0)
    return "No point of the target is finite.";
  return "Not enough correspondences found: " + std::to_string(matched_) + ", where " +
         std::to_string(this->Registration::min_number_correspondences_) +
         " are needed. Relax your threshold parameters.";
}

/// Tells how sure the pose is, and gives it without what is not determined where that is asked for.
template <typename PclIcp>
RigidTransform DeviceIcp<PclIcp>::judged(const RigidTransform& pose, const RigidTransform& start)
{
  if (matched_ < static_cast<std::size_t>(this->Registration::min_number_correspondences_))
    return pose;
  if (matcherEstimates())
    result_.uncertainty = matcher_->uncertainty(pose);
  else if (usesEstimator())
    result_.uncertainty =
        pointUncertainty(matches_, search::pointsOf(*this->input_), search::pointsOf(*this->target_), pose);
  if (!result_.uncertainty || result_.uncertainty->free_motions == 0)
    return pose;
  if (result_.metric != Metric::Point && result_.uncertainty->free_motions > result_.free_motions) {
    result_.degeneracy = Degeneracy::Sliding;
    result_.free_motions = result_.uncertainty->free_motions;
  }
  if (!keeps_undetermined_)
    return pose;
  const RigidTransform kept = determinedPart(start, pose, *result_.uncertainty);
  this->final_transformation_ = matrixOf(kept);
  match(kept); // what is reported is of the pairs there
  return kept;
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::report(const RigidTransform& start, const RigidTransform& pose)
{
  if (matched_ < static_cast<std::size_t>(this->Registration::min_number_correspondences_)) {
    result_.message = whyTooFewMatched();
    PCL_ERROR("[pcl_gpu_icp::%s::computeTransformation] %s\n", this->getClassName().c_str(), result_.message.c_str());
    this->convergence_criteria_->setConvergenceState(Criteria::CONVERGENCE_CRITERIA_NO_CORRESPONDENCES);
    this->converged_ = false;
  }
  else if (measures_quality_) {
    const Stopwatch watch(result_.host_times, "quality");
    result_.quality = qualityOf(takingPart(), search::pointsOf(*this->target_), start, pose, result_.threads);
  }
  result_.reason = detail::reasonOf(this->convergence_criteria_->getConvergenceState());
  result_.inliers = matched_;
  result_.requests = stageRequests(matched_);
  const auto mean_square_of = [&](const std::vector<Correspondence>& pairs) {
    return meanSquaredDistance(pairs, search::pointsOf(*this->input_), search::pointsOf(*this->target_), pose);
  };
  const bool rejected = !this->correspondence_rejectors_.empty();
  mean_squared_found_ =
      matches_on_device_ ? matcher_->meanSquaredDistance(pose) : mean_square_of(rejected ? unrejected_ : matches_);
  result_.truncated_rmse = std::sqrt(truncatedMean(found_, mean_squared_found_));
  result_.rmse = std::sqrt(increment_from_matching_ ? mean_squared_found_ : mean_square_of(matches_));
  if (increment_from_matching_ && with_output_)
    listCorrespondences(matcher_->correspondences(matched_pose_));
  if (matches_on_device_) {
    result_.device_times = matcher_->takeTimes();
    result_.device_bytes = matcher_->deviceBytes();
    if (this->use_reciprocal_correspondence_)
      result_.device_bytes += backward_matcher_->deviceBytes();
  }
  if (usesEstimator()) {
    result_.device_bytes += estimator_->deviceBytes();
    for (const auto& [what, time] : estimator_->takeTimes()) {
      StageTime& entry = result_.device_times[what];
      entry.milliseconds += time.milliseconds;
      entry.count += time.count;
    }
  }
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::transformCloud(const PointCloudSource& input,
                                       PointCloudSource& output,
                                       const Matrix4& transform)
{
  if (moves_as_pcl_) {
    Base::transformCloud(input, output, transform);
    return;
  }
  const RigidTransform pose = detail::toRigidTransform<Scalar>(transform);
  RigidTransform rotation = pose;
  rotation.translation = {0, 0, 0};
  const std::size_t point_fields[] = {this->x_idx_offset_, this->y_idx_offset_, this->z_idx_offset_};
  const std::size_t normal_fields[] = {this->nx_idx_offset_, this->ny_idx_offset_, this->nz_idx_offset_};
  // False where a coordinate is not finite: such values stay as they are.
  const auto apply =
      [](const RigidTransform& map, const std::size_t* offsets, const PointSource& from, PointSource& to) {
        float in[3];
        for (int i = 0; i < 3; ++i)
          std::memcpy(&in[i], reinterpret_cast<const char*>(&from) + offsets[i], sizeof(float));
        if (!std::isfinite(in[0]) || !std::isfinite(in[1]) || !std::isfinite(in[2]))
          return false;
        const auto out = map(in[0], in[1], in[2]);
        for (int i = 0; i < 3; ++i) {
          const float value = static_cast<float>(out[i]);
          std::memcpy(reinterpret_cast<char*>(&to) + offsets[i], &value, sizeof(float));
        }
        return true;
      };
  for (std::size_t i = 0; i < input.size(); ++i)
    if (apply(pose, point_fields, input[i], output[i]) && this->source_has_normals_)
      apply(rotation, normal_fields, input[i], output[i]);
}

template <typename PclIcp>
bool DeviceIcp<PclIcp>::matcherHoldsTheClouds() const
{
  if (!matcher_ || matched_source_ == 0 || !usesDefaultSearch())
    return false;
  const pcl::Indices indices = finiteIndices();
  return search::fingerprintOf(search::pointsOf(*this->input_, &indices)) == matched_source_ &&
         search::fingerprintOf(search::pointsOf(*this->target_)) == matcher_target_;
}

template <typename PclIcp>
double DeviceIcp<PclIcp>::getFitnessScore(double max_range)
{
  if (!this->input_ || !this->target_ || !(max_range >= 0) || strayIndex())
    return std::numeric_limits<double>::max();
  if (matcherHoldsTheClouds()) {
    const RigidTransform pose = detail::toRigidTransform<Scalar>(this->final_transformation_);
    const Matches found = matcher_->match(pose, detail::floatAtMost(max_range), false);
    return found.increment.pairs > 0 ? found.mean_squared_distance : std::numeric_limits<double>::max();
  }
  const bool every_point = !this->indices_ || this->fake_indices_;
  const std::size_t count = every_point ? this->input_->size() : this->indices_->size();
  const RigidTransform pose = detail::toRigidTransform<Scalar>(this->final_transformation_);
  std::vector<float> squared_distances(count, std::numeric_limits<float>::quiet_NaN());
  parallelFor(count, search::queries_at_a_time, getNumberOfThreads(), [&](std::size_t begin, std::size_t end) {
    pcl::Indices index(1);
    std::vector<float> distance(1);
    PointTarget query;
    for (std::size_t i = begin; i < end; ++i) {
      const PointSource& point = (*this->input_)[every_point ? i : (*this->indices_)[i]];
      if (!takesPart(&point.x))
        continue;
      const auto x = pose(point.x, point.y, point.z);
      pcl::copyPoint(point, query);
      query.x = static_cast<float>(x[0]);
      query.y = static_cast<float>(x[1]);
      query.z = static_cast<float>(x[2]);
      if (this->tree_->nearestKSearch(query, 1, index, distance) > 0)
        squared_distances[i] = distance[0];
    }
  });
  double sum = 0;
  std::size_t within_range = 0;
  for (const float squared_distance : squared_distances)
    if (squared_distance <= max_range) {
      sum += squared_distance;
      ++within_range;
    }
  return within_range > 0 ? sum / static_cast<double>(within_range) : std::numeric_limits<double>::max();
}

} // namespace pcl_gpu_icp
