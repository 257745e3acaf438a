#include "report/json_input.h"

#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_gpu_icp::report {
namespace {

using Json = nlohmann::json;

constexpr std::size_t most_levels = 32;

/// Sees a text while it is parsed.
class Inspector {
public:
  void see(Json::parse_event_t event, const Json& parsed)
  {
    switch (event) {
    case Json::parse_event_t::object_start:
    case Json::parse_event_t::array_start:
      if (keys_.size() == most_levels)
        throw std::invalid_argument("is nested deeper than " + std::to_string(most_levels) + " levels");
      keys_.emplace_back();
      return;
    case Json::parse_event_t::object_end:
    case Json::parse_event_t::array_end:
      keys_.pop_back();
      return;
    case Json::parse_event_t::key:
      if (!keys_.back().insert(parsed.get<std::string>()).second)
        throw std::invalid_argument("has " + parsed.get<std::string>() + " twice");
      return;
    case Json::parse_event_t::value:
      return;
    }
  }

private:
  std::vector<std::set<std::string>> keys_; ///< of what is open, the outermost first
};

} // namespace

nlohmann::json parseJson(std::string_view text)
{
  // The parser takes it for the end of the text.
  if (text.find('\0') != std::string_view::npos)
    throw std::invalid_argument("is not JSON: it has a NUL byte");
  Inspector inspector;
  try {
    return Json::parse(text, [&inspector](int, Json::parse_event_t event, const Json& parsed) {
      inspector.see(event, parsed);
      return true;
    });
  } catch (const Json::exception& error) {
    throw std::invalid_argument(std::string("is not JSON: ") + error.what());
  }
}

} // namespace pcl_gpu_icp::report
