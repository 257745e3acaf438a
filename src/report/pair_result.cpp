#include "report/pair_result.h"

#include "report/alignment_json.h"
#include "report/ending.h"
#include "report/json_input.h"
#include "report/judgement.h"

#include <limits>
#include <stdexcept>

namespace pcl_gpu_icp::report {
namespace {

constexpr PairStatus statuses[] = {
    PairStatus::Converged, PairStatus::AtLimit, PairStatus::NotConverged, PairStatus::Failed};
constexpr Verdict verdicts[] = {Verdict::Good, Verdict::Doubtful, Verdict::Wrong};

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

/// A whole number from 0; the JSON library would turn any number, true and false into one.
template <typename Number>
Number wholeNumber(const nlohmann::json& value)
{
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > std::uint64_t(std::numeric_limits<Number>::max()))
    throw std::invalid_argument("is no whole number");
  return value.get<Number>();
}

double number(const nlohmann::json& value)
{
  if (!value.is_number())
    throw std::invalid_argument("is no number");
  return value.get<double>();
}

/// Of matrixJson(), to the bit.
RigidTransform transformOf(const nlohmann::json& matrix)
{
  RigidTransform transform;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      transform.rotation[3 * row + column] = number(matrix.at(row).at(column));
    transform.translation[row] = number(matrix.at(row).at(3));
  }
  return transform;
}

template <typename Named, std::size_t count>
Named named(const Named (&all)[count], const std::string& name)
{
  for (const Named one : all)
    if (name == toString(one))
      return one;
  throw std::invalid_argument(name);
}

} // namespace

const char* toString(PairStatus status)
{
  switch (status) {
  case PairStatus::Converged:
    return "converged";
  case PairStatus::AtLimit:
    return "at the limit";
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
  const Ending ending = endingOf(report);
  outcome.status = ending == Ending::Converged ? PairStatus::Converged
                   : ending == Ending::AtLimit ? PairStatus::AtLimit
                                               : PairStatus::NotConverged;
  outcome.got_worse = ending == Ending::GotWorse;
  outcome.transform = report.transform;
  if (!isAnswer(ending))
    outcome.why = endingText(report);
  outcome.judgement = judgementOf(report);
  if (result.quality)
    outcome.near = result.quality->after.source;
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
    const nlohmann::json json = parseJson(line);
    ReadResult read;
    PairIdentity identity;
    identity.pair = read.pair = wholeNumber<std::size_t>(json.at("pair"));
    identity.source = json.at("source").get<std::string>();
    identity.target = json.at("target").get<std::string>();
    for (const auto& [name, value] : json.at("options").get_ref<const nlohmann::json::object_t&>())
      identity.options[name] = value.get<std::string>();
    read.identity = identityText(identity);

    PairOutcome& outcome = read.outcome;
    outcome.status = named(statuses, json.at("status").get<std::string>());
    if (outcome.status == PairStatus::Failed) {
      outcome.why = json.at("error").at("message").get<std::string>();
      return read;
    }
    outcome.transform = transformOf(json.at("transform"));
    if (!isAnswer(outcome.status)) {
      outcome.got_worse = json.at("ending").get<std::string>() == toString(Ending::GotWorse);
      outcome.why = json.at("why").get<std::string>();
    }
    outcome.judgement = {named(verdicts, json.at("verdict").get<std::string>()),
                         json.at("reasons").get<std::vector<std::string>>()};
    if (!json.at("quality").is_null())
      outcome.near = number(json.at("quality").at("source_near").at("after"));
    outcome.iterations = wholeNumber<int>(json.at("iterations"));
    if (!json.at("rmse").is_null())
      outcome.rmse = number(json.at("rmse"));
    return read;
  } catch (const Json::exception&) {
    return std::nullopt;
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

std::string identityText(const PairIdentity& identity) { return dumpLine(identityJson(identity)); }

} // namespace pcl_gpu_icp::report
