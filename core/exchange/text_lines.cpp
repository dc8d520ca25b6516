#include "core/files/exchange/text_lines.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "core/error.h"
#include "core/files/atomic_write.h"

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
    Fail("lacks " + what + " (word " + std::to_string(i + 1) + "); the line has " +
         std::to_string(words_.size()) + " words");
  return words_[i];
}

double TextLine::Number(std::size_t i, const std::string& what) const {
  return ParseNumber(Word(i, what), file_ + ", line " + std::to_string(number_), what);
}

int TextLine::Count(std::size_t i, const std::string& what) const {
  const double number = Number(i, what);
  if (number != std::floor(number) || std::abs(number) > 1e9)
    Fail(what + " is \"" + Word(i, what) + "\"; it must be a whole number");
  return static_cast<int>(number);
}

void TextLine::Fail(const std::string& complaint) const {
  throw InputError(file_ + ", line " + std::to_string(number_) + ": " + complaint);
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
    throw InputError(where + ": " + what + " is \"" + word + "\"; it must be a number");
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
