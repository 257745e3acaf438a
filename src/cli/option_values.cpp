#include "cli/option_values.h"

#include <algorithm>
#include <sstream>

namespace pcl_gpu_icp::cli {

OptionValues valuesOf(const CLI::Option& option)
{
  OptionValues values;
  values.any = option.get_expected_max() > 0;
  if (!values.any)
    return values;
  std::istringstream types(option.get_type_name());
  for (std::string type; std::getline(types, type, '|');) {
    type.resize(std::min(type.find('['), type.size()));
    if (type == "FILE")
      values.files = true;
    else if (type == "DIR")
      values.directories = true;
    else if (!type.empty() && type.front() >= 'a' && type.front() <= 'z')
      values.words.push_back(type);
  }
  return values;
}

} // namespace pcl_gpu_icp::cli
