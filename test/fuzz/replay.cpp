#include "harness.h"

#include "cli/input_file.h"

#include <filesystem>

/// Calls a harness with each file of the folders named, where there is no fuzzer to do so.
int main(int argc, char** argv)
{
  namespace fs = std::filesystem;
  std::size_t inputs = 0;
  for (int i = 1; i < argc; ++i)
    for (const auto& entry : fs::directory_iterator(argv[i])) {
      const std::string content = pcl_gpu_icp::cli::readFile(entry.path().string());
      // A copy of its own size, so that a read past it is seen.
      const std::unique_ptr<std::uint8_t[]> bytes(new std::uint8_t[content.size()]);
      std::memcpy(bytes.get(), content.data(), content.size());
      LLVMFuzzerTestOneInput(bytes.get(), content.size());
      ++inputs;
    }
  std::printf("%zu inputs\n", inputs);
  return inputs > 0 ? 0 : 1;
}
