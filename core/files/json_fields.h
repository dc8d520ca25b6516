// Reading typed fields of a JSON document with errors that name file and field. Private to
// core/files: included by its .cpp files only.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace orient {

using Json = nlohmann::ordered_json;  // fields stay in the order of docs/conventions.md

// One value of a document, knowing where it stands ("marks[2].pixel").
class JsonField {
 public:
  JsonField(const Json& value, std::string file, std::string name = "")
      : value_(value), file_(std::move(file)), name_(std::move(name)) {}

  // A field that must be there.
  JsonField At(const std::string& key) const;
  // Empty where the field is absent or null.
  std::optional<JsonField> Find(const std::string& key) const;
  std::vector<JsonField> Elements() const;

  std::string AsString() const;
  double AsNumber() const;
  std::int64_t AsInteger() const;
  int AsInt() const;
  bool AsFlag() const;
  Eigen::Vector2d AsVector2() const;
  Eigen::Vector3d AsVector3() const;
  // Rows of equal, given size.
  Eigen::MatrixXd AsMatrix(int rows, int cols) const;
  std::vector<std::string> AsStrings() const;

  // An object of texts. Empty where the field is absent or something else.
  std::map<std::string, std::string> FindTexts(const std::string& key) const;
  std::optional<double> FindNumber(const std::string& key) const;
  std::optional<Eigen::Vector2d> FindVector2(const std::string& key) const;
  std::optional<Eigen::Vector3d> FindVector3(const std::string& key) const;

  // Throws InputError: "<file>: field <name> <complaint>".
  [[noreturn]] void Fail(const std::string& complaint) const;

 private:
  const Json& value_;
  std::string file_;
  std::string name_;
};

// Parses a whole file. Throws InputError naming file, line and column.
Json ParseJsonFile(const std::string& path);

// The same of a file that is too large to be held whole: elements of the lists that `readers` names
// (members of the document, each there once) go to their reader one by one, and are not in what is
// returned.
using JsonElementReaders = std::map<std::string, std::function<void(const JsonField&)>>;
Json ParseJsonFile(const std::string& path, const JsonElementReaders& readers);

Json MatrixJson(const Eigen::Ref<const Eigen::MatrixXd>& matrix);
// null for an empty optional and for a number that JSON cannot hold (NaN, infinity).
Json ToJson(const std::optional<double>& number);
Json ToJson(const std::optional<Eigen::Vector2d>& vector);
Json ToJson(const std::optional<Eigen::Vector3d>& vector);

}  // namespace orient
