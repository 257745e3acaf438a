#pragma once

// How an ICP class comes by the correspondences of an iteration: on the device, or by the caller's own search
// or estimation, and through the rejectors.
#include <pcl_gpu_icp/device_icp.h>
#include <pcl_gpu_icp/impl/device_icp_preparation.hpp>
#include <pcl_gpu_icp/parallel_for.h>
#include <pcl_gpu_icp/stopwatch.h>

#include <pcl/conversions.h>

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp {

namespace detail {

/// PCL's Correspondence::distance is the squared distance.
inline double meanSquare(const pcl::Correspondences& correspondences)
{
  double sum = 0;
  for (const pcl::Correspondence& c : correspondences)
    sum += c.distance;
  return correspondences.empty() ? 0 : sum / static_cast<double>(correspondences.size());
}

} // namespace detail

template <typename PclIcp>
bool DeviceIcp<PclIcp>::match(const RigidTransform& pose)
{
  this->previous_transformation_ = this->transformation_;
  matched_pose_ = pose;
  {
    const Stopwatch watch(result_.host_times, "search");
    // As PCL moves it, the guess comes first and each increment when it is known.
    if (moved_source_ && !(moves_as_pcl_ && this->nr_iterations_ > 0))
      this->transformCloud(*this->input_, *moved_source_, matrixOf(pose));
    if (matches_on_device_)
      matchOnDevice(pose);
    else if (this->correspondence_estimation_ == default_correspondence_estimation_ &&
             !this->use_reciprocal_correspondence_)
      queryCallersSearch();
    else
      queryCallersCorrespondenceEstimation();
  }
  if (!matches_on_device_) {
    searched_ += finite_indices_->size();
    found_ = this->correspondences_->size();
    mean_squared_found_ = detail::meanSquare(*this->correspondences_);
  }
  if (lists_correspondences_) {
    rejectCorrespondences();
    matched_ = matches_.size();
    mean_squared_distance_ = detail::meanSquare(*this->correspondences_);
    if (!increment_from_matching_)
      mean_squared_residual_ = mean_squared_distance_;
    if (solvesSystem() && !increment_from_matching_) {
      const Matches kept = matcher_->estimate(matches_, pose);
      increment_ = kept.increment;
      mean_squared_residual_ = kept.mean_squared_residual;
      result_.loss_scale = kept.loss_scale;
    }
  }
  if (auto* own = dynamic_cast<Criteria*>(this->convergence_criteria_.get()))
    own->setMeanSquaredDistance(mean_squared_distance_);
  if (this->nr_iterations_ == 0) {
    result_.rmse_before = std::sqrt(mean_squared_distance_);
    result_.truncated_rmse_before = std::sqrt(truncatedMean(found_, mean_squared_found_));
  }

  return matched_ >= static_cast<std::size_t>(this->Registration::min_number_correspondences_);
}

template <typename PclIcp>
double DeviceIcp<PclIcp>::error() const
{
  if (this->use_reciprocal_correspondence_ || !this->correspondence_rejectors_.empty())
    return mean_squared_residual_;
  return truncatedMean(matched_, mean_squared_residual_);
}

template <typename PclIcp>
double DeviceIcp<PclIcp>::truncatedMean(std::size_t matched, double mean_square) const
{
  // A point without a match counts as one at the limit, so that losing matches does not look like progress.
  const std::size_t all = finite_indices_->size();
  const double limit_sq = squaredLimit();
  if (matched >= all || std::isinf(limit_sq))
    return mean_square;
  const double share = static_cast<double>(matched) / static_cast<double>(all);
  return share * mean_square + (1 - share) * limit_sq;
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::matchOnDevice(const RigidTransform& pose)
{
  const Matches found = matcher_->match(pose, squaredLimit(), increment_from_matching_);
  searched_ += found.searched;
  increment_ = found.increment;
  matched_ = increment_.pairs;
  mean_squared_distance_ = found.mean_squared_distance;
  found_ = matched_;
  mean_squared_found_ = mean_squared_distance_;
  mean_squared_residual_ = found.mean_squared_residual;
  result_.loss_scale = found.loss_scale;
  if (!lists_correspondences_)
    return;
  matches_ = matcher_->correspondences(pose);
  if (this->use_reciprocal_correspondence_)
    keepMutual(pose);
  listCorrespondences(matches_);
  if (moves_as_pcl_)
    measureAsPclDoes();
}

/// A caller's estimator may weigh pairs by their distance, and rejectors sort by it.
template <typename PclIcp>
void DeviceIcp<PclIcp>::measureAsPclDoes()
{
  for (pcl::Correspondence& c : *this->correspondences_) {
    const PointSource& from = (*moved_source_)[c.index_query];
    const PointTarget& to = (*this->target_)[c.index_match];
    const float x = from.x - to.x, y = from.y - to.y, z = from.z - to.z;
    c.distance = x * x + y * y + z * z;
  }
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::keepMutual(const RigidTransform& pose)
{
  const RigidTransform back = inverse(pose);
  backward_matcher_->match(back, squaredLimit(), false);
  std::vector<std::int32_t> nearest_source(this->target_->size(), pcl::UNAVAILABLE);
  for (const Correspondence& c : backward_matcher_->correspondences(back))
    nearest_source[c.source] = c.target;
  const auto is_one_sided = [&](const Correspondence& c) { return nearest_source[c.target] != c.source; };
  matches_.erase(std::remove_if(matches_.begin(), matches_.end(), is_one_sided), matches_.end());
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::listCorrespondences(const std::vector<Correspondence>& correspondences)
{
  this->correspondences_->resize(correspondences.size());
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    const Correspondence& c = correspondences[i];
    (*this->correspondences_)[i] = {c.source, c.target, c.squared_distance};
  }
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::queryCallersSearch()
{
  const float limit = squaredLimit();
  pcl::Correspondences nearest(finite_indices_->size());
  parallelFor(nearest.size(), search::queries_at_a_time, result_.threads, [&](std::size_t begin, std::size_t end) {
    pcl::Indices index(1);
    std::vector<float> distance(1);
    PointTarget query;
    for (std::size_t i = begin; i < end; ++i) {
      const auto source = (*finite_indices_)[i];
      pcl::copyPoint((*moved_source_)[source], query);
      const bool found = this->tree_->nearestKSearch(query, 1, index, distance) > 0 && distance[0] <= limit;
      nearest[i] = {source, found ? index[0] : pcl::UNAVAILABLE, distance[0]};
    }
  });
  this->correspondences_->clear();
  for (const pcl::Correspondence& c : nearest)
    if (c.index_match != pcl::UNAVAILABLE)
      this->correspondences_->push_back(c);
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::queryCallersCorrespondenceEstimation()
{
  auto& estimation = *this->correspondence_estimation_;
  estimation.setInputSource(moved_source_);
  if (finite_indices_->size() < this->input_->size())
    estimation.setIndicesSource(finite_indices_);
  if (estimation.requiresSourceNormals()) {
    pcl::PCLPointCloud2::Ptr blob(new pcl::PCLPointCloud2);
    pcl::toPCLPointCloud2(*moved_source_, *blob);
    estimation.setSourceNormals(blob);
  }
  if (this->use_reciprocal_correspondence_)
    estimation.determineReciprocalCorrespondences(*this->correspondences_, this->corr_dist_threshold_);
  else
    estimation.determineCorrespondences(*this->correspondences_, this->corr_dist_threshold_);
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::rejectCorrespondences()
{
  pcl::PCLPointCloud2::Ptr source_blob;
  if (this->need_source_blob_) {
    source_blob.reset(new pcl::PCLPointCloud2);
    pcl::toPCLPointCloud2(*moved_source_, *source_blob);
  }
  const auto list = [this](std::vector<Correspondence>& into) {
    into.clear();
    for (const pcl::Correspondence& c : *this->correspondences_)
      into.push_back({c.index_query, c.index_match, c.distance});
  };
  if (!matches_on_device_ && !this->correspondence_rejectors_.empty())
    list(unrejected_);
  for (const auto& rejector : this->correspondence_rejectors_) {
    if (rejector->requiresSourcePoints())
      rejector->setSourcePoints(source_blob);
    if (rejector->requiresSourceNormals() && this->source_has_normals_)
      rejector->setSourceNormals(source_blob);
    rejector->setInputCorrespondences(pcl::make_shared<pcl::Correspondences>(*this->correspondences_));
    rejector->getCorrespondences(*this->correspondences_);
  }
  if (matches_on_device_ && this->correspondence_rejectors_.empty())
    return;
  list(matches_);
}

} // namespace pcl_gpu_icp
