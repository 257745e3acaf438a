#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>

#include <string>
#include <vector>

// Pairs of clouds whose answer is known, for tests and benchmarks of what is said of an answer.
namespace made_pairs {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

struct Pair {
  std::string kind;   ///< "copy", "overlap 50", "part", "simulated room", "simulated street", "shared", "unrelated"
  std::string clouds; ///< which
  Cloud::Ptr source, target;
  Eigen::Affine3d truth, guess; ///< source to target; no truth for the unrelated

  bool isRelated() const { return kind != "unrelated"; }
};

/// Each at two guesses, one within a degree and a hundredth of the extent, the other anywhere. Those of scans only
/// where the folder is there. The same for the same seed.
std::vector<Pair> makePairs(const std::string& scans, int repetitions, unsigned seed);

/// Those of them that have half or more in common, each once, at a guess that is off by up to 30 degrees about the
/// centre of the target and a quarter of its root mean square radius, some tenth of its extent.
std::vector<Pair> makeNearbyPairs(const std::string& scans, int repetitions, unsigned seed);

/// Those of them that have half or more in common, and smooth hills, each once, at a guess anywhere: of any rotation
/// about the centre of the target, and as far as its extent.
std::vector<Pair> makeFarPairs(const std::string& scans, int repetitions, unsigned seed);

/// How far off, in spacings, a right answer may be.
constexpr double right_spacings = 3;

/// How far the source's points are, by root mean square, from where the truth has them.
double errorOf(const Pair& pair, const Eigen::Affine3d& answer);

} // namespace made_pairs
