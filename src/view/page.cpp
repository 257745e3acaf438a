#include "view/page.h"

#include "embedded_page.h"

#include <ctime>
#include <stdexcept>

namespace pcl_gpu_icp::view {
namespace {

using report::Json;

std::string embedded(const std::string& name)
{
  for (const EmbeddedFile& file : embedded_files)
    if (name == file.name)
      return file.text;
  throw std::logic_error("no file " + name + " is embedded");
}

std::string now()
{
  const std::time_t time = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&time, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &utc);
  return text;
}

std::string deviceText(const DeviceInfo& device)
{
  return device.name + " (" + toString(device.type) + ", " + device.platform + ", driver " + device.driver + ")";
}

} // namespace

Json repeatJson(const Repetition& repetition, const std::vector<DeviceInfo>& devices, const Json& settings)
{
  Json facts = settings;
  for (const DeviceInfo& device : devices)
    facts[devices.size() == 1 ? "device" : "device " + std::to_string(facts.size())] = deviceText(device);
  facts["versions"] = repetition.versions;
  facts["directory"] = repetition.directory;
  facts["made"] = now();
  return {{"command", repetition.command}, {"facts", facts}};
}

std::vector<std::string> pairScripts()
{
  return {"three.min.js", "OrbitControls.js", "chart.min.js", "page.js", "scene.js", "charts.js", "pair.js"};
}

std::string pageOf(const std::vector<std::string>& templates,
                   const PageData& data,
                   const Json& run,
                   const std::vector<std::string>& scripts)
{
  std::string html = embedded("page.html");
  const auto fill = [&html](const std::string& place, const std::string& content) {
    const std::string mark = "{{" + place + "}}";
    html.replace(html.find(mark), mark.size(), content);
  };
  // From the end on, so that no mark is looked for in what was filled in.
  std::string code, parts;
  for (const std::string& name : scripts)
    code += "<script>\n" + embedded(name) + "\n</script>\n";
  for (const std::string& name : templates)
    parts += embedded(name);
  fill("scripts", code);
  fill("data", data.html(run));
  fill("templates", parts);
  fill("style", embedded("page.css"));
  return html;
}

} // namespace pcl_gpu_icp::view
