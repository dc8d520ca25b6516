#include "core/files/toml_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/geometry/sigma.h"

namespace orient {
namespace {

// Levenshtein's distance: insertions, deletions and substitutions that turn one word into another.
size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> previous(b.size() + 1), current(b.size() + 1);
  std::iota(previous.begin(), previous.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    current[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j)
      current[j + 1] = std::min(
          {previous[j + 1] + 1, current[j] + 1, previous[j] + (a[i] == b[j] ? size_t{0} : 1)});
    std::swap(previous, current);
  }
  return previous[b.size()];
}

std::string Joined(std::initializer_list<std::string_view> words) {
  std::string joined;
  for (const std::string_view word : words)
    joined += (joined.empty() ? "" : ", ") + std::string(word);
  return joined;
}

std::string Shown(const toml::node& node) {
  std::ostringstream text;
  if (const auto* value = node.as_string()) {
    text << '"' << value->get() << '"';
  } else if (const auto* number = node.as_integer()) {
    text << number->get();
  } else if (const auto* real = node.as_floating_point()) {
    text << real->get();
  } else {
    text << "a " << node.type();
  }
  return text.str();
}

}  // namespace

std::string NearestWord(std::string_view word, const std::vector<std::string_view>& known) {
  const auto distance = [&](std::string_view other) { return EditDistance(word, other); };
  const auto nearest = std::min_element(
      known.begin(), known.end(),
      [&](std::string_view a, std::string_view b) { return distance(a) < distance(b); });
  // If more than half of the word has to change, it is another word.
  if (nearest == known.end() || 2 * distance(*nearest) > std::max(word.size(), nearest->size()))
    return "";
  return std::string(*nearest);
}

namespace {

// The index after the text or comment that begins at `i` with a quotation mark or '#'.
std::size_t EndOfText(const std::string& toml, std::size_t i) {
  if (toml[i] == '#') return std::min(toml.find('\n', i), toml.size());
  const char quote = toml[i];
  const std::string three(3, quote);
  const bool lines = toml.compare(i, 3, three) == 0;
  for (std::size_t at = i + (lines ? 3 : 1); at < toml.size(); ++at) {
    if (quote == '"' && toml[at] == '\\') {
      ++at;  // what is escaped ends nothing
    } else if (lines ? toml.compare(at, 3, three) == 0 : toml[at] == quote) {
      at += lines ? 3 : 1;
      while (lines && at < toml.size() && toml[at] == quote) ++at;  // of the text, before its end
      return at;
    } else if (!lines && toml[at] == '\n') {
      return at;
    }
  }
  return toml.size();
}

// The parser recurses along a dotted key: one with thousands of parts would end the program.
void RefuseDeepKeys(const std::string& path, const std::string& text) {
  constexpr int kMostParts = 64;
  int dots = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'' || c == '#') {
      i = EndOfText(text, i);
      continue;
    }
    if (c == '\n' || c == '=' || c == '{' || c == ',') dots = 0;
    if (c == '.' && ++dots > kMostParts)
      throw InputError(fmt::format(
          "{}, line {}: a key of more than {} parts; check the file", path,
          1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(i), '\n'),
          kMostParts));
    ++i;
  }
}

}  // namespace

toml::table ParseTomlFile(const std::string& path) {
  const std::string text = ReadFile(path);
  RefuseDeepKeys(path, text);
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    const auto& begin = error.source().begin;
    throw InputError(fmt::format("{}, line {}, column {}: not valid TOML: {}", path, begin.line,
                                 begin.column, error.description()));
  }
}

TomlTable::TomlTable(const toml::table& table, std::string file, std::string name,
                     std::initializer_list<std::string_view> known)
    : table_(table), file_(std::move(file)), name_(std::move(name)) {
  for (const auto& [key, node] : table_) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    const std::string nearest = NearestWord(key.str(), known);
    FailAt(node, NameOf(key.str()),
           "is not a known key; " + (nearest.empty() ? "known here: " + Joined(known)
                                                     : "did you mean " + nearest + "?"));
  }
}

std::string TomlTable::NameOf(std::string_view key) const {
  if (key.empty()) return name_.empty() ? "the file" : name_;
  return name_.empty() ? std::string(key) : name_ + "." + std::string(key);
}

void TomlTable::FailAt(const toml::node& node, const std::string& name,
                       const std::string& complaint) const {
  const auto line = node.source().begin.line;
  throw InputError(fmt::format("{}{}: {} {}", file_,
                               line > 0 ? ", line " + std::to_string(line) : "", name, complaint));
}

void TomlTable::Fail(std::string_view key, const std::string& complaint) const {
  const toml::node* node = key.empty() ? nullptr : table_.get(key);
  FailAt(node != nullptr ? *node : table_, NameOf(key), complaint);
}

std::optional<std::string> TomlTable::FindText(std::string_view key) const {
  const toml::node* node = table_.get(key);
  if (node == nullptr) return std::nullopt;
  if (!node->is_string()) Fail(key, "must be text in quotes, not " + Shown(*node));
  return node->as_string()->get();
}

std::optional<double> TomlTable::FindNumber(std::string_view key) const {
  const toml::node* node = table_.get(key);
  if (node == nullptr) return std::nullopt;
  const auto number = node->is_number() ? node->value<double>() : std::nullopt;
  if (!number || !std::isfinite(*number)) Fail(key, "must be a number, not " + Shown(*node));
  return number;
}

std::optional<double> TomlTable::FindSigma(std::string_view key) const {
  const auto sigma = FindNumber(key);
  if (const std::string why = SigmaProblem(sigma.value_or(1)); !why.empty())
    Fail(key, fmt::format("is {:g}; {}", *sigma, why));
  return sigma;
}

std::optional<int> TomlTable::FindCount(std::string_view key) const {
  const toml::node* node = table_.get(key);
  if (node == nullptr) return std::nullopt;
  const auto number = node->is_integer() ? node->value<int>() : std::nullopt;
  if (!number) Fail(key, "must be a whole number, not " + Shown(*node));
  return number;
}

std::optional<bool> TomlTable::FindFlag(std::string_view key) const {
  const toml::node* node = table_.get(key);
  if (node == nullptr) return std::nullopt;
  if (!node->is_boolean()) Fail(key, "must be true or false, not " + Shown(*node));
  return node->value<bool>();
}

const toml::array* TomlTable::FindArray(std::string_view key, const std::string& expected) const {
  const toml::node* node = table_.get(key);
  if (node != nullptr && !node->is_array()) Fail(key, "must be " + expected);
  return node == nullptr ? nullptr : node->as_array();
}

std::optional<std::vector<double>> TomlTable::FindNumbers(std::string_view key) const {
  const toml::array* array = FindArray(key, "a list of numbers");
  if (array == nullptr) return std::nullopt;
  std::vector<double> numbers;
  for (const toml::node& node : *array) {
    const auto number = node.is_number() ? node.value<double>() : std::nullopt;
    if (!number || !std::isfinite(*number))
      FailAt(node, NameOf(key), "must hold numbers, not " + Shown(node));
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<std::vector<std::string>> TomlTable::FindTexts(std::string_view key) const {
  const toml::array* array = FindArray(key, "a list of strings in quotes");
  if (array == nullptr) return std::nullopt;
  std::vector<std::string> texts;
  for (const toml::node& node : *array) {
    if (!node.is_string())
      FailAt(node, NameOf(key), "must hold strings in quotes, not " + Shown(node));
    texts.push_back(node.as_string()->get());
  }
  return texts;
}

std::optional<Eigen::Vector2d> TomlTable::FindVector2(std::string_view key) const {
  const auto numbers = FindNumbers(key);
  if (!numbers) return std::nullopt;
  if (numbers->size() != 2) Fail(key, "must be two numbers in brackets");
  return Eigen::Vector2d((*numbers)[0], (*numbers)[1]);
}

std::optional<Eigen::Vector2i> TomlTable::FindCounts2(std::string_view key) const {
  const auto numbers = FindVector2(key);
  if (!numbers) return std::nullopt;
  const double limit = std::numeric_limits<int>::max();
  if (*numbers != numbers->array().round().matrix() || numbers->cwiseAbs().maxCoeff() > limit)
    Fail(key, "must be two whole numbers");
  return numbers->cast<int>();
}

std::string TomlTable::Text(std::string_view key) const {
  const auto text = FindText(key);
  if (!text) Fail("", "lacks the key " + std::string(key));
  if (text->empty()) Fail(key, "must not be empty");
  return *text;
}

double TomlTable::Number(std::string_view key) const {
  const auto number = FindNumber(key);
  if (!number) Fail("", "lacks the key " + std::string(key));
  return *number;
}

double TomlTable::PositiveNumber(std::string_view key) const {
  const double number = Number(key);
  if (number <= 0) Fail(key, fmt::format("is {}; it must be positive", Shown(*table_.get(key))));
  return number;
}

Eigen::Vector2d TomlTable::Vector2(std::string_view key) const {
  const auto vector = FindVector2(key);
  if (!vector) Fail("", "lacks the key " + std::string(key));
  return *vector;
}

std::vector<Eigen::Vector2d> TomlTable::Points2(std::string_view key) const {
  const std::string expected = "a list of points: [[x, y], [x, y], ...]";
  const toml::array* array = FindArray(key, expected);
  if (array == nullptr) Fail("", "lacks the key " + std::string(key));
  std::vector<Eigen::Vector2d> points;
  for (const toml::node& node : *array) {
    const toml::array* pair = node.as_array();
    const auto number = [&](size_t i) {
      const auto* item = pair != nullptr && pair->size() == 2 ? pair->get(i) : nullptr;
      const auto value =
          item != nullptr && item->is_number() ? item->value<double>() : std::nullopt;
      if (!value || !std::isfinite(*value)) FailAt(node, NameOf(key), "must be " + expected);
      return *value;
    };
    points.emplace_back(number(0), number(1));
  }
  return points;
}

std::optional<TomlTable> TomlTable::FindTable(std::string_view key,
                                              std::initializer_list<std::string_view> known) const {
  const toml::node* node = table_.get(key);
  if (node == nullptr) return std::nullopt;
  if (!node->is_table()) Fail(key, "must be a table");
  return TomlTable(*node->as_table(), file_, NameOf(key), known);
}

std::vector<std::pair<const toml::table*, std::string>> TomlTable::RawTables(
    std::string_view key) const {
  std::vector<std::pair<const toml::table*, std::string>> tables;
  const toml::array* array = FindArray(key, "a list of tables");
  if (array == nullptr) return tables;
  for (size_t i = 0; i < array->size(); ++i) {
    const toml::node& node = (*array)[i];
    const std::string name = fmt::format("{}[{}]", NameOf(key), i);
    if (!node.is_table()) FailAt(node, name, "must be a table, not " + Shown(node));
    tables.emplace_back(node.as_table(), name);
  }
  return tables;
}

std::vector<TomlTable> TomlTable::Tables(std::string_view key,
                                         std::initializer_list<std::string_view> known) const {
  std::vector<TomlTable> tables;
  for (const auto& [table, name] : RawTables(key)) tables.emplace_back(*table, file_, name, known);
  return tables;
}

std::vector<std::pair<std::string, TomlTable>> TomlTable::NamedTables(
    std::string_view key, std::initializer_list<std::string_view> known) const {
  std::vector<std::pair<std::string, TomlTable>> tables;
  const toml::node* node = table_.get(key);
  if (node == nullptr) return tables;
  if (!node->is_table()) Fail(key, "must be a table");
  for (const auto& [name, value] : *node->as_table()) {
    const std::string place = NameOf(key) + "." + std::string(name.str());
    if (!value.is_table()) FailAt(value, place, "must be a table, not " + Shown(value));
    tables.emplace_back(std::string(name.str()), TomlTable(*value.as_table(), file_, place, known));
  }
  return tables;
}

}  // namespace orient
