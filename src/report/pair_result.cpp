#include "report/pair_result.h"

#include "report/alignment_json.h"

#include <stdexcept>

namespace pcl_gpu_icp::report {
namespace {

constexpr PairStatus statuses[] = {PairStatus::Converged, PairStatus::NotConverged, PairStatus::Failed};

Json identityJson(const PairIdentity& identity)
{
  Json json;
  json["pair"] = identity.pair;
  json["source"] = identity.source;
  json["target"] = identity.target;
  json["options"] = Json::object();
  for (const auto& [name, value] : identity.options)
    json["options"][name] = value;
  return json;
}

PairStatus statusOf(const std::string& name)
{
  for (const PairStatus status : statuses)
    if (name == toString(status))
      return status;
  throw std::invalid_argument(name);
}

} // namespace

const char* toString(PairStatus status)
{
  switch (status) {
  case PairStatus::Converged:
    return "converged";
  case PairStatus::NotConverged:
    return "not converged";
  case PairStatus::Failed:
    return "failed";
  }
  return "unknown";
}

PairOutcome outcomeOf(const AlignmentReport& report)
{
  const AlignmentResult& result = report.result;
  PairOutcome outcome;
  outcome.status = result.converged ? PairStatus::Converged : PairStatus::NotConverged;
  outcome.transform = report.transform;
  outcome.why = toString(result.reason);
  outcome.iterations = result.iterations;
  outcome.warnings = report.warnings.size();
  if (result.inliers > 0)
    outcome.rmse = result.rmse;
  return outcome;
}

PairOutcome outcomeOf(const PairFailure& failure)
{
  PairOutcome outcome;
  outcome.why = failure.message;
  return outcome;
}

std::string resultLine(const PairIdentity& identity, const AlignmentReport& report)
{
  Json json = identityJson(identity);
  json["status"] = toString(outcomeOf(report).status);
  const Json alignment = alignmentJson(report);
  for (const auto& [name, value] : alignment.items())
    if (!json.contains(name))
      json[name] = value;
  return dumpLine(json);
}

std::string resultLine(const PairIdentity& identity, const PairFailure& failure)
{
  Json json = identityJson(identity);
  json["status"] = toString(PairStatus::Failed);
  json["error"] = {{"kind", failure.kind}, {"message", failure.message}};
  return dumpLine(json);
}

std::optional<ReadResult> readResultLine(std::string_view line)
{
  try {
    const Json json = Json::parse(line);
    ReadResult read;
    PairIdentity identity;
    identity.pair = read.pair = json.at("pair").get<std::size_t>();
    identity.source = json.at("source").get<std::string>();
    identity.target = json.at("target").get<std::string>();
    for (const auto& [name, value] : json.at("options").items())
      identity.options[name] = value.get<std::string>();
    read.identity = identityText(identity);

    PairOutcome& outcome = read.outcome;
    outcome.status = statusOf(json.at("status").get<std::string>());
    if (outcome.status == PairStatus::Failed) {
      outcome.why = json.at("error").at("message").get<std::string>();
      return read;
    }
    outcome.transform = transformOf(json.at("transform"));
    outcome.why = json.at("reason").get<std::string>();
    outcome.iterations = json.at("iterations").get<int>();
    if (!json.at("rmse").is_null())
      outcome.rmse = json.at("rmse").get<double>();
    return read;
  } catch (const Json::exception&) {
    return std::nullopt;
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

std::string identityText(const PairIdentity& identity) { return dumpLine(identityJson(identity)); }

} // namespace pcl_gpu_icp::report
