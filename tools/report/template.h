// Markup (HTML, and XML alike) from templates: the files of data/report, filled in by name.
//
// `{{name}}` is a place for text, which is escaped; `{{{name}}}` one for markup, which is not.
// There is no more to the language: what is repeated or left out is filled in as often as needed by
// the caller. In a file, the line `<!-- part: name -->` begins a template of its own, so that the
// row of a table can stand below its table. Blanks around a template do not belong to it.
#pragma once

#include <concepts>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/embedded_file.h"

namespace orient {

// What needs no escaping. A type of its own: text from a file cannot pass for it unnoticed.
class Markup {
 public:
  Markup() = default;
  explicit Markup(std::string text) : text_(std::move(text)) {}

  const std::string& Text() const { return text_; }
  bool Empty() const { return text_.empty(); }
  Markup& operator+=(const Markup& more);  // on a new line

 private:
  std::string text_;
};

// One name and what stands in its places.
struct Filling {
  Filling(std::string_view its_name, const Markup& markup)
      : name(its_name), text(markup.Text()), is_markup(true) {}
  Filling(std::string_view its_name, std::string its_text)
      : name(its_name), text(std::move(its_text)) {}
  Filling(std::string_view its_name, std::string_view its_text) : name(its_name), text(its_text) {}
  Filling(std::string_view its_name, const char* its_text) : name(its_name), text(its_text) {}
  Filling(std::string_view its_name, std::integral auto number)
      : name(its_name), text(std::to_string(number)) {}

  std::string_view name;
  std::string text;
  bool is_markup = false;
};

// `name` is for messages. Throws std::logic_error naming template and place where a place has no
// filling, a filling no place, text stands for markup or markup for text, or a place has no end.
Markup FillText(std::string_view name, std::string_view text, const std::vector<Filling>& fillings);

// The template "file.html" or "file.html#part" of data/report. Throws std::logic_error as FillText
// does, and where there is no such template: the files are part of the program.
Markup Fill(std::string_view name, const std::vector<Filling>& fillings = {});

// A file of data/report as it is. Throws std::logic_error where there is none.
std::string_view ReportFile(std::string_view name);

// All of them; made by orient_embed().
std::span<const EmbeddedFile> ReportFiles();

}  // namespace orient
