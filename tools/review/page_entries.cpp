#include "tools/review/page_entries.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.h"

namespace orient {
namespace {
using Json = nlohmann::json;

// The elements of a list that may be absent.
std::vector<Json> Elements(const Json& page, const char* list) {
  const auto found = page.find(list);
  if (found == page.end()) return {};
  if (!found->is_array()) throw InputError(fmt::format("{} is not a list", list));
  return {found->begin(), found->end()};
}

const Json& At(const Json& element, const char* key) {
  if (!element.is_object() || !element.contains(key))
    throw InputError(fmt::format("{} is missing", key));
  return element.at(key);
}

std::string TextAt(const Json& element, const char* key) {
  const Json& text = At(element, key);
  if (!text.is_string()) throw InputError(fmt::format("{} is no text", key));
  return text.get<std::string>();
}

double Number(const Json& number, const char* key) {
  if (!number.is_number()) throw InputError(fmt::format("{} is not a number", key));
  return number.get<double>();
}

template <int kSize>
Eigen::Matrix<double, kSize, 1> VectorAt(const Json& element, const char* key) {
  const Json& list = At(element, key);
  if (!list.is_array() || list.size() != kSize)
    throw InputError(fmt::format("{} must be {} numbers", key, kSize));
  Eigen::Matrix<double, kSize, 1> vector;
  for (int i = 0; i < kSize; ++i) vector[i] = Number(list.at(i), key);
  return vector;
}

bool FlagAt(const Json& element, const char* key) {
  const Json& flag = At(element, key);
  if (!flag.is_boolean()) throw InputError(fmt::format("{} must be true or false", key));
  return flag.get<bool>();
}

DecisionKind KindNamed(const std::string& name) {
  if (const auto kind = DecisionKindFromName(name)) return *kind;
  throw InputError(fmt::format("there is no decision \"{}\"", name));
}

PointRole RoleNamed(const std::string& name) {
  if (name != "control" && name != "check")
    throw InputError(fmt::format("role is \"{}\"; it must be control or check", name));
  return name == "check" ? PointRole::kCheck : PointRole::kControl;
}

std::vector<std::pair<std::string, std::string>> Pairs(const Json& page, const char* list) {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const Json& pair : Elements(page, list)) {
    if (!pair.is_array() || pair.size() != 2 || !pair.at(0).is_string() || !pair.at(1).is_string())
      throw InputError(fmt::format("{} must hold pairs of names", list));
    pairs.emplace_back(pair.at(0).get<std::string>(), pair.at(1).get<std::string>());
  }
  return pairs;
}

void AddMeasured(const Json& page, const Attribution& attribution, Entry* entry) {
  for (const Json& mark : Elements(page, "marks"))
    entry->marks.push_back({TextAt(mark, "photo"), TextAt(mark, "mark"), VectorAt<2>(mark, "pixel"),
                            Number(At(mark, "sigma"), "sigma"), FlagAt(mark, "exact"),
                            attribution});
  for (const Json& seen : Elements(page, "image_points"))
    entry->image_points.push_back({TextAt(seen, "photo"), TextAt(seen, "point"),
                                   VectorAt<2>(seen, "pixel"), std::nullopt,
                                   Number(At(seen, "sigma"), "sigma"), attribution});
  for (const Json& point : Elements(page, "points"))
    entry->points.push_back({TextAt(point, "point"), VectorAt<3>(point, "ground"),
                             VectorAt<3>(point, "sigma"), RoleNamed(TextAt(point, "role")),
                             attribution});
}

void AddDecided(const Json& page, const Attribution& attribution, Entry* entry) {
  for (const Json& one : Elements(page, "decisions"))
    entry->decisions.push_back({TextAt(one, "photo"), KindNamed(TextAt(one, "decision")),
                                TextAt(one, "value"), TextAt(one, "reason"), attribution});
  entry->no_marks = Pairs(page, "no_marks");
  entry->no_image_points = Pairs(page, "no_image_points");
  for (const Json& name : Elements(page, "no_points")) {
    if (!name.is_string()) throw InputError("no_points must hold names");
    entry->no_points.push_back(name.get<std::string>());
  }
  for (const auto& [photo, kind] : Pairs(page, "no_decisions"))
    entry->no_decisions.emplace_back(photo, KindNamed(kind));
}

}  // namespace

PageEntry EntryOfPage(const std::string& text, const Attribution& attribution) {
  const Json page = Json::parse(text, nullptr, false);
  if (page.is_discarded() || !page.is_object()) throw InputError("what the page says is no JSON");
  PageEntry result{TextAt(page, "version"), {}};
  if (page.contains("about")) result.entry.about = TextAt(page, "about");
  AddMeasured(page, attribution, &result.entry);
  AddDecided(page, attribution, &result.entry);
  return result;
}

std::vector<std::string> PhotosOf(const Entry& entry) {
  std::set<std::string> photos;
  for (const auto& mark : entry.marks) photos.insert(mark.photo);
  for (const auto& seen : entry.image_points) photos.insert(seen.photo);
  for (const auto& decision : entry.decisions) photos.insert(decision.photo);
  for (const auto& [photo, mark] : entry.no_marks) photos.insert(photo);
  for (const auto& [photo, point] : entry.no_image_points) photos.insert(photo);
  for (const auto& [photo, kind] : entry.no_decisions) photos.insert(photo);
  return {photos.begin(), photos.end()};
}

}  // namespace orient
