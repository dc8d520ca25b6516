// Reading the lines and words of other programs' text files, with errors that name file, line and
// value. Private to core/exchange.
#pragma once

#include <string>
#include <vector>

namespace orient {

// One line's words, split at blanks and tabs, knowing where they stand.
class TextLine {
 public:
  TextLine(std::string file, int number, std::vector<std::string> words)
      : file_(std::move(file)), number_(number), words_(std::move(words)) {}

  std::size_t Size() const { return words_.size(); }
  // Word `i`; throws InputError naming what is missing.
  const std::string& Word(std::size_t i, const std::string& what) const;
  double Number(std::size_t i, const std::string& what) const;
  int Count(std::size_t i, const std::string& what) const;
  // Throws InputError "<file>, line <n>: <complaint>".
  [[noreturn]] void Fail(const std::string& complaint) const;

 private:
  std::string file_;
  int number_;
  std::vector<std::string> words_;
};

// All lines that hold anything but a comment, which begins with one of `comments`. Throws
// InputError where the file cannot be read.
std::vector<TextLine> ReadTextLines(const std::string& path, const std::string& comments = "#",
                                    char blank = ' ');  // `blank` separates words, too
// Also empty lines, without words (COLMAP's images.txt has lines that may be empty).
std::vector<TextLine> ReadAllTextLines(const std::string& path, const std::string& comments,
                                       char blank = ' ');

// A number as the line would read it. Throws InputError "<where>: <what> is "<word>" ...".
double ParseNumber(const std::string& word, const std::string& where, const std::string& what);
// All numbers of a text.
std::vector<double> ParseNumbers(const std::string& text, const std::string& where,
                                 const std::string& what);

// "orient.tif" of a folder, for files that are looked for by their ending: sorted paths below
// `directory` whose names begin and end so. Throws InputError where the folder cannot be listed.
std::vector<std::string> FilesNamed(const std::string& directory, const std::string& begins,
                                    const std::string& ends);

}  // namespace orient
