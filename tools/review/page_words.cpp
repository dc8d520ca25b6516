#include "tools/review/page_words.h"

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
  if (!found->is_array()) throw InputError(fmt::format("{} is no list", list));
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
  if (!number.is_number()) throw InputError(fmt::format("{} is no number", key));
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

void AddMeasured(const Json& page, const SaidBy& said, Word* word) {
  for (const Json& mark : Elements(page, "marks"))
    word->marks.push_back({TextAt(mark, "photo"), TextAt(mark, "mark"), VectorAt<2>(mark, "pixel"),
                           Number(At(mark, "sigma"), "sigma"), FlagAt(mark, "exact"), said});
  for (const Json& seen : Elements(page, "image_points"))
    word->image_points.push_back({TextAt(seen, "photo"), TextAt(seen, "point"),
                                  VectorAt<2>(seen, "pixel"), std::nullopt,
                                  Number(At(seen, "sigma"), "sigma"), said});
  for (const Json& point : Elements(page, "points"))
    word->points.push_back({TextAt(point, "point"), VectorAt<3>(point, "ground"),
                            VectorAt<3>(point, "sigma"), RoleNamed(TextAt(point, "role")), said});
}

void AddDecided(const Json& page, const SaidBy& said, Word* word) {
  for (const Json& one : Elements(page, "decisions"))
    word->decisions.push_back({TextAt(one, "photo"), KindNamed(TextAt(one, "decision")),
                               TextAt(one, "value"), TextAt(one, "reason"), said});
  word->no_marks = Pairs(page, "no_marks");
  word->no_image_points = Pairs(page, "no_image_points");
  for (const Json& name : Elements(page, "no_points")) {
    if (!name.is_string()) throw InputError("no_points must hold names");
    word->no_points.push_back(name.get<std::string>());
  }
  for (const auto& [photo, kind] : Pairs(page, "no_decisions"))
    word->no_decisions.emplace_back(photo, KindNamed(kind));
}

}  // namespace

PageWord WordOfPage(const std::string& text, const SaidBy& said) {
  const Json page = Json::parse(text, nullptr, false);
  if (page.is_discarded() || !page.is_object()) throw InputError("what the page says is no JSON");
  PageWord result{TextAt(page, "version"), {}};
  if (page.contains("about")) result.word.about = TextAt(page, "about");
  AddMeasured(page, said, &result.word);
  AddDecided(page, said, &result.word);
  return result;
}

std::vector<std::string> PhotosOf(const Word& word) {
  std::set<std::string> photos;
  for (const auto& mark : word.marks) photos.insert(mark.photo);
  for (const auto& seen : word.image_points) photos.insert(seen.photo);
  for (const auto& decision : word.decisions) photos.insert(decision.photo);
  for (const auto& [photo, mark] : word.no_marks) photos.insert(photo);
  for (const auto& [photo, point] : word.no_image_points) photos.insert(photo);
  for (const auto& [photo, kind] : word.no_decisions) photos.insert(photo);
  return {photos.begin(), photos.end()};
}

}  // namespace orient
