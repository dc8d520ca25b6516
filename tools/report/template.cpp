#include "tools/report/template.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/base/trimmed.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {

[[noreturn]] void Fail(std::string_view name, const std::string& why) {
  throw std::logic_error(fmt::format("template {}: {}", name, why));
}

// The text for `name` in its file: "file" or "file#part".
std::string_view TemplateText(std::string_view name) {
  constexpr std::string_view kPart = "<!-- part: ";
  const size_t hash = name.find('#');
  std::string_view text = ReportFile(name.substr(0, hash));
  if (hash != std::string_view::npos) {
    const std::string begin = fmt::format("{}{} -->\n", kPart, name.substr(hash + 1));
    const size_t at = text.find(begin);
    if (at == std::string_view::npos) Fail(name, "the file has no such part");
    text.remove_prefix(at + begin.size());
  }
  return Trimmed(text.substr(0, text.find(kPart)));
}

// A pair of braces: its name, whether it takes markup, and where the text goes on behind it.
struct Place {
  std::string_view name;
  bool takes_markup;
  size_t end;
};

Place PlaceAt(std::string_view name, std::string_view text, size_t at) {
  const bool takes_markup = text.substr(at).starts_with("{{{");
  const std::string_view closing = takes_markup ? "}}}" : "}}";
  const size_t first = at + closing.size();
  const size_t last = text.find(closing, first);
  if (last == std::string_view::npos)
    Fail(name, fmt::format("the place \"{}\" has no end", text.substr(at, 30)));
  return {text.substr(first, last - first), takes_markup, last + closing.size()};
}

}  // namespace

Markup& Markup::operator+=(const Markup& more) {
  if (!text_.empty() && !more.text_.empty()) text_ += '\n';
  text_ += more.text_;
  return *this;
}

Markup FillText(std::string_view name, std::string_view text,
                const std::vector<Filling>& fillings) {
  std::string filled;
  std::vector<bool> used(fillings.size());
  size_t from = 0;
  for (size_t at; (at = text.find("{{", from)) != std::string_view::npos;) {
    filled += text.substr(from, at - from);
    const Place place = PlaceAt(name, text, at);
    const auto filling = std::find_if(fillings.begin(), fillings.end(),
                                      [&](const Filling& f) { return f.name == place.name; });
    if (filling == fillings.end())
      Fail(name, fmt::format("nothing is given for the place \"{}\"", place.name));
    if (filling->is_markup != place.takes_markup)
      Fail(name, fmt::format("the place \"{}\" takes {}", place.name,
                             place.takes_markup ? "markup, not text" : "text, not markup"));
    filled += place.takes_markup ? filling->text : Escape(filling->text);
    used[static_cast<size_t>(filling - fillings.begin())] = true;
    from = place.end;
  }
  for (size_t i = 0; i < fillings.size(); ++i)
    if (!used[i]) Fail(name, fmt::format("there is no place \"{}\"", fillings[i].name));
  return Markup(filled.append(text.substr(from)));
}

Markup Fill(std::string_view name, const std::vector<Filling>& fillings) {
  return FillText(name, TemplateText(name), fillings);
}

std::string_view ReportFile(std::string_view name) {
  for (const EmbeddedFile& file : ReportFiles())
    if (file.name == name) return file.contents;
  Fail(name, "data/report has no such file");
}

}  // namespace orient
