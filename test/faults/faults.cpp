#include "faults.h"

#include "fault_point.h"

#include <atomic>
#include <mutex>

namespace faults {
namespace {

struct State {
  std::mutex mutex;
  Fault fault;
  std::map<std::string, unsigned long> calls;
  std::map<std::string, long> live;
};

State& state()
{
  static State& only = *new State; // outlives every caller
  return only;
}

std::atomic<std::size_t> smallest_bytes{static_cast<std::size_t>(-1)};

} // namespace

std::size_t smallestBytes() { return smallest_bytes; }

void arm(const Fault& fault)
{
  State& self = state();
  const std::lock_guard<std::mutex> lock(self.mutex);
  self.fault = fault;
  self.calls.clear();
  smallest_bytes = fault.smallest_bytes;
}

void disarm() { arm({}); }

std::map<std::string, unsigned long> calls()
{
  const std::lock_guard<std::mutex> lock(state().mutex);
  return state().calls;
}

std::map<std::string, long> live()
{
  const std::lock_guard<std::mutex> lock(state().mutex);
  return state().live;
}

int failsNow(const char* function)
{
  State& self = state();
  const std::lock_guard<std::mutex> lock(self.mutex);
  const unsigned long call = ++self.calls[function];
  return self.fault.function == function && self.fault.call == call ? self.fault.code : 0;
}

void countLive(const char* kind, long by)
{
  const std::lock_guard<std::mutex> lock(state().mutex);
  state().live[kind] += by;
}

} // namespace faults
