#include "report/json_members.h"

#include "report/json_input.h"

#include <stdexcept>

namespace pcl_gpu_icp::report {
namespace {

std::string scalarText(const std::string& name, const nlohmann::json& value)
{
  if (value.is_array()) {
    std::string text;
    for (const auto& item : value) {
      if (!item.is_array() && !item.is_number())
        throw std::invalid_argument(name + " has " + item.dump() + " where it may have numbers");
      text += (text.empty() ? "" : " ") + scalarText(name, item);
    }
    return text;
  }
  if (value.is_object())
    throw std::invalid_argument(name + " is an object");
  return value.is_string() ? value.get<std::string>() : value.dump();
}

} // namespace

std::map<std::string, std::string> jsonMembers(std::string_view text)
{
  const nlohmann::json object = parseJson(text);
  if (!object.is_object())
    throw std::invalid_argument("is not a JSON object");
  std::map<std::string, std::string> members;
  for (const auto& [name, value] : object.items())
    if (!value.is_null())
      members[name] = scalarText(name, value);
  return members;
}

} // namespace pcl_gpu_icp::report
