#include "report/json_members.h"

#include "report/json.h"

#include <stdexcept>

namespace pcl_gpu_icp::report {
namespace {

std::string scalarText(const std::string& name, const Json& value)
{
  if (value.is_array()) {
    std::string text;
    for (const Json& item : value) {
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
  std::string twice;
  std::map<std::string, int> keys;
  Json object;
  try {
    object = Json::parse(text, [&](int depth, Json::parse_event_t event, const Json& key) {
      if (event == Json::parse_event_t::key && depth == 1 && ++keys[key.get<std::string>()] > 1)
        twice = key.get<std::string>();
      return true;
    });
  } catch (const Json::exception& error) {
    throw std::invalid_argument(std::string("is not JSON: ") + error.what());
  }
  if (!object.is_object())
    throw std::invalid_argument("is not a JSON object");
  if (!twice.empty())
    throw std::invalid_argument("has " + twice + " twice");
  std::map<std::string, std::string> members;
  for (const auto& [name, value] : object.items())
    if (!value.is_null())
      members[name] = scalarText(name, value);
  return members;
}

} // namespace pcl_gpu_icp::report
