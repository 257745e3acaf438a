#include "select.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

namespace pcl_gpu_icp::search {

namespace {

constexpr std::ptrdiff_t few = 10; ///< are sorted by insertion
constexpr std::size_t samples = 128;

/// A point as it is moved: in one register.
using Words = std::uint32_t __attribute__((vector_size(sizeof(PlacedPoint))));

Words wordsOf(const PlacedPoint& point)
{
  Words words;
  std::memcpy(&words, &point, sizeof(words));
  return words;
}

/// Integers that are ordered as the coordinates, with the position as the last digits.
template <int axis>
std::uint64_t keyOf(const PlacedPoint& point)
{
  std::uint32_t bits = 0;
  std::memcpy(&bits, &point.xyz[axis], sizeof(bits));
  const std::uint32_t sign = 0x80000000U;
  bits ^= bits & sign ? ~0U : sign;
  return std::uint64_t{bits} << 32 | static_cast<std::uint32_t>(point.position);
}

/// Brings the points whose key is less than `end` to the front, without a branch (Lomuto's scheme).
/// \return the first of the others
template <int axis>
PlacedPoint* partition(PlacedPoint* first, PlacedPoint* last, std::uint64_t end)
{
  PlacedPoint* next = first;
  for (PlacedPoint* point = first; point != last; ++point) {
    const bool is_less = keyOf<axis>(*point) < end;
    const Words here = wordsOf(*point), there = wordsOf(*next);
    std::memcpy(point, &there, sizeof(there));
    std::memcpy(next, &here, sizeof(here));
    next += is_less ? 1 : 0;
  }
  return next;
}

template <int axis>
void sortFew(PlacedPoint* first, PlacedPoint* last)
{
  for (PlacedPoint* point = first + 1; point < last; ++point)
    for (PlacedPoint* p = point; p != first && keyOf<axis>(p[0]) < keyOf<axis>(p[-1]); --p)
      std::swap(p[-1], p[0]);
}

/// A key on the far side of that of `nth`, so that what is next to be looked at is little (Floyd and Rivest 1975).
template <int axis>
std::uint64_t pivotFor(const PlacedPoint* first, const PlacedPoint* nth, const PlacedPoint* last)
{
  const auto count = static_cast<std::size_t>(last - first), before = static_cast<std::size_t>(nth - first);
  std::array<std::uint64_t, samples> keys;
  const std::size_t taken = count < 600 ? 3 : count < 8192 ? samples / 4 : samples;
  for (std::size_t i = 0; i < taken; ++i)
    // At no fixed step: an organised cloud repeats itself at one.
    keys[i] = keyOf<axis>(first[i * count / taken + i * 0x9E3779B9U % (count / taken)]);
  const std::size_t margin = taken / 32, at = before * taken / count;
  const std::size_t wanted = 2 * before < count ? std::min(at + margin, taken - 1) : at - std::min(margin, at);
  std::nth_element(keys.begin(), keys.begin() + wanted, keys.begin() + taken);
  return keys[wanted];
}

template <int axis>
void select(PlacedPoint* first, PlacedPoint* nth, PlacedPoint* last)
{
  while (last - first > few) {
    const std::uint64_t pivot = pivotFor<axis>(first, nth, last);
    PlacedPoint* middle = partition<axis>(first, last, pivot);
    if (middle == first) { // The pivot is the least.
      middle = partition<axis>(first, last, pivot + 1);
      if (nth < middle)
        return;
    }
    (nth < middle ? last : first) = middle;
  }
  sortFew<axis>(first, last);
}

} // namespace

void selectAlong(int axis, PlacedPoint* first, PlacedPoint* nth, PlacedPoint* last)
{
  axis == 0 ? select<0>(first, nth, last) : axis == 1 ? select<1>(first, nth, last) : select<2>(first, nth, last);
}

} // namespace pcl_gpu_icp::search
