#include "core/files/json_fields.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <iterator>
#include <limits>

#include "core/base/atomic_write.h"
#include "core/base/error.h"

namespace orient {
namespace {

// For a message. Lists and objects are not written out: that would recurse to their depth, which an
// untrusted file can make arbitrarily large.
std::string Shown(const Json& value) {
  if (value.is_array()) return "a list";
  if (value.is_object()) return "an object";
  constexpr std::size_t kLongest = 80;
  const std::string text = value.dump();
  return text.size() <= kLongest ? text : text.substr(0, kLongest) + "...";
}

// Single-pass iterator over a file's characters: incrementing one copy invalidates the others.
class FileCharacters {
 public:
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using iterator_category = std::input_iterator_tag;
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
  void operator++(int) { ++*this; }
  bool operator==(const FileCharacters& other) const {
    return rest_.empty() == other.rest_.empty();
  }

 private:
  FilePieces* pieces_ = nullptr;
  std::string_view rest_;
};
static_assert(std::input_iterator<FileCharacters>);

[[noreturn]] void RefuseAsNoJson(const std::string& path, const std::exception& error) {
  throw InputError(path + " is not valid JSON: " + error.what());
}

// Builds a document as it is parsed, without the elements of the lists that have readers. (The
// library's parser with a callback walks a list anew after each of its objects.)
class DocumentWithoutElements : public nlohmann::json_sax<Json> {
 public:
  DocumentWithoutElements(std::string file, const JsonElementReaders& readers)
      : file_(std::move(file)), readers_(readers) {}

  Json Take() { return std::move(document_); }

  bool null() override { return Value(nullptr); }
  bool boolean(bool value) override { return Value(value); }
  bool number_integer(number_integer_t value) override { return Value(value); }
  bool number_unsigned(number_unsigned_t value) override { return Value(value); }
  bool number_float(number_float_t value, const string_t&) override { return Value(value); }
  bool string(string_t& value) override { return Value(std::move(value)); }
  bool binary(binary_t& value) override { return Value(std::move(value)); }
  bool start_object(std::size_t) override { return Open(Json::object()); }
  bool start_array(std::size_t) override { return Open(Json::array()); }
  bool end_object() override { return Close(); }
  bool end_array() override { return Close(); }

  bool key(string_t& name) override {
    key_ = std::move(name);
    if (open_.back()->contains(key_))
      throw InputError(
          fmt::format("{}: \"{}\" occurs twice in an object; remove one", file_, key_));
    if (open_.size() != 1) return true;
    reader_ = readers_.find(key_);
    count_ = 0;
    return true;
  }

  bool parse_error(std::size_t, const std::string&, const Json::exception& error) override {
    RefuseAsNoJson(file_, error);
  }

 private:
  Json* Add(Json value) {
    if (open_.empty()) {
      document_ = std::move(value);
      return &document_;
    }
    Json& parent = *open_.back();
    if (parent.is_object()) return &(parent[key_] = std::move(value));
    parent.push_back(std::move(value));
    return &parent.back();
  }
  bool Value(Json value) {
    Add(std::move(value));
    HandOver();
    return true;
  }
  // Until it is closed, nothing is added to the open ones, so that pointers to them stay valid.
  bool Open(Json value) {
    open_.push_back(Add(std::move(value)));
    return true;
  }
  bool Close() {
    open_.pop_back();
    HandOver();
    return true;
  }
  // Passes a complete element of a list to the list's reader.
  void HandOver() {
    constexpr std::size_t kInList = 2;
    if (open_.size() != kInList || !open_.back()->is_array() || reader_ == readers_.end()) return;
    auto& list = open_.back()->get_ref<Json::array_t&>();
    reader_->second(JsonField(list.back(), file_, fmt::format("{}[{}]", reader_->first, count_++)));
    list.pop_back();
  }

  std::string file_;
  const JsonElementReaders& readers_;
  JsonElementReaders::const_iterator reader_ = readers_.end();  // of the list that is being read
  Json document_;
  std::vector<Json*> open_;  // lists and objects, the document first
  std::string key_;
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
  const JsonElementReaders none;
  DocumentWithoutElements document(path, none);
  Json::sax_parse(ReadFile(path), &document);
  return document.Take();
}

Json ParseJsonFile(const std::string& path, const JsonElementReaders& readers) {
  FilePieces pieces(path);
  DocumentWithoutElements document(path, readers);
  Json::sax_parse(FileCharacters(&pieces), FileCharacters(), &document);
  return document.Take();
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
