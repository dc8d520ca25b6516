#include "core/exchange/text_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/number_text.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::vector<std::string> Words(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  std::string word;
  while (stream >> word) words.push_back(word);
  return words;
}

// Position after the closing quote of a quoted first word; 0 if there is no such word.
std::size_t EndOfQuoted(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t");
  if (first == std::string::npos || line[first] != '"') return 0;
  std::size_t i = first + 1;
  for (; i < line.size(); ++i) {
    if (line[i] != '"') continue;
    if (i + 1 == line.size() || line[i + 1] != '"') return i + 1;
    ++i;
  }
  return 0;
}

// Programs in Fortran write 1.234D+02.
std::string WithExponentE(std::string word) {
  const std::size_t d = word.find_first_of("Dd");
  const bool exponent =
      d != std::string::npos && d > 0 &&
      (std::isdigit(static_cast<unsigned char>(word[d - 1])) != 0 || word[d - 1] == '.');
  if (exponent) word[d] = 'E';
  return word;
}

std::string Unquoted(const std::string& quoted) {
  const std::size_t first = quoted.find('"') + 1;
  std::string word;
  for (std::size_t i = first; i + 1 < quoted.size(); ++i) {
    word += quoted[i];
    i += quoted[i] == '"' ? 1 : 0;
  }
  return word;
}

}  // namespace

std::string QuotedWord(const std::string& word) {
  if (word.find_first_of(" \t,\"") == std::string::npos && !word.starts_with('#')) return word;
  std::string quoted = "\"";
  for (const char c : word) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

TextLine::TextLine(std::string file, int number, const std::string& line)
    : file_(std::move(file)), number_(number), line_(line) {
  std::size_t at = EndOfQuoted(line);
  if (at > 0) {
    words_.push_back(Unquoted(line.substr(0, at)));
    begins_.push_back(0);
  }
  for (const std::string& word : Words(line.substr(at))) {
    begins_.push_back(line_.find(word, at));
    at = begins_.back() + word.size();
    words_.push_back(word);
  }
}

std::string TextLine::Rest(std::size_t i, const std::string& what) const {
  Word(i, what);
  return line_.substr(begins_[i], line_.find_last_not_of(" \t\r") + 1 - begins_[i]);
}

const std::string& TextLine::Word(std::size_t i, const std::string& what) const {
  if (i >= words_.size())
    Fail(fmt::format("lacks {} (word {}); the line has {} words", what, i + 1, words_.size()));
  return words_[i];
}

double TextLine::Number(std::size_t i, const std::string& what) const {
  return ParseNumber(Word(i, what), Where(), what);
}

int TextLine::Count(std::size_t i, const std::string& what) const {
  return WholeNumber(Number(i, what), Where(), what);
}

std::string TextLine::Where() const { return fmt::format("{}, line {}", file_, number_); }

void TextLine::Fail(const std::string& complaint) const {
  throw InputError(Where() + ": " + complaint);
}

std::vector<TextLine> ReadAllTextLines(const std::string& path, const std::string& comments,
                                       char blank) {
  std::istringstream stream(ReadFile(path));
  std::vector<TextLine> lines;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::replace(line.begin() + static_cast<std::ptrdiff_t>(EndOfQuoted(line)), line.end(), blank,
                 ' ');
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first != std::string::npos && comments.find(line[first]) != std::string::npos) continue;
    lines.emplace_back(path, number, line);
  }
  return lines;
}

std::vector<TextLine> ReadTextLines(const std::string& path, const std::string& comments,
                                    char blank) {
  std::vector<TextLine> lines = ReadAllTextLines(path, comments, blank);
  std::erase_if(lines, [](const TextLine& line) { return line.Size() == 0; });
  return lines;
}

double ParseNumber(const std::string& word, const std::string& where, const std::string& what) {
  const auto number = SignedNumberIn(WithExponentE(word));
  if (!number)
    throw InputError(fmt::format("{}: {} is \"{}\"; it must be a number", where, what, word));
  return *number;
}

int WholeNumber(double number, const std::string& where, const std::string& what) {
  if (number != std::floor(number) || std::abs(number) > 1e9)
    throw InputError(fmt::format("{}: {} is {}; it must be a whole number", where, what, number));
  return static_cast<int>(number);
}

std::vector<double> ParseNumbers(const std::string& text, const std::string& where,
                                 const std::string& what) {
  std::vector<double> numbers;
  for (const std::string& word : Words(text)) numbers.push_back(ParseNumber(word, where, what));
  return numbers;
}

std::vector<std::string> FilesNamed(const std::string& directory, const std::string& begins,
                                    const std::string& ends) {
  std::vector<std::string> paths;
  std::error_code error;
  for (fs::directory_iterator i(directory, error), end; !error && i != end; i.increment(error)) {
    const std::string name = i->path().filename().string();
    if (name.starts_with(begins) && name.ends_with(ends)) paths.push_back(i->path().string());
  }
  if (error) throw InputError("cannot list the folder " + directory + ": " + error.message());
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace orient
