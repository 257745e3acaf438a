#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/loss.h>
#include <pcl_gpu_icp/motions.h>
#include <pcl_gpu_icp/quality.h>
#include <pcl_gpu_icp/uncertainty.h>

#include <array>
#include <cstddef>
#include <exception>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pcl_gpu_icp {

/// How the five stages run on the device.
enum class Pipeline {
  Staged, ///< five operations one after another, pairwise sums level by level; every stage can be read back
  Fused,  ///< one pass over the pairs and one small kernel: same answer, least traffic
};

/// What finds the correspondences.
enum class CorrespondenceSearch {
  PclKdTree,    ///< PCL's KD-tree on the host, or the search method that the caller set
  DeviceKdTree, ///< a tree on the device, which then does the whole iteration
};

/// What an increment makes small.
enum class Metric {
  Point, ///< the distances between matched points
  Plane, ///< the distances from source points to the planes through the target points they are matched with
  /// the distances along the mean of both points' normals (Rusinkiewicz 2019)
  Symmetric,
  /// the Mahalanobis distances of matched points by both clouds' local covariances: Generalized ICP, "gicp"
  Generalized,
};

/// What the device sums in and solves with. Coordinates are float32 about a pivot in both.
enum class Precision { Float, Double };

/// What the pairs leave undetermined.
enum class Degeneracy {
  None,
  /// Point-to-plane, GICP: motions along the surface, such as within a plane, which the pairs tell no more of than the
  /// noise of the points. What their rounding alone does not tell is left as it was.
  Sliding,
  Line,  ///< all pairs on one line: the rotation about it is left as it was
  Point, ///< all pairs at one point: only the translation is determined
  Empty, ///< no pairs: the identity
};

/// Why an alignment ended. The names follow pcl::registration::DefaultConvergenceCriteria.
enum class Reason {
  NotRun,
  Iterations,             ///< the iteration limit was reached (counts as converged, as in PCL)
  Transform,              ///< the last increment was below the transformation epsilons
  AbsoluteMse,            ///< the mean squared distance changed by less than the absolute threshold
  RelativeMse,            ///< the mean squared distance changed by less than the fitness epsilon
  NoCorrespondences,      ///< fewer correspondences than PCL's minimum
  FailureAfterIterations, ///< the iteration limit was reached and the caller's criteria count that as failure
  Cancelled,              ///< the caller of a batch cancelled it
  Error,                  ///< an exception ended it: see AlignmentResult::message
};

/// Whether it takes the surfaces about the points of both clouds: their normals or covariances.
constexpr bool knowsBothSurfaces(Metric metric) { return metric == Metric::Symmetric || metric == Metric::Generalized; }

PCL_GPU_ICP_API const char* toString(Pipeline pipeline);
PCL_GPU_ICP_API const char* toString(CorrespondenceSearch search);
PCL_GPU_ICP_API const char* toString(Metric metric);
PCL_GPU_ICP_API const char* toString(Precision precision);
PCL_GPU_ICP_API const char* toString(Degeneracy degeneracy);
PCL_GPU_ICP_API const char* toString(Reason reason);

/// The work-items a stage asks the device for: n at first, then what each level of its reduction still needs.
struct StageRequest {
  std::string stage;
  std::vector<std::size_t> work_items;
};

/// The requests of the five stages for n pairs: n, n, n, 27, 27 and their reductions.
PCL_GPU_ICP_API std::vector<StageRequest> stageRequests(std::size_t pairs);

/// What the stages computed, matrices row-major. Coordinates are about the two pivots given, so that they keep their
/// digits far from the origin.
struct StageValues {
  std::array<double, 3> source_pivot{};
  std::array<double, 3> target_pivot{};
  std::array<double, 3> source_centroid{}; ///< about source_pivot
  std::array<double, 3> target_centroid{}; ///< about target_pivot
  std::array<double, 9> H{};               ///< cross-covariance, sum of p' q'^T
  std::array<double, 9> U{};
  std::array<double, 3> S{}; ///< singular values, largest first
  std::array<double, 9> V{};
  std::array<double, 9> R{};
  std::array<double, 3> t{}; ///< maps source about source_pivot to target about target_pivot
};

/// Time in milliseconds and number of commands, by stage or transfer.
struct StageTime {
  double milliseconds = 0;
  unsigned count = 0;
};
using StageTimes = std::map<std::string, StageTime>;

/// What one align() did.
struct AlignmentResult {
  bool converged = false;
  Reason reason = Reason::NotRun;
  std::string message;      ///< the cause, when reason is Error, Cancelled or NoCorrespondences,
  std::exception_ptr error; ///< and the exception; null where there was none
  int iterations = 0;
  std::vector<std::size_t> searched; ///< of each iteration, source points whose match had to be searched for
  std::size_t inliers = 0;           ///< correspondences of the last iteration, after rejection
  double rmse_before = 0; ///< root mean square distance of the first iteration's correspondences at the guess
  double rmse = 0;        ///< the same of the last iteration's correspondences at the final transformation
  /// Root mean square, over all source points that took part, of the distance to the nearest target point; a point
  /// without one within the maximum correspondence distance counts as at that distance (without a maximum as nothing).
  /// Before rejection, so that it is of the same points at the guess and
  double truncated_rmse_before = 0;
  double truncated_rmse = 0; ///< at the final transformation: where this is less, the alignment improved
  Degeneracy degeneracy = Degeneracy::None;
  int free_motions = 0; ///< how many motions Degeneracy::Sliding stands for
  /// At the final transformation. None where there are too few pairs, or an estimation or, for point-to-plane, a search
  /// of the caller's.
  std::optional<Uncertainty> uncertainty;
  /// Of the final transformation: judge() tells whether to believe it. None where there are too few pairs, or it was
  /// not asked for.
  std::optional<Quality> quality;
  std::size_t source_points = 0;  ///< source points that took part
  std::size_t source_dropped = 0; ///< source points that are not finite or beyond largest_coordinate
  std::size_t target_points = 0;  ///< distinct target points that took part; coincident ones count once
  std::size_t target_dropped = 0; ///< target points that are not finite, beyond largest_coordinate or repeat another

  DeviceInfo device;
  Pipeline pipeline = Pipeline::Fused;
  Precision precision = Precision::Float;
  Metric metric = Metric::Point; ///< with an estimator of the caller's other than point-to-plane, Point as well
  Loss loss;
  double loss_scale = 0; ///< of the last iteration; 0: there was no loss
  Motions motions = Motions::Rigid;
  CorrespondenceSearch search = CorrespondenceSearch::PclKdTree;
  unsigned threads = 1;               ///< host threads that searched
  std::vector<StageRequest> requests; ///< of the last iteration
  std::size_t device_bytes = 0;       ///< what matching and estimation hold on the device
  StageTimes device_times;            ///< per stage and transfer, from the device's event timers
  /// "start" (device and kernels), "tree", "normals" (of the target, point-to-plane), "pack" (the source), "search"
  /// (with DeviceKdTree or the default search the whole pass over the pairs), "estimate" (where listed pairs are
  /// estimated apart), "quality", "total"
  StageTimes host_times;
};

} // namespace pcl_gpu_icp
