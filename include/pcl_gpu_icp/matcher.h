#pragma once

#include <pcl_gpu_icp/loss.h>
#include <pcl_gpu_icp/motions.h>
#include <pcl_gpu_icp/rigid_estimator.h>
#include <pcl_gpu_icp/search/nearest_index.h>

#include <memory>
#include <optional>
#include <vector>

namespace pcl_gpu_icp {

/// What one pass over the source found.
struct Matches {
  std::size_t searched = 0;         ///< source points whose match had to be searched for
  double mean_squared_distance = 0; ///< over the matched points, before the increment
  /// Of what the increment makes small: the same, to planes, or by information; with a loss of what it makes of them.
  double mean_squared_residual = 0;
  double loss_scale = 0; ///< 0: no loss
  Estimate increment;    ///< takes the matched source points at the pose on to their target points
};

/// The target of matchers: its points on a device, in the tree that is searched there or on the host. Never changes,
/// and serves any number of matchers on its device.
struct MatchTarget;

/// Finds for every source point the nearest target point within a limit, on each iteration at another pose, and
/// estimates the increment from the pairs. Exact: a point is not searched for again only while a certificate shows that
/// its match cannot have changed. Everything stays on the device, except the search itself where the target is given
/// with an index on the host. One thread at a time.
class PCL_GPU_ICP_API Matcher {
public:
  /// \param search whose kernels are built here, so that one that does not compile shows and no match waits for it
  /// \param precision Double is used where the device has it; precision() tells what runs
  /// \param metric of the increments, with the loss and the motions: what these need is built in addition
  Matcher(const Device& device,
          CorrespondenceSearch search,
          Precision precision,
          Metric metric = Metric::Point,
          const Loss& loss = {},
          Motions motions = Motions::Rigid);
  ~Matcher();
  Matcher(Matcher&&) noexcept;
  Matcher& operator=(Matcher&&) noexcept;

  const DeviceInfo& device() const;
  Precision precision() const;

  /// Where the device is shared: whom to ask before each operation. null, the default: nobody.
  void setShare(std::shared_ptr<DeviceShare> share);

  /// Host threads that build and search; 0, the default, means all cores.
  void setNumberOfThreads(unsigned threads);

  /// Builds a tree over the target that the device searches.
  /// \throws DeviceError when it does not fit
  std::shared_ptr<const MatchTarget> makeTarget(const Points& target) const;

  /// The points to search for are handed to `index` in one batch on each iteration.
  std::shared_ptr<const MatchTarget> makeTarget(std::shared_ptr<const search::NearestIndex> index) const;

  void setTarget(std::shared_ptr<const MatchTarget> target);

  /// Increments are point-to-plane (Low 2004) until the target is set anew. The normals are those of the target's
  /// points, one each in their order, or in the order of what the index was built of; their sign does not matter, and
  /// points whose normal is not finite take no part in the increment.
  /// \throws InvalidArgument when there are fewer than points
  void setTargetNormals(const Points& normals);

  /// After setTargetNormals(): increments are those of the symmetric objective (Rusinkiewicz 2019), linearised, until
  /// the target or its normals are set anew. As the target's normals, in the order of the source's points; they come
  /// after setSource(), and again whenever that is called.
  /// \throws InvalidArgument when there are fewer than points, or none of the target yet
  void setSourceNormals(const Points& normals);

  /// Increments are those of Generalized ICP (Segal, Haehnel and Thrun 2009) until the target is set anew. Each point's
  /// covariance is given as six floats, xx xy xz yy yz zz, one each in the order that normals are given in. The
  /// source's come after setSource(), and again whenever that is called.
  /// \throws InvalidArgument when there are fewer than points, or none of the target yet
  void setTargetCovariances(const Points& covariances);
  void setSourceCovariances(const Points& covariances);

  /// What increments weigh pairs by and what motions they are, from now on; at first no loss and all six.
  /// \throws InvalidArgument for a scale that is none
  void setLoss(const Loss& loss);
  void setMotions(Motions motions);

  /// How many steps an increment takes towards its minimum at most, where that has no closed solution: 20 at first. One
  /// is enough where pairs change more than the increment does.
  void setSteps(int most);

  /// Distinct finite target points.
  std::size_t targetSize() const;

  /// Forgets what is known of the source before.
  void setSource(const Points& source);

  /// Matches each source point that takes part, at `pose`, with the nearest target point that is at most so far.
  /// \param with_increment false: the increment may be any, and what normals or covariances are set does not matter
  /// \throws InvalidArgument when the limit is negative or not a number
  Matches match(const RigidTransform& pose, float max_squared_distance, bool with_increment = true);

  /// Mean squared distance of the last matches with the source at another pose; 0 when there are none.
  double meanSquaredDistance(const RigidTransform& pose);

  /// The last matches, in the order of the source, with positions as Points::position() gives them. Distances are with
  /// the source at `pose`.
  std::vector<Correspondence> correspondences(const RigidTransform& pose) const;

  /// The increment from some of the last matches, where normals, covariances, a loss or motions are set, and what it
  /// makes small; the rest of the result is empty.
  /// \param kept one entry of correspondences() for each source point that is meant
  /// \param pose that they were matched at
  /// \throws InvalidArgument when nothing of these is set, or for a source point that there is not
  Matches estimate(const std::vector<Correspondence>& kept, const RigidTransform& pose);

  /// Of the pairs that the last increment was of, with the source at `pose`; none where they are too few, or the last
  /// match() was without one.
  std::optional<Uncertainty> uncertainty(const RigidTransform& pose);

  /// The pivot that the source's coordinates are kept about on the device: where a rounded transform must be exact.
  const std::array<double, 3>& sourcePivot() const;

  /// Memory that it holds on the device, its target's included.
  std::size_t deviceBytes() const;

  /// Time per stage and transfer since the last call.
  StageTimes takeTimes();

private:
  friend Matcher makeMatcher(const Device&, const opencl::Traits&, Precision);
  struct Implementation;
  explicit Matcher(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

/// Mean squared distance between pose(source) and target points of the correspondences; 0 when there are none.
PCL_GPU_ICP_API double meanSquaredDistance(const std::vector<Correspondence>& correspondences,
                                           const Points& source,
                                           const Points& target,
                                           const RigidTransform& pose);

/// Of point-to-point pairs, with the source at `pose`; none where they are too few.
PCL_GPU_ICP_API std::optional<Uncertainty> pointUncertainty(const std::vector<Correspondence>& correspondences,
                                                            const Points& source,
                                                            const Points& target,
                                                            const RigidTransform& pose);

} // namespace pcl_gpu_icp
