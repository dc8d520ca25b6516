#include "core/files/result_fields.h"

#include <algorithm>
#include <cmath>

namespace orient {
namespace {

// JSON has no infinity, which is the precision of a pose that nothing determines.
double Finite(double value) {
  constexpr double kMost = 1e9;
  return std::isnan(value) ? kMost : std::clamp(value, -kMost, kMost);
}

}  // namespace

Json FindingJson(const Finding& finding) {
  Json json = {{"code", Code(finding.reason)}, {"at_best", Name(finding.at_best)}};
  if (finding.value) json["value"] = Finite(*finding.value);
  if (finding.limit) json["limit"] = Finite(*finding.limit);
  if (!finding.where.empty()) json["where"] = finding.where;
  return json;
}

Reason ReadReason(const JsonField& code) {
  const auto reason = ReasonFromCode(code.AsString());
  if (!reason) code.Fail("is \"" + code.AsString() + "\", which this version does not know");
  return *reason;
}

Finding ReadFinding(const JsonField& field) {
  Finding finding{ReadReason(field.At("code")), FromName(field.At("at_best"), kStatuses)};
  finding.value = field.FindNumber("value");
  finding.limit = field.FindNumber("limit");
  if (const auto where = field.Find("where")) finding.where = where->AsString();
  return finding;
}

void WriteFindings(const Findings& findings, Json* json) {
  Json list = Json::array();
  for (const Finding& finding : findings) list.push_back(FindingJson(finding));
  (*json)["findings"] = std::move(list);
  (*json)["messages"] = Sentences(findings);
}

Findings ReadFindings(const JsonField& root) {
  Findings findings;
  if (const auto field = root.Find("findings")) {
    for (const JsonField& one : field->Elements()) findings.push_back(ReadFinding(one));
    return findings;
  }
  for (std::string& message : root.At("messages").AsStrings())
    findings.push_back(Stated(std::move(message)));
  return findings;
}

}  // namespace orient
