#pragma once

// What an ICP class does once, before its first iteration.
#include <pcl_gpu_icp/device_icp.h>
#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/impl/matrix.hpp>
#include <pcl_gpu_icp/stopwatch.h>

#include <pcl/common/point_tests.h>
#include <pcl/conversions.h>
#include <pcl/pcl_config.h>

#include <cmath>
#include <limits>
#include <tuple>

namespace pcl_gpu_icp {

namespace detail {

/// The largest float that is no larger; infinite for what float cannot hold.
inline float floatAtMost(double value)
{
  if (value >= std::numeric_limits<float>::max())
    return std::numeric_limits<float>::infinity();
  const float rounded = static_cast<float>(value);
  return rounded > value ? std::nextafter(rounded, -std::numeric_limits<float>::infinity()) : rounded;
}

} // namespace detail

template <typename PclIcp>
float DeviceIcp<PclIcp>::squaredLimit() const
{
  const double distance = this->corr_dist_threshold_;
  return std::isnan(distance) ? std::numeric_limits<float>::infinity() : detail::floatAtMost(distance * distance);
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::prepare(const Matrix4& guess)
{
  this->nr_iterations_ = 0;
  searched_ = 0;
  this->converged_ = false;
  this->final_transformation_ = guess;
  this->transformation_ = Matrix4::Identity();
  result_.pipeline = pipeline_;
  result_.search = search_;
  result_.loss = loss_;
  result_.motions = motions_;
  result_.threads = getNumberOfThreads();

  planes_ = dynamic_cast<const PlaneEstimation*>(this->Registration::transformation_estimation_.get());
  if (estimatesRigidly() && !detail::isRigid<Scalar>(guess))
    throw InvalidArgument("the guess is not a rigid transform: three rows of a rotation (orthonormal to 0.001, "
                          "determinant +1) and a translation, then 0 0 0 1");

  finite_indices_.reset(new pcl::Indices(finiteIndices()));
  result_.source_points = finite_indices_->size();
  result_.source_dropped = this->indices_->size() - finite_indices_->size();

  prepareCriteria();
  prepareMatching();
  requireGivenNormals();
  prepareEstimator();
  prepareRejectors();
}

template <typename PclIcp>
pcl::Indices DeviceIcp<PclIcp>::finiteIndices() const
{
  pcl::Indices finite;
  const auto add = [&](pcl::index_t index) {
    if (takesPart(&(*this->input_)[index].x))
      finite.push_back(index);
  };
  if (!this->indices_ || this->fake_indices_)
    for (std::size_t i = 0; i < this->input_->size(); ++i)
      add(static_cast<pcl::index_t>(i));
  else
    for (const auto index : *this->indices_)
      add(index);
  return finite;
}

template <typename PclIcp>
const Device& DeviceIcp<PclIcp>::device()
{
  if (!device_)
    device_ = Device::select();
  return *device_;
}

template <typename PclIcp>
bool DeviceIcp<PclIcp>::usesDefaultSearch() const
{
  return this->correspondence_estimation_ == default_correspondence_estimation_ && this->tree_ == nearest_tree_ &&
         nearest_tree_->index() &&
         // GICP would take the source's covariances from it.
         (!(this->use_reciprocal_correspondence_ || of_both_ == Metric::Generalized) ||
          this->tree_reciprocal_ == default_reciprocal_tree_);
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::prepareMatching()
{
  result_.metric = getMetric();
  matches_on_device_ = usesDefaultSearch();
  if (solvesSystem() && !(matches_on_device_ && estimatesRigidly()))
    throw InvalidArgument(std::string(result_.metric == Metric::Generalized ? "generalized ICP"
                                      : result_.metric == Metric::Symmetric ? "the symmetric metric"
                                      : loss_.weighs()                      ? "a loss"
                                                                            : "fewer than six motions") +
                          " excludes a search method, a correspondence estimation, a transformation estimation or a "
                          "point representation of the caller's");
  if (search_ == CorrespondenceSearch::DeviceKdTree && !matches_on_device_)
    throw InvalidArgument("setCorrespondenceSearch(DeviceKdTree) excludes a search method, a correspondence estimation "
                          "or a point representation of the caller's");
  const bool plain = matches_on_device_ && !this->use_reciprocal_correspondence_ && estimatesRigidly() &&
                     this->correspondence_rejectors_.empty() && (pipeline_ == Pipeline::Fused || solvesSystem());
  increment_from_matching_ = plain;
  lists_correspondences_ =
      !plain || this->update_visualizer_ || !dynamic_cast<Criteria*>(this->convergence_criteria_.get());
  matched_source_ = 0;
  if (matches_on_device_)
    prepareMatchingOnDevice();
  else
    prepareMatchingByCaller();
  result_.target_dropped = this->target_->size() - result_.target_points;
  tree_just_built_ = false;
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::prepareMatchingOnDevice()
{
  const bool device_searches = search_ == CorrespondenceSearch::DeviceKdTree;
  const auto make = [this] {
    const Stopwatch watch(result_.host_times, "start");
    return std::make_unique<Matcher>(
        device(), search_, detail::precisionFor<Scalar>(device()), result_.metric, loss_, motions_);
  };
  if (!matcher_ || matcher_search_ != search_ || matcher_->precision() != detail::precisionFor<Scalar>(device())) {
    matcher_ = make();
    backward_matcher_.reset();
    matcher_search_ = search_;
    matcher_target_ = matcher_normals_ = 0;
  }
  matcher_->setShare(share_);
  matcher_->setNumberOfThreads(result_.threads);
  matcher_->setLoss(loss_);
  matcher_->setMotions(motions_);
  {
    // pcl::Registration may have had the tree built before the total was taken.
    const double built_before = nearest_tree_->takeBuildMilliseconds();
    result_.host_times["tree"].milliseconds += built_before;
    result_.host_times["total"].milliseconds += built_before;
    const Stopwatch watch(result_.host_times, "tree");
    if (!device_searches)
      nearest_tree_->refresh();
    const std::uint64_t target =
        device_searches ? search::fingerprintOf(search::pointsOf(*this->target_)) : nearest_tree_->fingerprint();
    if (matcher_target_ != target || (matcher_normals_ != 0 && result_.metric == Metric::Point)) {
      matcher_target_ = matcher_normals_ = 0;
      target_normals_.reset();
      const auto make_target = [&] {
        return device_searches ? matcher_->makeTarget(search::pointsOf(*this->target_))
                               : matcher_->makeTarget(nearest_tree_->index());
      };
      if (cache_)
        matcher_->setTarget((device_searches ? cache_->trees : cache_->leaves).get(target, make_target));
      else
        matcher_->setTarget(make_target());
      matcher_target_ = target;
    }
  }
  nearest_tree_->takeBuildMilliseconds();
  if (matcherEstimates() && planes_)
    prepareMetric();
  {
    const Stopwatch watch(result_.host_times, "pack");
    matcher_->setSource(takingPart());
  }
  if (result_.metric == Metric::Symmetric)
    prepareNormalsOfBoth();
  if (result_.metric == Metric::Generalized)
    prepareCovariances();
  {
    const Stopwatch watch(result_.host_times, "pack");
    matched_source_ = search::fingerprintOf(takingPart());
  }
  if (this->use_reciprocal_correspondence_) {
    if (!backward_matcher_)
      backward_matcher_ = make();
    const Stopwatch watch(result_.host_times, "tree");
    backward_matcher_->setShare(share_);
    backward_matcher_->setNumberOfThreads(result_.threads);
    if (device_searches)
      backward_matcher_->setTarget(backward_matcher_->makeTarget(takingPart()));
    else {
      const auto source_index = std::make_shared<search::NearestIndex>();
      source_index->build(takingPart());
      backward_matcher_->setTarget(backward_matcher_->makeTarget(source_index));
    }
    backward_matcher_->setSource(search::pointsOf(*this->target_));
  }
  result_.device = matcher_->device();
  result_.precision = matcher_->precision();
  result_.target_points = matcher_->targetSize();
}

template <typename PclIcp>
std::shared_ptr<const NormalEstimator::Normals>
DeviceIcp<PclIcp>::normalsOf(const Points& points, std::uint64_t fingerprint, unsigned neighbours)
{
  const Precision precision = detail::precisionFor<Scalar>(device());
  const auto make = [&] {
    NormalEstimator estimator(device(), precision);
    estimator.setShare(share_);
    return std::make_shared<const NormalEstimator::Normals>(estimator.estimate(points, neighbours));
  };
  return cache_ ? cache_->normals.get({fingerprint, neighbours, precision}, make) : make();
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::prepareMetric()
{
  const Stopwatch watch(result_.host_times, "normals");
  const auto estimate = [this](const Points& points, std::uint64_t fingerprint, unsigned neighbours) {
    return normalsOf(points, fingerprint, neighbours);
  };
  const Points normals = planes_->normalsOf(*this->target_, estimate, target_normals_);
  const std::uint64_t fingerprint = search::fingerprintOf(normals);
  if (matcher_normals_ == fingerprint)
    return;
  matcher_normals_ = 0;
  matcher_->setTargetNormals(normals);
  matcher_normals_ = fingerprint;
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::requireGivenNormals() const
{
  const bool symmetric = result_.metric == Metric::Symmetric;
  if constexpr (pcl::traits::has_normal<PointTarget>::value)
    if ((planes_ || symmetric) && result_.target_points > 0)
      requireNormals(search::normalsOf(*this->target_), "target");
  if constexpr (pcl::traits::has_normal<PointSource>::value)
    if (symmetric && result_.source_points > 0)
      requireNormals(search::normalsOf(*this->input_), "source");
}

template <typename PclIcp>
template <typename PointT>
const NormalEstimator::Normals&
DeviceIcp<PclIcp>::estimatedNormals(const pcl::PointCloud<PointT>& cloud, unsigned neighbours, KeptNormals& kept)
{
  const Points points = search::pointsOf(cloud);
  const TargetCache::NormalsOf of{search::fingerprintOf(points), neighbours, detail::precisionFor<Scalar>(device())};
  if (!kept.normals || kept.of != of)
    kept = {of, normalsOf(points, std::get<0>(of), neighbours)};
  return *kept.normals;
}

template <typename PclIcp>
template <typename PointT>
Points DeviceIcp<PclIcp>::normalsOf(const pcl::PointCloud<PointT>& cloud, [[maybe_unused]] KeptNormals& kept)
{
  if constexpr (pcl::traits::has_normal<PointT>::value)
    return search::normalsOf(cloud);
  else {
    const NormalEstimator::Normals& normals = estimatedNormals(cloud, NormalEstimator::default_neighbours, kept);
    return {normals.data()->data(), normals.size(), sizeof(NormalEstimator::Normals::value_type)};
  }
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::prepareNormalsOfBoth()
{
  const Stopwatch watch(result_.host_times, "normals");
  const Points of_target = normalsOf(*this->target_, kept_target_normals_);
  const std::uint64_t fingerprint = 1 + search::fingerprintOf(of_target); // another than point-to-plane's
  if (matcher_normals_ != fingerprint) {
    matcher_normals_ = 0;
    matcher_->setTargetNormals(of_target);
    matcher_normals_ = fingerprint;
  }
  matcher_->setSourceNormals(normalsOf(*this->input_, kept_source_normals_));
}

template <typename PclIcp>
template <typename PointT>
PointCovariances DeviceIcp<PclIcp>::covariancesOf(const pcl::PointCloud<PointT>& cloud,
                                                  const CovarianceSettings& settings,
                                                  const PointCovariances& given,
                                                  KeptNormals& kept,
                                                  const char* whose)
{
  if (given.empty())
    return surfaceCovariances(estimatedNormals(cloud, settings.neighbours, kept), settings.epsilon);
  requireCovariances(given, cloud.size(), whose);
  return given;
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::prepareCovariances()
{
  const Stopwatch watch(result_.host_times, "normals");
  const CovarianceSettings settings = covarianceSettings();
  const auto view = [](const PointCovariances& covariances, int first) {
    return Points{covariances.data()->data() + first, covariances.size(), sizeof(PointCovariances::value_type)};
  };
  const PointCovariances of_target =
      covariancesOf(*this->target_, settings, settings.of_target, kept_target_normals_, "target");
  const std::uint64_t fingerprint =
      1 + search::fingerprintOf(view(of_target, 0)) + 3 * search::fingerprintOf(view(of_target, 3));
  if (matcher_normals_ != fingerprint) {
    matcher_normals_ = 0;
    matcher_->setTargetCovariances(view(of_target, 0));
    matcher_normals_ = fingerprint;
  }
  const PointCovariances of_source =
      covariancesOf(*this->input_, settings, settings.of_source, kept_source_normals_, "source");
  matcher_->setSourceCovariances(view(of_source, 0));
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::prepareMatchingByCaller()
{
  if (this->tree_ == nearest_tree_)
    nearest_tree_->refresh();
  else if (!tree_just_built_ && !this->force_no_recompute_)
    this->tree_->setInputCloud(this->target_);
  for (const auto& point : *this->target_)
    result_.target_points += pcl::isXYZFinite(point) ? 1 : 0;
  this->correspondence_estimation_->setInputTarget(this->target_);
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::prepareEstimator()
{
  if (planes_ && !matches_on_device_) {
    result_.device = planes_->getDevice().info();
    result_.precision = detail::precisionFor<Scalar>(planes_->getDevice());
  }
  if (!usesEstimator())
    return;
  const Stopwatch watch(result_.host_times, "start");
  const Precision precision = detail::precisionFor<Scalar>(device());
  if (!estimator_ || estimator_->pipeline() != pipeline_ || estimator_->precision() != precision) {
    estimator_ = std::make_unique<RigidEstimator>(device(), pipeline_, precision);
    estimator_target_ = 0;
  }
  estimator_->setShare(share_);
  result_.device = estimator_->device();
  result_.precision = estimator_->precision();
  estimator_->setSource(search::pointsOf(*this->input_));
  const std::uint64_t target = search::fingerprintOf(search::pointsOf(*this->target_));
  if (estimator_target_ != target) {
    estimator_->setTarget(search::pointsOf(*this->target_));
    estimator_target_ = target;
  }
}

template <typename PclIcp>
RigidTransform DeviceIcp<PclIcp>::startOf(const Matrix4& guess) const
{
  const RigidTransform start = detail::toRigidTransform<Scalar>(guess);
  return estimatesRigidly() ? nearestRigid(start, anchor()) : start;
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::prepareCriteria()
{
  auto& criteria = *this->convergence_criteria_;
  if (auto* own = dynamic_cast<Criteria*>(&criteria))
    own->startAfresh(surfaceSpacing(search::pointsOf(*this->target_)));
  criteria.setMaximumIterations(this->max_iterations_);
  criteria.setRelativeMSE(this->euclidean_fitness_epsilon_);
  criteria.setTranslationThreshold(this->transformation_epsilon_);
  if (this->transformation_rotation_epsilon_ > 0)
    criteria.setRotationThreshold(this->transformation_rotation_epsilon_);
#if PCL_VERSION_COMPARE(<, 1, 14, 0) // From then on PCL leaves the criteria the threshold they have.
  else
    criteria.setRotationThreshold(1.0 - this->transformation_epsilon_);
#endif
}

template <typename PclIcp>
void DeviceIcp<PclIcp>::prepareRejectors()
{
  this->determineRequiredBlobData();
  const bool somebody_looks = !matches_on_device_ || !(estimatesOnDevice() || matcherEstimates()) ||
                              this->need_source_blob_ || this->update_visualizer_;
  moved_source_.reset(somebody_looks ? new PointCloudSource(*this->input_) : nullptr);
  // Extrapolated poses are no chain of increments.
  moves_as_pcl_ = !estimatesOnDevice() && !planes_ && !accelerated_;

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
