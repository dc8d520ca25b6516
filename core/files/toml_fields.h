// Reading typed keys of a TOML document with errors that name file, line and key. Private to
// core/files: included by its .cpp files only.
#pragma once

#include <toml++/toml.h>

#include <Eigen/Core>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace orient {

// Throws InputError naming file, line and column where the text is not TOML.
toml::table ParseTomlFile(const std::string& path);

// One table of a document, knowing where it stands ("fiducials[2].symbol") and which keys it may
// have. Every failure is an InputError "<file>, line <n>: <key> <complaint>".
class TomlTable {
 public:
  // Throws where the table holds a key that is not in `known`, naming the nearest known one.
  // `table` must outlive this object.
  TomlTable(const toml::table& table, std::string file, std::string name,
            std::initializer_list<std::string_view> known);

  bool Has(std::string_view key) const { return table_.contains(key); }

  std::optional<std::string> FindText(std::string_view key) const;
  std::optional<double> FindNumber(std::string_view key) const;  // finite
  std::optional<double> FindSigma(std::string_view key) const;   // a standard deviation
  std::optional<int> FindCount(std::string_view key) const;      // a whole number
  std::optional<bool> FindFlag(std::string_view key) const;      // true or false
  std::optional<std::vector<double>> FindNumbers(std::string_view key) const;
  std::optional<std::vector<std::string>> FindTexts(std::string_view key) const;
  std::optional<Eigen::Vector2d> FindVector2(std::string_view key) const;
  std::optional<Eigen::Vector2i> FindCounts2(std::string_view key) const;

  // The same for a key that must be there and, where named so, positive and not empty.
  std::string Text(std::string_view key) const;
  double Number(std::string_view key) const;
  double PositiveNumber(std::string_view key) const;
  Eigen::Vector2d Vector2(std::string_view key) const;
  std::vector<Eigen::Vector2d> Points2(std::string_view key) const;  // [[x, y], ...]

  std::optional<TomlTable> FindTable(std::string_view key,
                                     std::initializer_list<std::string_view> known) const;
  // Tables of a list of tables, none where the key is absent.
  std::vector<TomlTable> Tables(std::string_view key,
                                std::initializer_list<std::string_view> known) const;
  // The same where the known keys depend on what a table holds, as (table, place) pairs.
  std::vector<std::pair<const toml::table*, std::string>> RawTables(std::string_view key) const;
  // Every key of a table whose keys are names the user chose, with its place.
  std::vector<std::pair<std::string, TomlTable>> NamedTables(
      std::string_view key, std::initializer_list<std::string_view> known) const;

  const std::string& File() const { return file_; }
  // About one key (or, with "", the table itself).
  [[noreturn]] void Fail(std::string_view key, const std::string& complaint) const;

 private:
  [[noreturn]] void FailAt(const toml::node& node, const std::string& name,
                           const std::string& complaint) const;
  std::string NameOf(std::string_view key) const;
  const toml::array* FindArray(std::string_view key, const std::string& expected) const;

  const toml::table& table_;
  std::string file_;
  std::string name_;
};

// The known word with the smallest edit distance, empty where none is near enough to be meant.
std::string NearestWord(std::string_view word, const std::vector<std::string_view>& known);

}  // namespace orient
