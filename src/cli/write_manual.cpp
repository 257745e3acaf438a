#include "cli/command_line.h"
#include "cli/completion.h"
#include "cli/manual_page.h"

#include <cstdio>
#include <fstream>

namespace pcl_gpu_icp::cli {
namespace {

bool write(const char* path, const std::string& text)
{
  std::ofstream file(path, std::ios::binary);
  file << text << std::flush;
  if (!file)
    std::fprintf(stderr, "cannot write %s\n", path);
  return file.good();
}

} // namespace
} // namespace pcl_gpu_icp::cli

int main(int argc, char** argv)
{
  using namespace pcl_gpu_icp::cli;
  if (argc != 5) {
    std::fputs("usage: write_manual DATE MANUAL_PAGE BASH_COMPLETION ZSH_COMPLETION\n", stderr);
    return 2;
  }
  Run nothing;
  const auto app = makeCommandLine(nothing);
  const bool written = write(argv[2], manualPage(*app, argv[1])) && write(argv[3], bashCompletion(*app)) &&
                       write(argv[4], zshCompletion(*app));
  return written ? 0 : 1;
}
