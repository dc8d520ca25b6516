#include "core/files/finding.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/files/finding_wordings.h"

namespace orient {
namespace {

const Wording& WordingOf(Reason reason) { return Wordings().at(static_cast<std::size_t>(reason)); }

}  // namespace

std::string_view Name(Status status) {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kWeak:
      return "weak";
    case Status::kFailed:
      return "failed";
  }
  throw std::invalid_argument("Name: not a Status");
}

std::string_view Code(Reason reason) { return WordingOf(reason).code; }

std::optional<Reason> ReasonFromCode(std::string_view code) {
  for (const Wording& wording : Wordings())
    if (wording.code == code) return wording.reason;
  return std::nullopt;
}

const std::vector<Reason>& AllReasons() {
  static const std::vector<Reason> kAll = [] {
    std::vector<Reason> all;
    for (const Wording& wording : Wordings()) all.push_back(wording.reason);
    return all;
  }();
  return kAll;
}

std::string Sentence(const Finding& finding) {
  const std::string_view where = finding.where;
  const std::size_t colon = std::min(where.find(": "), where.size());
  const bool one = finding.value == 1.0;
  const std::string unused = where.empty() ? "" : fmt::format("; not found or rejected: {}", where);
  return fmt::format(fmt::runtime(WordingOf(finding.reason).sentence),
                     fmt::arg("value", finding.value.value_or(0)),
                     fmt::arg("limit", finding.limit.value_or(0)), fmt::arg("where", where),
                     fmt::arg("unused", unused), fmt::arg("first", where.substr(0, colon)),
                     fmt::arg("rest", where.substr(std::min(colon + 2, where.size()))),
                     fmt::arg("s", one ? "" : "s"), fmt::arg("are", one ? "is" : "are"),
                     fmt::arg("their", one ? "its" : "their"),
                     fmt::arg("They_have", one ? "It has" : "They have"));
}

std::vector<std::string> Sentences(const Findings& findings) {
  std::vector<std::string> sentences;
  for (const Finding& finding : findings) sentences.push_back(Sentence(finding));
  return sentences;
}

std::string JoinedSentences(const Findings& findings) {
  return fmt::format("{}", fmt::join(Sentences(findings), "; "));
}

Status StatusOf(const Findings& findings) {
  Status status = Status::kOk;
  for (const Finding& finding : findings) status = std::max(status, finding.at_best);
  return status;
}

bool Has(const Findings& findings, Reason reason) {
  return std::any_of(findings.begin(), findings.end(),
                     [&](const Finding& finding) { return finding.reason == reason; });
}

}  // namespace orient
