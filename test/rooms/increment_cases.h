#pragma once

#include "device_cases.h"
#include "engine/matcher_internals.h"
#include "reference.h"

#include <cmath>
#include <limits>
#include <vector>

// What the tests of increments that a matcher makes have in common.

namespace pcl_gpu_icp::test {

/// A lattice's source: it turned by `angle` and shifted a little, with noise.
inline Cloud turned(const Cloud& lattice, Random& random, double angle)
{
  Cloud source = moved(lattice, motion(random.direction(), angle, random.direction() * 0.05));
  for (int i = 0; i < source.cols(); ++i)
    source.col(i) += (random.direction() * 0.02).cast<float>();
  return source;
}

/// Every third match, and the source points that they are of.
struct SomeMatches {
  std::vector<Correspondence> kept; ///< the last first: any order will do
  std::vector<int> columns;         ///< likewise
};

class IncrementCases : public OnDevice {
protected:
  static constexpr float infinity = std::numeric_limits<float>::infinity();

  static double tolerance() { return GetParam().precision == Precision::Double ? 2e-6 : 2e-5; }

  /// \param pairs_of a number and an angle
  /// \param matcher_of these pairs
  /// \param reference_of them, the transform
  template <typename PairsOf, typename MatcherOf, typename ReferenceOf>
  static void
  expectReferenceForEverySize(const PairsOf& pairs_of, const MatcherOf& matcher_of, const ReferenceOf& reference_of)
  {
    for (const std::size_t n : GetParam().sizes(4000)) {
      if (n < 12)
        continue;
      SCOPED_TRACE(n);
      // At the corners 0.3, so that nothing else is nearer.
      const auto pairs = pairs_of(n, 0.3 / std::cbrt(static_cast<double>(n)));
      Matcher matcher = matcher_of(pairs);
      const Matches found = matcher.match({}, infinity);
      EXPECT_EQ(found.increment.pairs, n);
      EXPECT_EQ(found.increment.degeneracy, Degeneracy::None);
      EXPECT_LT(rmsDifference(isometryOf(found.increment.transform), reference_of(pairs), pairs.source), tolerance());
    }
  }

  static SomeMatches everyThird(const Matcher& matcher)
  {
    SomeMatches some;
    for (const Correspondence& c : matcher.correspondences({}))
      if (c.source % 3 == 0) {
        EXPECT_EQ(c.source, c.target);
        some.kept.insert(some.kept.begin(), c);
        some.columns.insert(some.columns.begin(), c.source);
      }
    return some;
  }
};

} // namespace pcl_gpu_icp::test
