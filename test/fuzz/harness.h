#pragma once

#include "cli/failure.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

/// What libFuzzer calls with each input, and replay.cpp with each file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace pcl_gpu_icp::fuzz {

/// Ends the process where something that must hold does not.
inline void require(bool holds, const char* what)
{
  if (holds)
    return;
  std::fprintf(stderr, "fuzz: %s\n", what);
  std::abort();
}

inline std::string_view textOf(const std::uint8_t* data, std::size_t size)
{
  return {reinterpret_cast<const char*>(data), size};
}

/// A reader may refuse its input by one line that names the file, and in no other way.
/// \return whether it did not
template <typename Read>
bool reads(const std::string& path, Read read)
{
  try {
    read();
    return true;
  } catch (const cli::Failure& failure) {
    const std::string_view line = failure.what();
    require(failure.code() == cli::ExitCode::Input, "a refusal of a file has the kind Input");
    require(line.substr(0, path.size() + 1) == path + ":" && line.size() > path.size() + 2,
            "a refusal names the file and says what is wrong");
    require(line.size() < path.size() + 600, "a refusal is short");
    return false;
  }
}

} // namespace pcl_gpu_icp::fuzz
