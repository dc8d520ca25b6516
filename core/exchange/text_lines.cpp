#include "core/exchange/text_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"

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

}  // namespace

const std::string& TextLine::Word(std::size_t i, const std::string& what) const {
  if (i >= words_.size())
    Fail(fmt::format("lacks {} (word {}); the line has {} words", what, i + 1, words_.size()));
  return words_[i];
}

double TextLine::Number(std::size_t i, const std::string& what) const {
  return ParseNumber(Word(i, what), fmt::format("{}, line {}", file_, number_), what);
}

int TextLine::Count(std::size_t i, const std::string& what) const {
  const double number = Number(i, what);
  if (number != std::floor(number) || std::abs(number) > 1e9)
    Fail(fmt::format("{} is \"{}\"; it must be a whole number", what, Word(i, what)));
  return static_cast<int>(number);
}

void TextLine::Fail(const std::string& complaint) const {
  throw InputError(fmt::format("{}, line {}: {}", file_, number_, complaint));
}

std::vector<TextLine> ReadAllTextLines(const std::string& path, const std::string& comments,
                                       char blank) {
  std::istringstream stream(ReadFile(path));
  std::vector<TextLine> lines;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::replace(line.begin(), line.end(), blank, ' ');
    std::vector<std::string> words = Words(line);
    if (!words.empty() && comments.find(words.front().front()) != std::string::npos) continue;
    lines.emplace_back(path, number, std::move(words));
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
  const char* first = word.data();
  const char* last = first + word.size();
  if (first != last && *first == '+') ++first;
  double number = 0;
  const auto [end, error] = std::from_chars(first, last, number);
  if (first == last || error != std::errc() || end != last || !std::isfinite(number))
    throw InputError(fmt::format("{}: {} is \"{}\"; it must be a number", where, what, word));
  return number;
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
