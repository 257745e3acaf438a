#pragma once

#include <pcl_gpu_icp/schedule.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

namespace pcl_gpu_icp::scheduler {

/// Who of those that wait starts next on a device of limited capacity. Pure: no clock, no thread, no device.
///
/// The next one is chosen by the policy and starts when so much is idle as it requests. Nothing overtakes it meanwhile:
/// with SmallestFirst nothing else would fit either. What has been overtaken most_overtaken times by later ones is next
/// whatever its size, so nothing waits for ever.
class Plan {
public:
  using Ticket = std::uint64_t; ///< from 1, in the order of submission

  static constexpr std::size_t most_overtaken_by_default = 64;

  /// \param capacity what may be in flight together, e.g. work-items; at least 1
  explicit Plan(std::size_t capacity,
                Policy policy = Policy::SmallestFirst,
                std::size_t most_overtaken = most_overtaken_by_default);

  /// Waits from now on. A request for more than the capacity is one for all of it, to be used in several passes.
  Ticket submit(std::size_t request);

  /// Starts the next one if it fits. Called again until there is none, whenever something was submitted or given back.
  std::optional<Ticket> startNext();

  /// One in flight gives back all but `kept`, if that is less than it holds.
  void narrow(Ticket ticket, std::size_t kept);

  /// One in flight gives back all, or one that waits does so no longer. Of any other nothing changes.
  void end(Ticket ticket);

  std::size_t capacity() const { return capacity_; }
  std::size_t idle() const { return idle_; }
  std::size_t waiting() const { return waiting_.size(); }
  std::size_t inFlight() const { return in_flight_.size(); }

  /// What one in flight holds; 0 of any other.
  std::size_t held(Ticket ticket) const;

private:
  struct Waiting {
    std::size_t request = 0;
    std::size_t overtaken = 0; ///< times a later one started
  };
  using Queue = std::map<Ticket, Waiting>;

  Queue::iterator next();

  std::size_t capacity_;
  Policy policy_;
  std::size_t most_overtaken_;
  std::size_t idle_;
  Ticket last_ = 0;
  Queue waiting_;
  std::map<Ticket, std::size_t> in_flight_; ///< and what each holds
};

} // namespace pcl_gpu_icp::scheduler
