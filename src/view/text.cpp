#include "view/text.h"

#include "report/json.h"

#include <filesystem>

namespace pcl_gpu_icp::view {

std::string lineOf(const std::string& text)
{
  const auto valid =
      report::Json::parse(report::Json(text).dump(-1, ' ', false, report::Json::error_handler_t::replace));
  std::string line;
  for (const char c : valid.get_ref<const std::string&>())
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      line += "\xEF\xBF\xBD";
    else
      line += c;
  return line;
}

std::string fileNameOf(const std::string& path) { return lineOf(std::filesystem::path(path).filename().string()); }

} // namespace pcl_gpu_icp::view
