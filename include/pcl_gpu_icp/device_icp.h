#pragma once

#include <pcl_gpu_icp/convergence_criteria.h>
#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/device_lane.h>
#include <pcl_gpu_icp/icp_loop.h>
#include <pcl_gpu_icp/matcher.h>
#include <pcl_gpu_icp/point_covariances.h>
#include <pcl_gpu_icp/result.h>
#include <pcl_gpu_icp/rigid_estimator.h>
#include <pcl_gpu_icp/search/nearest_kdtree.h>
#include <pcl_gpu_icp/transformation_estimation_point_to_plane_lls.h>
#include <pcl_gpu_icp/transformation_estimation_svd.h>

#include <pcl/registration/icp.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_gpu_icp {

/// What the ICP classes of this library have in common, over the PCL class that each of them is: IterativeClosestPoint
/// says how it differs from that.
template <typename PclIcp>
class DeviceIcp : public PclIcp, private IcpSteps {
  using Base = PclIcp;
  using PointSource = typename PclIcp::PointCloudSource::PointType;
  using PointTarget = typename PclIcp::PointCloudTarget::PointType;
  using Scalar = typename PclIcp::Matrix4::Scalar;
  // Three of its members are private in pcl::IterativeClosestPointNonLinear, but not by this name.
  using Registration = pcl::Registration<PointSource, PointTarget, Scalar>;

public:
  using typename Base::Matrix4;
  using typename Base::PointCloudSource;
  using typename Base::PointCloudSourceConstPtr;
  using typename Base::PointCloudTarget;
  using typename Base::PointCloudTargetConstPtr;

  DeviceIcp();
  ~DeviceIcp() override = default;

  /// The device that the stages run on; by default Device::select(), when align() first needs it.
  void setDevice(const Device& device);

  /// Pipeline::Fused by default.
  void setPipeline(Pipeline pipeline);
  Pipeline getPipeline() const { return pipeline_; }

  /// What is made small: Metric::Point by default, but for the classes that are named after another one. Plane is
  /// setTransformationEstimation() with a pcl_gpu_icp::TransformationEstimationPointToPlaneLLS of default settings, and
  /// such an estimator is Plane.
  /// Symmetric takes the normals of both clouds' points, or those that it estimates where a point type has none.
  /// Symmetric and Generalized exclude a search method, a correspondence or a transformation estimation and a point
  /// representation of the caller's: align() then ends with an error.
  void setMetric(Metric metric);
  Metric getMetric() const;

  /// A loss that weighs each iteration's pairs, after rejection; none by default. Excludes what Metric::Generalized
  /// excludes, but for an estimation that is Plane. A scale that is none ends align() with an error.
  void setLoss(const Loss& loss) { loss_ = loss; }
  const Loss& getLoss() const { return loss_; }

  /// How the source may move from the guess: Motions::Rigid by default. Anything else excludes what a loss does.
  void setMotions(Motions motions) { motions_ = motions; }
  Motions getMotions() const { return motions_; }

  /// Whether motions that the pairs do not determine (getResult().uncertainty) are left as the guess has them, such as
  /// along a corridor. Off by default: they are then wherever noise took them.
  void setKeepUndetermined(bool kept) { keeps_undetermined_ = kept; }
  bool getKeepUndetermined() const { return keeps_undetermined_; }

  /// Whether getResult().quality is measured, for judge(). On by default: some milliseconds at most, whatever the
  /// number of points.
  void setMeasureQuality(bool measured) { measures_quality_ = measured; }
  bool getMeasureQuality() const { return measures_quality_; }

  /// What finds the correspondences: CorrespondenceSearch::PclKdTree by default. DeviceKdTree excludes a search method,
  /// a correspondence estimation or a point representation of the caller's: align() then ends with an error.
  void setCorrespondenceSearch(CorrespondenceSearch search) { search_ = search; }
  CorrespondenceSearch getCorrespondenceSearch() const { return search_; }

  /// Anderson acceleration (Walker and Ni 2011; Zhang, Yao and Deng 2021): each iteration starts from an extrapolation
  /// of the last ones, which is taken back where the error rises. Off by default: the path is not PCL's, and fewer
  /// iterations lead to the same fixed point, where there is more than one perhaps to another of them.
  void setAndersonAcceleration(bool accelerated) { accelerated_ = accelerated; }
  bool getAndersonAcceleration() const { return accelerated_; }

  /// Host threads that query the search method; 0, the default, means all cores. A search method set by the caller
  /// must then allow concurrent const queries, as those of PCL do.
  void setNumberOfThreads(unsigned int threads) { threads_ = threads; }
  unsigned int getNumberOfThreads() const;

  /// Called after each iteration with its number (from 1), the root mean square distance of its correspondences
  /// before its increment, and the number of source points that had to be searched for. For progress displays; the
  /// visualiser callback of PCL is served as well.
  void setIterationCallback(std::function<void(int iteration, double rmse, std::size_t searched)> callback)
  {
    iteration_callback_ = std::move(callback);
  }

  /// As in pcl::Registration; also clears what an earlier align() left when this one cannot start.
  void align(PointCloudSource& output);
  void align(PointCloudSource& output, const Matrix4& guess);

  /// As align(), but without the aligned cloud and the list of correspondences: getFinalTransformation() and
  /// getResult() have the answer.
  void alignWithoutOutput(const Matrix4& guess = Matrix4::Identity());

  /// Mean squared distance from the transformed source points (those of setIndices()) to their nearest target points,
  /// over the points whose squared distance is at most `max_range`; the largest double when there is none. As
  /// pcl::Registration::getFitnessScore. After an align() on the same clouds only the points are searched for whose
  /// match may have changed with the last increment.
  double getFitnessScore(double max_range = std::numeric_limits<double>::max());
  using Base::getFitnessScore;

  /// What the last align() did.
  const AlignmentResult& getResult() const { return result_; }

  void setInputSource(const PointCloudSourceConstPtr& cloud) override;
  void setInputTarget(const PointCloudTargetConstPtr& cloud) override;

  /// Aligns on a lane from now on, with what others left there on its device.
  void enter(DeviceLane& lane);
  /// Leaves there what the next one can use, and has nothing on the device any more. Device and threads are then those
  /// from before enter().
  void leave(DeviceLane& lane);

protected:
  /// Of GICP's: how many points, itself among them, a point's covariance comes from and how thick the surface is; or
  /// the covariances themselves, one for each point of a cloud, where they are given.
  struct CovarianceSettings {
    unsigned neighbours = NormalEstimator::default_neighbours;
    double epsilon = surface_epsilon;
    PointCovariances of_source, of_target;
  };
  virtual CovarianceSettings covarianceSettings() const { return {}; }

  /// The largest squared distance, in float32, at which points are a pair. As pcl::IterativeClosestPoint compares with
  /// its limit: the sign does not matter, and NaN is no limit.
  virtual float squaredLimit() const;

  void computeTransformation(PointCloudSource& output, const Matrix4& guess) override;

  /// As pcl::IterativeClosestPoint::transformCloud, computed in double; in float where PCL's own bits are asked for.
  void transformCloud(const PointCloudSource& input, PointCloudSource& output, const Matrix4& transform) override;

  /// Nobody has put another estimator in the place of the constructor's.
  bool estimatesOnDevice() const
  {
    return this->Registration::transformation_estimation_ == default_transformation_estimation_;
  }

private:
  using NearestTargetTree = search::NearestKdTree<PointTarget>;
  using PlaneEstimation = TransformationEstimationPointToPlaneLLS<PointSource, PointTarget, Scalar>;

  using Criteria = ConvergenceCriteria<Scalar>;

  /// What was estimated last.
  struct KeptNormals {
    TargetCache::NormalsOf of;
    std::shared_ptr<const NormalEstimator::Normals> normals;
  };

  // The steps of the loop.
  bool match(const RigidTransform& pose) override;
  double error() const override;
  RigidTransform estimateIncrement(const RigidTransform& pose) override;
  bool finished(const RigidTransform& increment, const RigidTransform& pose) override;

  bool canStart();
  std::optional<pcl::index_t> strayIndex() const;
  bool indicesAreValid();
  void endBeforeTheStart(const std::string& why);
  std::string whyTooFewMatched() const;
  void prepare(const Matrix4& guess);
  void prepareMatching();
  void prepareMatchingOnDevice();
  void prepareMatchingByCaller();
  void prepareMetric();
  std::shared_ptr<const NormalEstimator::Normals>
  normalsOf(const Points& points, std::uint64_t fingerprint, unsigned neighbours);
  template <typename PointT>
  PointCovariances covariancesOf(const pcl::PointCloud<PointT>& cloud,
                                 const CovarianceSettings& settings,
                                 const PointCovariances& given,
                                 KeptNormals& kept,
                                 const char* whose);
  template <typename PointT>
  const NormalEstimator::Normals&
  estimatedNormals(const pcl::PointCloud<PointT>& cloud, unsigned neighbours, KeptNormals& kept);
  template <typename PointT>
  Points normalsOf(const pcl::PointCloud<PointT>& cloud, KeptNormals& kept);
  void prepareNormalsOfBoth();
  /// Without any the guess would be the answer.
  void requireGivenNormals() const;
  void prepareCovariances();
  void prepareEstimator();
  RigidTransform startOf(const Matrix4& guess) const;
  void prepareCriteria();
  void prepareRejectors();
  void matchOnDevice(const RigidTransform& pose);
  void keepMutual(const RigidTransform& pose);
  void measureAsPclDoes();
  void queryCallersSearch();
  void queryCallersCorrespondenceEstimation();
  void rejectCorrespondences();
  double truncatedMean(std::size_t matched, double mean_square) const;
  std::array<double, 3> anchor() const;
  Matrix4 matrixOf(const RigidTransform& pose) const;
  void report(const RigidTransform& start, const RigidTransform& pose);
  RigidTransform judged(const RigidTransform& pose, const RigidTransform& start);
  void listCorrespondences(const std::vector<Correspondence>& correspondences);
  bool matcherHoldsTheClouds() const;
  pcl::Indices finiteIndices() const;
  bool usesDefaultSearch() const;
  bool estimatesRigidly() const { return estimatesOnDevice() || planes_; }
  /// Whether increments are asked of the matcher for listed pairs as well.
  bool solvesSystem() const
  {
    return knowsBothSurfaces(result_.metric) || (planes_ && matches_on_device_) || loss_.weighs() ||
           motions_ != Motions::Rigid;
  }
  bool matcherEstimates() const { return increment_from_matching_ || solvesSystem(); }
  /// From listed pairs, where the metric is Point.
  bool usesEstimator() const { return estimatesOnDevice() && !matcherEstimates(); }
  const Device& device();
  Points takingPart() const { return search::pointsOf(*this->input_, finite_indices_.get()); }
  bool usesAllPoints() const { return this->indices_->size() == this->input_->size(); }

  std::optional<Device> device_;
  std::shared_ptr<DeviceShare> share_;   ///< of a lane's device,
  std::shared_ptr<TargetCache> cache_;   ///< and the targets that are there
  std::optional<Device> device_outside_; ///< of lanes,
  unsigned int threads_outside_ = 0;     ///< and as many threads
  Pipeline pipeline_ = Pipeline::Fused;
  std::optional<Metric> of_both_; ///< the metric asked for where it is of both surfaces; Plane is an estimator's,
  typename PlaneEstimation::Ptr plane_estimation_; ///< of which this is the own one
  Loss loss_;
  Motions motions_ = Motions::Rigid;
  bool keeps_undetermined_ = false;
  bool measures_quality_ = true;
  CorrespondenceSearch search_ = CorrespondenceSearch::PclKdTree;
  bool accelerated_ = false;
  unsigned int threads_ = 0;
  std::function<void(int, double, std::size_t)> iteration_callback_;

  // What the constructor installed; anything else in its place is the caller's.
  typename NearestTargetTree::Ptr nearest_tree_;
  typename Base::KdTreeReciprocalPtr default_reciprocal_tree_;
  typename Base::TransformationEstimationPtr default_transformation_estimation_;
  typename Base::CorrespondenceEstimationPtr default_correspondence_estimation_;

  // On the device, kept from one alignment to the next.
  std::unique_ptr<Matcher> matcher_;      ///< from the source to the target,
  std::uint64_t matcher_target_ = 0;      ///< the fingerprint of the points it holds,
  CorrespondenceSearch matcher_search_{}; ///< what searches them,
  std::uint64_t matcher_normals_ =
      0; ///< and the fingerprint of the normals or covariances that it measures by; 0: none
  std::shared_ptr<const NormalEstimator::Normals> target_normals_; ///< where they were estimated for point-to-plane
  KeptNormals kept_source_normals_, kept_target_normals_;          ///< and where for a metric of both surfaces
  std::unique_ptr<Matcher> backward_matcher_; ///< from the target to the source, for reciprocal correspondences
  std::unique_ptr<RigidEstimator> estimator_; ///< where the increment comes from listed correspondences,
  std::uint64_t estimator_target_ = 0;        ///< and the fingerprint of its target points

  // Of the alignment that runs.
  bool tree_just_built_ = false;                ///< pcl::Registration built the tree for this alignment
  bool matches_on_device_ = false;              ///< by matcher_; otherwise the caller's own search answers
  bool lists_correspondences_ = true;           ///< somebody looks at each iteration's
  bool with_output_ = true;                     ///< somebody looks at the last one's, and at the aligned cloud
  bool increment_from_matching_ = false;        ///< the matching pass estimates it
  const PlaneEstimation* planes_ = nullptr;     ///< the caller's estimator, where it is point-to-plane on the device
  pcl::IndicesPtr finite_indices_;              ///< source points that take part: finite and not too far,
  std::uint64_t matched_source_ = 0;            ///< and their fingerprint while matcher_ holds them
  typename PointCloudSource::Ptr moved_source_; ///< the source at the current pose; null when nobody looks at it
  bool moves_as_pcl_ = false;                   ///< it goes on by each increment, in float, as PCL's does
  RigidTransform matched_pose_;                 ///< where the source was matched last
  std::size_t searched_ = 0;                    ///< source points searched for in this iteration
  std::size_t matched_ = 0;                     ///< correspondences of this iteration,
  double mean_squared_distance_ = 0;            ///< of these,
  double mean_squared_residual_ = 0;            ///< of these, of what the increment makes small,
  Estimate increment_;                          ///< from these, where the caller's estimator does not make it,
  std::vector<Correspondence> matches_;         ///< and their list, when lists_correspondences_
  std::size_t found_ = 0;                       ///< correspondences of this iteration before rejection,
  double mean_squared_found_ = 0;               ///< the mean squared distance of these,
  std::vector<Correspondence> unrejected_;      ///< and their list, where the caller's search and rejectors made them
  AlignmentResult result_;
};

} // namespace pcl_gpu_icp

#include <pcl_gpu_icp/impl/device_icp.hpp>
