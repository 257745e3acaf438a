#pragma once

// An ICP class on a lane of a batch.
#include <pcl_gpu_icp/device_icp.h>
#include <pcl_gpu_icp/device_lane.h>

#include <utility>

namespace pcl_gpu_icp {

template <typename PclIcp>
void DeviceIcp<PclIcp>::enter(DeviceLane& lane)
{
  device_outside_ = device_;
  threads_outside_ = threads_;
  setDevice(lane.device);
  share_ = lane.share;
  cache_ = lane.targets;
  nearest_tree_->setCache(cache_ ? std::shared_ptr<search::SharedCache<search::NearestIndex>>(cache_, &cache_->indices)
                                 : nullptr);
  if (threads_ == 0)
    threads_ = lane.threads;
  matcher_ = std::move(lane.matcher);
  matcher_target_ = std::exchange(lane.matcher_target, 0);
  matcher_normals_ = std::exchange(lane.matcher_normals, 0);
  target_normals_ = std::move(lane.target_normals);
  matcher_search_ = lane.matcher_search;
  estimator_ = std::move(lane.estimator);
  estimator_target_ = 0;
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::leave(DeviceLane& lane)
{
  share_.reset();
  cache_.reset();
  nearest_tree_->setCache(nullptr);
  matched_source_ = 0;
  backward_matcher_.reset();
  // An operation that failed may have left anything behind.
  const bool usable = result_.reason != Reason::Error && result_.reason != Reason::Cancelled;
  lane.matcher = usable ? std::move(matcher_) : nullptr;
  lane.matcher_search = matcher_search_;
  lane.matcher_target = usable ? matcher_target_ : 0;
  lane.matcher_normals = usable ? matcher_normals_ : 0;
  lane.target_normals = target_normals_ ? std::move(target_normals_) : std::move(kept_target_normals_.normals);
  lane.source_normals = std::move(kept_source_normals_.normals);
  target_normals_.reset();
  kept_source_normals_ = kept_target_normals_ = {};
  lane.estimator = usable ? std::move(estimator_) : nullptr;
  matcher_.reset();
  estimator_.reset();
  device_ = std::exchange(device_outside_, std::nullopt);
  // Its device was the lane's.
  const bool measures_planes = plane_estimation_ && this->Registration::transformation_estimation_ == plane_estimation_;
  plane_estimation_.reset();
  if (measures_planes)
    setMetric(Metric::Plane);
  threads_ = threads_outside_;
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::alignWithoutOutput(const Matrix4& guess)
{
  const struct WithoutOutput {
    explicit WithoutOutput(bool& wanted)
    : with_output(wanted)
    {
      with_output = false;
    }
    ~WithoutOutput() { with_output = true; }
    bool& with_output;
  } until_the_end(with_output_);
  PointCloudSource unmoved;
  align(unmoved, guess);
}

} // namespace pcl_gpu_icp
