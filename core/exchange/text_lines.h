// Reading the lines and words of other programs' text files, with errors that name file, line and
// value. Private to core/exchange.
#pragma once

#include <string>
#include <vector>

namespace orient {

// One line's words, split at blanks and tabs, knowing where they stand. A first word in double
// quotes may hold some; a quote in it is doubled.
class TextLine {
 public:
  TextLine(std::string file, int number, const std::string& line);

  std::size_t Size() const { return words_.size(); }
  // Word `i`; throws InputError naming what is missing.
  const std::string& Word(std::size_t i, const std::string& what) const;
  // From word `i` to the line's end, with the blanks between: a name may hold some.
  std::string Rest(std::size_t i, const std::string& what) const;
  double Number(std::size_t i, const std::string& what) const;
  int Count(std::size_t i, const std::string& what) const;
  std::string Where() const;  // "<file>, line <n>"
  // Throws InputError "<file>, line <n>: <complaint>".
  [[noreturn]] void Fail(const std::string& complaint) const;

 private:
  std::string file_;
  int number_;
  std::string line_;
  std::vector<std::string> words_;
  std::vector<std::size_t> begins_;  // of the words in the line
};

// As the first word of a line: in quotes where it needs them.
std::string QuotedWord(const std::string& word);

// All lines that hold anything but a comment, which begins with one of `comments`. Throws
// InputError where the file cannot be read.
std::vector<TextLine> ReadTextLines(const std::string& path, const std::string& comments = "#",
                                    char blank = ' ');  // `blank` separates words, too
// Also empty lines, without words (COLMAP's images.txt has lines that may be empty).
std::vector<TextLine> ReadAllTextLines(const std::string& path, const std::string& comments,
                                       char blank = ' ');

// A number as the line would read it, its exponent after E or Fortran's D. Throws InputError
// "<where>: <what> is "<word>" ...".
double ParseNumber(const std::string& word, const std::string& where, const std::string& what);
// A number that counts something. Throws InputError where it is no whole one, or beyond 1e9.
int WholeNumber(double number, const std::string& where, const std::string& what);
// All numbers of a text.
std::vector<double> ParseNumbers(const std::string& text, const std::string& where,
                                 const std::string& what);

// Sorted paths of the files in `directory` (not in its subfolders) whose names begin with `begins`
// and end with `ends`. Throws InputError if the folder cannot be listed.
std::vector<std::string> FilesNamed(const std::string& directory, const std::string& begins,
                                    const std::string& ends);

}  // namespace orient
