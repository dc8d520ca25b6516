#include "core/files/json_fields.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
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

// An input iterator over a file's characters.
class FileCharacters {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = char;

  FileCharacters() = default;  // the end of any file
  explicit FileCharacters(FilePieces* pieces) : pieces_(pieces), rest_(pieces->Next()) {}

  char operator*() const { return rest_.front(); }
  FileCharacters& operator++() {
    rest_.remove_prefix(1);
    if (rest_.empty()) rest_ = pieces_->Next();
    return *this;
  }
  bool operator==(const FileCharacters& other) const {
    return rest_.empty() == other.rest_.empty();
  }
  bool operator!=(const FileCharacters& other) const { return !(*this == other); }

 private:
  FilePieces* pieces_ = nullptr;
  std::string_view rest_;
};

// What the parser tells of each value it has read: keeps it, or hands it to its list's reader.
class ElementsToReaders {
 public:
  ElementsToReaders(const std::string& file, const JsonElementReaders& readers)
      : file_(file), readers_(readers) {}

  bool operator()(int depth, Json::parse_event_t event, const Json& value) {
    using Event = Json::parse_event_t;
    if (depth == 1 && event == Event::key) {
      list_ = value.get<std::string>();
      count_ = 0;
    }
    const bool is_element = depth == 2 && (event == Event::object_end ||
                                           event == Event::array_end || event == Event::value);
    const auto reader = is_element ? readers_.find(list_) : readers_.end();
    if (reader == readers_.end()) return true;
    reader->second(JsonField(value, file_, fmt::format("{}[{}]", list_, count_++)));
    return false;
  }

 private:
  const std::string& file_;
  const JsonElementReaders& readers_;
  std::string list_;
  std::size_t count_ = 0;
};

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

Json ParseJsonFile(const std::string& path, const JsonElementReaders& readers) {
  FilePieces pieces(path);
  ElementsToReaders to_readers(path, readers);
  try {
    return Json::parse(FileCharacters(&pieces), FileCharacters(),
                       [&](int depth, Json::parse_event_t event, Json& value) {
                         return to_readers(depth, event, value);
                       });
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
