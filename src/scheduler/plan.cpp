#include "plan.h"

#include <algorithm>

namespace pcl_gpu_icp::scheduler {

Plan::Plan(std::size_t capacity, Policy policy, std::size_t most_overtaken)
: capacity_(std::max<std::size_t>(capacity, 1))
, policy_(policy)
, most_overtaken_(most_overtaken)
, idle_(capacity_)
{
}

Plan::Ticket Plan::submit(std::size_t request)
{
  waiting_[++last_].request = std::clamp<std::size_t>(request, 1, capacity_);
  return last_;
}

Plan::Queue::iterator Plan::next()
{
  const auto oldest = waiting_.begin();
  // Whatever overtakes a later one overtakes the oldest, too: no other has been overtaken as often.
  if (policy_ == Policy::FirstComeFirstServed || oldest->second.overtaken >= most_overtaken_)
    return oldest;
  const auto by_request = [](const auto& a, const auto& b) { return a.second.request < b.second.request; };
  if (policy_ == Policy::SmallestFirst)
    return std::min_element(waiting_.begin(), waiting_.end(), by_request);
  const auto by_reverse = [&](const auto& a, const auto& b) { return by_request(b, a); };
  return std::min_element(waiting_.begin(), waiting_.end(), by_reverse);
}

std::optional<Plan::Ticket> Plan::startNext()
{
  if (waiting_.empty())
    return std::nullopt;
  const auto chosen = next();
  const auto [ticket, waited] = *chosen;
  if (waited.request > idle_)
    return std::nullopt;
  for (auto older = waiting_.begin(); older != chosen; ++older)
    ++older->second.overtaken;
  waiting_.erase(chosen);
  in_flight_[ticket] = waited.request;
  idle_ -= waited.request;
  return ticket;
}

void Plan::narrow(Ticket ticket, std::size_t kept)
{
  const auto found = in_flight_.find(ticket);
  if (found == in_flight_.end() || kept >= found->second)
    return;
  idle_ += found->second - kept;
  found->second = kept;
}

void Plan::end(Ticket ticket)
{
  narrow(ticket, 0);
  in_flight_.erase(ticket);
  waiting_.erase(ticket);
}

std::size_t Plan::held(Ticket ticket) const
{
  const auto found = in_flight_.find(ticket);
  return found == in_flight_.end() ? 0 : found->second;
}

} // namespace pcl_gpu_icp::scheduler
