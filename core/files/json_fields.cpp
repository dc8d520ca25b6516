#include "core/files/json_fields.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/atomic_write.h"
#include "core/base/error.h"

namespace orient {
namespace {

// For a message. Of a list or an object only that: writing it out would follow its depth, which a
// stranger's file may make as large as it likes.
std::string Shown(const Json& value) {
  if (value.is_array()) return "a list";
  if (value.is_object()) return "an object";
  constexpr std::size_t kLongest = 80;
  const std::string text = value.dump();
  return text.size() <= kLongest ? text : text.substr(0, kLongest) + "...";
}

}  // namespace

void JsonField::Fail(const std::string& complaint) const {
  throw InputError(fmt::format("{}: {} {}", file_,
                               name_.empty() ? "the document" : "field " + name_, complaint));
}

JsonField JsonField::At(const std::string& key) const {
  if (!value_.is_object()) Fail("must be an object");
  const auto found = value_.find(key);
  if (found == value_.end()) Fail(fmt::format("lacks \"{}\"", key));
  return JsonField(*found, file_, name_.empty() ? key : name_ + "." + key);
}

std::optional<JsonField> JsonField::Find(const std::string& key) const {
  if (!value_.is_object()) Fail("must be an object");
  const auto found = value_.find(key);
  if (found == value_.end() || found->is_null()) return std::nullopt;
  return At(key);
}

std::vector<JsonField> JsonField::Elements() const {
  if (!value_.is_array()) Fail("must be a list");
  std::vector<JsonField> elements;
  for (size_t i = 0; i < value_.size(); ++i)
    elements.emplace_back(value_[i], file_, fmt::format("{}[{}]", name_, i));
  return elements;
}

std::string JsonField::AsString() const {
  if (!value_.is_string()) Fail("must be text, not " + Shown(value_));
  return value_.get<std::string>();
}

double JsonField::AsNumber() const {
  if (!value_.is_number()) Fail("must be a number, not " + Shown(value_));
  return value_.get<double>();
}

std::int64_t JsonField::AsInteger() const {
  if (!value_.is_number_integer()) Fail("must be a whole number, not " + Shown(value_));
  constexpr auto kLargest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (value_.is_number_unsigned() && value_.get<std::uint64_t>() > kLargest)
    Fail("is out of range: " + Shown(value_));
  return value_.get<std::int64_t>();
}

int JsonField::AsInt() const {
  const std::int64_t number = AsInteger();
  if (number < std::numeric_limits<int>::min() || number > std::numeric_limits<int>::max())
    Fail("is out of range: " + Shown(value_));
  return static_cast<int>(number);
}

bool JsonField::AsFlag() const {
  if (!value_.is_boolean()) Fail("must be true or false, not " + Shown(value_));
  return value_.get<bool>();
}

Eigen::Vector2d JsonField::AsVector2() const {
  const std::vector<JsonField> elements = Elements();
  if (elements.size() != 2) Fail("must be a pair of numbers, not " + Shown(value_));
  return {elements[0].AsNumber(), elements[1].AsNumber()};
}

Eigen::Vector3d JsonField::AsVector3() const {
  const std::vector<JsonField> elements = Elements();
  if (elements.size() != 3) Fail("must be three numbers, not " + Shown(value_));
  return {elements[0].AsNumber(), elements[1].AsNumber(), elements[2].AsNumber()};
}

Eigen::MatrixXd JsonField::AsMatrix(int rows, int cols) const {
  const std::string shape = fmt::format("{} x {}", rows, cols);
  const std::vector<JsonField> lines = Elements();
  if (std::ssize(lines) != rows) Fail(fmt::format("must be a {} matrix", shape));
  Eigen::MatrixXd matrix(rows, cols);
  for (int row = 0; row < rows; ++row) {
    const std::vector<JsonField> cells = lines[static_cast<size_t>(row)].Elements();
    if (std::ssize(cells) != cols) Fail(fmt::format("must be a {} matrix", shape));
    for (int col = 0; col < cols; ++col)
      matrix(row, col) = cells[static_cast<size_t>(col)].AsNumber();
  }
  return matrix;
}

std::vector<std::string> JsonField::AsStrings() const {
  std::vector<std::string> strings;
  for (const JsonField& element : Elements()) strings.push_back(element.AsString());
  return strings;
}

std::map<std::string, std::string> JsonField::FindTexts(const std::string& key) const {
  const auto field = Find(key);
  std::map<std::string, std::string> texts;
  if (!field || !field->value_.is_object()) return texts;
  for (const auto& [name, text] : field->value_.items()) {
    if (!text.is_string()) return {};
    texts[name] = text.get<std::string>();
  }
  return texts;
}

std::optional<double> JsonField::FindNumber(const std::string& key) const {
  const auto field = Find(key);
  return field ? std::optional(field->AsNumber()) : std::nullopt;
}

std::optional<Eigen::Vector2d> JsonField::FindVector2(const std::string& key) const {
  const auto field = Find(key);
  return field ? std::optional(field->AsVector2()) : std::nullopt;
}

std::optional<Eigen::Vector3d> JsonField::FindVector3(const std::string& key) const {
  const auto field = Find(key);
  return field ? std::optional(field->AsVector3()) : std::nullopt;
}

Json ParseJsonFile(const std::string& path) {
  const std::string text = ReadFile(path);
  try {
    return Json::parse(text);
  } catch (const Json::exception& error) {
    throw InputError(path + " is not valid JSON: " + error.what());
  }
}

Json MatrixJson(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    Json cells = Json::array();
    for (Eigen::Index col = 0; col < matrix.cols(); ++col) cells.push_back(matrix(row, col));
    rows.push_back(std::move(cells));
  }
  return rows;
}

Json ToJson(const std::optional<double>& number) {
  return number && std::isfinite(*number) ? Json(*number) : Json(nullptr);
}

Json ToJson(const std::optional<Eigen::Vector2d>& vector) {
  return vector && vector->allFinite() ? Json::array({vector->x(), vector->y()}) : Json(nullptr);
}

Json ToJson(const std::optional<Eigen::Vector3d>& vector) {
  if (!vector || !vector->allFinite()) return nullptr;
  return Json::array({vector->x(), vector->y(), vector->z()});
}

}  // namespace orient
