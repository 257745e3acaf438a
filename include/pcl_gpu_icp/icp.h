#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/icp_loop.h>
#include <pcl_gpu_icp/result.h>
#include <pcl_gpu_icp/rigid_estimator.h>
#include <pcl_gpu_icp/search/matcher.h>
#include <pcl_gpu_icp/search/nearest_kdtree.h>
#include <pcl_gpu_icp/transformation_estimation_svd.h>

#include <pcl/registration/icp.h>

#include <functional>
#include <memory>
#include <optional>

namespace pcl_gpu_icp {

/// pcl::IterativeClosestPoint whose rigid estimation runs on an OpenCL device and whose KD-tree is built once per
/// target and queried from several host threads. Change the namespace and nothing else: guess, indices, rejectors,
/// reciprocal correspondences, custom estimators, search methods and point representations, convergence criteria, the
/// visualiser callback and getFitnessScore() keep PCL's meaning.
///
/// Where it differs from pcl::IterativeClosestPoint 1.12-1.15, it is to keep PCL's documented behaviour:
/// - non-finite points never take part, whatever is_dense says;
/// - setIndices() is honoured: only those source points are matched, and the output holds just them;
/// - the source is transformed from the original by the accumulated transform, so rounding does not drift;
/// - the convergence criteria start afresh in every align();
/// - an align() that cannot start leaves hasConverged() false and the final transformation at the identity.
///
/// Errors: what ends an alignment is reported through PCL_ERROR; hasConverged() is false, the final transformation is
/// the guess, and getResult() has the cause. align() does not throw.
template <typename PointSource, typename PointTarget, typename Scalar = float>
class IterativeClosestPoint : public pcl::IterativeClosestPoint<PointSource, PointTarget, Scalar>, private IcpSteps {
  using Base = pcl::IterativeClosestPoint<PointSource, PointTarget, Scalar>;

public:
  using Ptr = pcl::shared_ptr<IterativeClosestPoint>;
  using ConstPtr = pcl::shared_ptr<const IterativeClosestPoint>;
  using typename Base::Matrix4;
  using typename Base::PointCloudSource;
  using typename Base::PointCloudTarget;
  using typename Base::PointCloudTargetConstPtr;

  IterativeClosestPoint();
  ~IterativeClosestPoint() override = default;

  /// The device that the stages run on; by default Device::select(), when align() first needs it.
  void setDevice(const Device& device);

  /// Pipeline::Fused by default.
  void setPipeline(Pipeline pipeline);
  Pipeline getPipeline() const { return pipeline_; }

  /// What finds the correspondences: CorrespondenceSearch::PclKdTree, also the default.
  void setCorrespondenceSearch(CorrespondenceSearch search) { search_ = search; }
  CorrespondenceSearch getCorrespondenceSearch() const { return search_; }

  /// Host threads that query the search method; 0, the default, means all cores. A search method set by the caller
  /// must then allow concurrent const queries, as those of PCL do.
  void setNumberOfThreads(unsigned int threads) { threads_ = threads; }
  unsigned int getNumberOfThreads() const;

  /// Called after each iteration with its number (from 1) and the root mean square distance of its correspondences
  /// before its increment. For progress displays; the visualiser callback of PCL is served as well.
  void setIterationCallback(std::function<void(int iteration, double rmse)> callback)
  {
    iteration_callback_ = std::move(callback);
  }

  /// As in pcl::Registration; also clears what an earlier align() left when this one cannot start.
  void align(PointCloudSource& output);
  void align(PointCloudSource& output, const Matrix4& guess);

  /// Mean squared distance from the transformed source points (those of setIndices()) to their nearest target points,
  /// over the points whose squared distance is at most `max_range`; the largest double when there is none. As
  /// pcl::Registration::getFitnessScore, from several threads.
  double getFitnessScore(double max_range = std::numeric_limits<double>::max());
  using Base::getFitnessScore;

  /// What the last align() did.
  const AlignmentResult& getResult() const { return result_; }

  void setInputTarget(const PointCloudTargetConstPtr& cloud) override;

protected:
  void computeTransformation(PointCloudSource& output, const Matrix4& guess) override;

  /// As pcl::IterativeClosestPoint::transformCloud, computed in double.
  void transformCloud(const PointCloudSource& input, PointCloudSource& output, const Matrix4& transform) override;

private:
  using NearestTargetTree = search::NearestKdTree<PointTarget>;

  /// PCL's criteria, which keep the last alignment's mean squared distance.
  class ConvergenceCriteria : public pcl::registration::DefaultConvergenceCriteria<Scalar> {
  public:
    using pcl::registration::DefaultConvergenceCriteria<Scalar>::DefaultConvergenceCriteria;
    void startAfresh();
  };

  // The steps of the loop.
  bool match(const RigidTransform& pose) override;
  RigidTransform estimateIncrement(const RigidTransform& pose) override;
  bool finished(const RigidTransform& increment, const RigidTransform& pose) override;

  bool indicesAreValid();
  void prepare(const Matrix4& guess);
  void prepareSearch();
  void prepareEstimator();
  void prepareCriteria();
  void prepareRejectors();
  void findCorrespondences(const RigidTransform& pose);
  void queryCallersSearch();
  void queryCallersCorrespondenceEstimation();
  void rejectCorrespondences();
  void report(const RigidTransform& pose);
  bool estimatesOnDevice() const { return this->transformation_estimation_ == default_transformation_estimation_; }
  bool usesAllPoints() const { return this->indices_->size() == this->input_->size(); }

  std::optional<Device> device_;
  Pipeline pipeline_ = Pipeline::Fused;
  CorrespondenceSearch search_ = CorrespondenceSearch::PclKdTree;
  unsigned int threads_ = 0;
  std::function<void(int, double)> iteration_callback_;

  // What the constructor installed; anything else in its place is the caller's.
  typename NearestTargetTree::Ptr nearest_tree_;
  typename Base::KdTreeReciprocalPtr default_reciprocal_tree_;
  typename Base::TransformationEstimationPtr default_transformation_estimation_;
  typename Base::CorrespondenceEstimationPtr default_correspondence_estimation_;

  std::unique_ptr<RigidEstimator> estimator_;
  const void* target_on_device_ = nullptr; ///< the cloud whose points the estimator holds,
  unsigned long target_revision_ = 0;      ///< and the revision of nearest_tree_ it was taken at

  // Of the alignment that runs.
  bool tree_just_built_ = false;                ///< pcl::Registration built the tree for this alignment
  std::unique_ptr<search::Matcher> matcher_;    ///< null when the caller's own search answers
  std::vector<Correspondence> matches_;         ///< the correspondences_ in the engine's form
  pcl::IndicesPtr finite_indices_;              ///< source points that take part
  typename PointCloudSource::Ptr moved_source_; ///< the source at the current pose; null when nobody looks at it
  AlignmentResult result_;
};

} // namespace pcl_gpu_icp

#include <pcl_gpu_icp/impl/icp.hpp>
