#pragma once

namespace faults {

/// To be called at the beginning of each function. The code to fail with, or 0.
int failsNow(const char* function);

void countLive(const char* kind, long by);

} // namespace faults
